//! Springs that tie the surface of a solid to its inside, so that no particle can give way.

use crate::mesh::clean::interior::Interior;
use crate::mesh::clean::topology::Sets;
use crate::nearby::Nearby;
use glam::{DMat3, DVec3};
use std::collections::BTreeSet;

/// Springs from each surface particle inward, if there is anything to hold on to.
const BRACES: usize = 4;
/// Springs all round: their reach, in spacings, the cosine of the least angle between those of a
/// particle, and the most that it begins.
const REACH: f64 = 2.6;
const APART: f64 = 0.94;
pub(crate) const MOST_ROUND: usize = 60;
/// The fewest springs of a particle.
const FEWEST: usize = 4;
/// The least stiffness of a particle against any direction, in units of one spring along it.
const LEAST_SUPPORT: f64 = 0.25;
/// Springs that tie a piece of the lattice that nothing else holds.
const TIES: usize = 8;

/// The springs that tie a surface to its inside.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Braces {
    /// A few, inward: enough to hold it.
    Inward,
    /// Many, to whatever is near: enough for shares by which the body is as stiff as its material.
    AllRound,
}

/// A body being tied together: all its points, the surface first.
pub(crate) struct Frame<'a> {
    pub(crate) points: &'a [DVec3],
    /// The number of points on the surface.
    pub(crate) surface: usize,
    /// Outward directions of the surface points, of length one.
    pub(crate) normals: &'a [DVec3],
    /// The body that each point belongs to.
    pub(crate) pieces: &'a [usize],
    pub(crate) inside: &'a Interior<'a>,
    pub(crate) spacing: f64,
    /// Pairs joined so far, the lower first.
    pub(crate) joined: BTreeSet<[usize; 2]>,
}

impl Frame<'_> {
    /// Adds springs until every particle is held in all directions and each piece hangs together.
    /// Returns them in order, and the number of particles that are loose all the same: those of a
    /// flat body.
    pub(crate) fn brace(mut self, braces: Braces) -> (Vec<[usize; 2]>, usize) {
        let before = self.joined.clone();
        let nearby = Nearby::new(self.points, self.spacing);
        // Apart, as there may be a hundred surface points for each inner one within reach.
        let inner = Nearby::new(&self.points[self.surface..], self.spacing);
        for point in 0..self.surface {
            match braces {
                Braces::Inward => self.brace_inward(point, (&inner, &nearby)),
                Braces::AllRound => self.brace_all_round(point, &nearby),
            }
        }
        let mut directions = vec![Vec::new(); self.points.len()];
        for &[a, b] in &self.joined {
            note(&mut directions, self.points, [a, b]);
        }
        for point in 0..self.points.len() {
            self.support(point, &nearby, &mut directions);
        }
        self.tie_islands(&nearby);
        let loose = directions.iter().filter(|directions| !is_supported(directions)).count();
        (self.joined.difference(&before).copied().collect(), loose)
    }

    /// Ties a surface point to the nearest inner ones; where the body is too thin to have any, to
    /// the surface on its other side.
    fn brace_inward(&mut self, point: usize, (inner, all): (&Nearby, &Nearby)) {
        let place = self.points[point];
        let mut count = 0;
        for other in inner.within(place, 2.0 * self.spacing) {
            if count < BRACES {
                count += usize::from(self.join([point, self.surface + other], false));
            }
        }
        if BRACES <= count {
            return;
        }
        for other in all.within(place, 3.0 * self.spacing) {
            let reach = self.points[other] - place;
            // Within 60 degrees of straight inward.
            let across = 0.5 * reach.length() < -self.normals[point].dot(reach);
            if other < self.surface && across && count < BRACES {
                count += usize::from(self.join([point, other], false));
            }
        }
    }

    /// Ties a surface point to near points in every direction, on the surface and inside.
    fn brace_all_round(&mut self, point: usize, all: &Nearby) {
        let place = self.points[point];
        let mut ways: Vec<DVec3> = Vec::new();
        for other in all.within(place, REACH * self.spacing) {
            let way = (self.points[other] - place).normalize_or_zero();
            if other != point && ways.iter().all(|known| known.dot(way) < APART) {
                ways.push(way);
                self.join([point, other], false);
            }
        }
    }

    /// Ties a point to its nearest neighbours until it cannot give way in any direction; if that
    /// does not suffice, even across a gap.
    fn support(&mut self, point: usize, nearby: &Nearby, directions: &mut [Vec<DVec3>]) {
        for across_gaps in [false, true] {
            let mut radius = 1.5 * self.spacing;
            while !is_supported(&directions[point]) && radius < 25.0 * self.spacing {
                for other in nearby.within(self.points[point], radius) {
                    if is_supported(&directions[point]) {
                        break;
                    }
                    if self.join([point, other], across_gaps) {
                        note(directions, self.points, [point, other]);
                    }
                }
                radius *= 2.0;
            }
        }
    }

    /// Ties pieces of the lattice that reach no surface particle to the points nearest to them.
    fn tie_islands(&mut self, nearby: &Nearby) {
        let mut sets = Sets::new(self.points.len());
        for &[a, b] in &self.joined {
            sets.join(a, b);
        }
        // The lowest member of a set is on the surface if any is: the surface comes first.
        for point in self.surface..self.points.len() {
            if sets.find(point) < self.surface {
                continue;
            }
            let root = sets.find(point);
            let island: Vec<usize> =
                (point..self.points.len()).filter(|&other| sets.find(other) == root).collect();
            let mut ties = Vec::new();
            let mut radius = 2.0 * self.spacing;
            while ties.len() < TIES && radius < 1e3 * self.spacing {
                ties.clear();
                for &from in &island {
                    let near = nearby.within(self.points[from], radius).into_iter();
                    let outside = near.filter(|&other| {
                        self.pieces[other] == self.pieces[from] && sets.find(other) != root
                    });
                    ties.extend(outside.map(|other| [from, other]));
                }
                radius *= 2.0;
            }
            let length = |&[a, b]: &[usize; 2]| self.points[a].distance(self.points[b]);
            ties.sort_by(|a, b| length(a).total_cmp(&length(b)).then(a.cmp(b)));
            for [a, b] in ties.into_iter().take(TIES) {
                self.joined.insert([a.min(b), a.max(b)]);
                sets.join(a, b);
            }
        }
    }

    /// Joins two points unless they are joined, belong to different bodies, or theirs has a gap
    /// between them that must not be crossed. Returns whether it did.
    fn join(&mut self, [a, b]: [usize; 2], across_gaps: bool) -> bool {
        let pair = [a.min(b), a.max(b)];
        if a == b || self.pieces[a] != self.pieces[b] || self.joined.contains(&pair) {
            return false;
        }
        let middle = (self.points[a] + self.points[b]) / 2.0;
        (across_gaps || self.inside.contains(middle)) && self.joined.insert(pair)
    }
}

fn note(directions: &mut [Vec<DVec3>], points: &[DVec3], [a, b]: [usize; 2]) {
    let direction = (points[b] - points[a]).normalize_or_zero();
    directions[a].push(direction);
    directions[b].push(direction);
}

/// Whether springs along these directions hold a particle in all directions.
///
/// The sum S of the outer products d dᵀ is the stiffness of the particle, in units of one spring.
/// Its least eigenvalue is above λ where all leading minors of S − λ are positive (Sylvester).
fn is_supported(directions: &[DVec3]) -> bool {
    if directions.len() < FEWEST {
        return false;
    }
    let mut sum = DMat3::from_diagonal(DVec3::splat(-LEAST_SUPPORT));
    for &d in directions {
        sum += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    let [x, y] = [sum.x_axis, sum.y_axis];
    0.0 < x.x && 0.0 < x.x * y.y - x.y * x.y && 0.0 < sum.determinant()
}
