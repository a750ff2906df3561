//! Sizes of surfaces at rest, and how often a pattern fits along them.

use msd_core::{Body, Pattern, Real, Snapshot};

/// Repeats of the patterns of the bodies along their texture coordinates. They are kept until the
/// surfaces change.
#[derive(Debug, Default)]
pub(crate) struct Sizes {
    bodies: Vec<(Key, Vec<[f32; 2]>)>,
}

/// The inputs of the repeats of a body; another surface of as many corners counts as the same.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    corners: usize,
    triangles: usize,
    pattern: Pattern,
    size: f32,
}

impl Sizes {
    /// Returns how often the pattern fits along u and v at each corner of body number `index`.
    pub fn repeats<R: Real>(
        &mut self,
        (index, body): (usize, &Body),
        snapshot: &Snapshot<'_, R>,
    ) -> &[[f32; 2]] {
        let key = Key {
            corners: body.surface.corners.len(),
            triangles: body.surface.triangles.len(),
            pattern: body.look.pattern,
            size: body.look.pattern_size,
        };
        let blank = Key { corners: usize::MAX, ..key };
        if self.bodies.len() <= index {
            self.bodies.resize(index + 1, (blank, Vec::new()));
        }
        let kept = &mut self.bodies[index];
        if kept.0 != key {
            *kept = (key, repeats(body, &Lengths::new(body, snapshot)));
        }
        &kept.1
    }
}

/// Rest lengths of the springs of a body, by their ends.
struct Lengths(Vec<([u32; 2], f32)>);

impl Lengths {
    fn new<R: Real>(body: &Body, snapshot: &Snapshot<'_, R>) -> Self {
        let springs = body.springs.clone().filter_map(|spring| {
            let &[a, b] = snapshot.ends.get(spring)?;
            let length = snapshot.rest_lengths.get(spring)?.to_f64() as f32;
            Some(([a.min(b), a.max(b)], length))
        });
        let mut springs: Vec<_> = springs.collect();
        springs.sort_unstable_by_key(|spring| spring.0);
        Lengths(springs)
    }

    fn of(&self, [a, b]: [u32; 2]) -> Option<f32> {
        let pair = [a.min(b), a.max(b)];
        let found = self.0.binary_search_by_key(&pair, |spring| spring.0).ok()?;
        Some(self.0[found].1)
    }
}

/// Sums over the edges of a connected part of a surface: those of a fit of L² = U² du² + V² dv².
#[derive(Clone, Copy, Default)]
struct Fit {
    uu: f64,
    uv: f64,
    vv: f64,
    ul: f64,
    vl: f64,
}

impl Fit {
    fn add(&mut self, [u, v]: [f64; 2], length: f64) {
        let (u, v, l) = (u * u, v * v, length * length);
        self.uu += u * u;
        self.uv += u * v;
        self.vv += v * v;
        self.ul += u * l;
        self.vl += v * l;
    }

    /// U and V: metres per unit of the texture coordinates.
    fn size(&self) -> [f64; 2] {
        let Fit { uu, uv, vv, ul, vl } = *self;
        let determinant = uu * vv - uv * uv;
        let squares = if 1e-9 * uu * vv < determinant {
            [(ul * vv - vl * uv) / determinant, (vl * uu - ul * uv) / determinant]
        } else {
            let both = ((ul + vl) / (uu + 2.0 * uv + vv).max(f64::MIN_POSITIVE)).max(0.0);
            [both; 2]
        };
        squares.map(|square| square.max(0.0).sqrt())
    }
}

fn repeats(body: &Body, lengths: &Lengths) -> Vec<[f32; 2]> {
    let surface = &body.surface;
    let charts = charts(surface.corners.len(), &surface.triangles);
    let mut fits = vec![Fit::default(); surface.corners.len()];
    for &[a, b, c] in &surface.triangles {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            let (Some(from), Some(to)) =
                (surface.corners.get(a as usize), surface.corners.get(b as usize))
            else {
                continue;
            };
            if let Some(length) = lengths.of([from.particle, to.particle]) {
                let along = [0, 1].map(|axis| f64::from(to.uv[axis] - from.uv[axis]));
                fits[charts[a as usize]].add(along, f64::from(length));
            }
        }
    }
    let sizes: Vec<[f64; 2]> = charts.iter().map(|&chart| fits[chart].size()).collect();
    let longest = sizes.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
    let size = match body.look.pattern_size {
        size if 0.0 < size => f64::from(size),
        _ => longest / usual(body.look.pattern),
    };
    // Squares and stripes come in pairs, of a light and a dark one.
    let pair = match body.look.pattern {
        Pattern::Checks | Pattern::Stripes => 2.0,
        _ => 1.0,
    };
    // So many as fit whole, that the pattern closes around a body.
    let count = |length: f64| (pair * (length / size / pair).round().max(1.0)).min(1e6) as f32;
    sizes.iter().map(|size| size.map(count)).collect()
}

/// Number of times that a pattern fits along the longest side of a body, where its size is not
/// given.
fn usual(pattern: Pattern) -> f64 {
    match pattern {
        Pattern::None => 1.0,
        Pattern::Checks => 10.0,
        Pattern::Stripes => 14.0,
        Pattern::Weave => 100.0,
        Pattern::Grain => 9.0,
    }
}

/// The first corner that each corner is connected with.
fn charts(corners: usize, triangles: &[[u32; 3]]) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..corners).collect();
    fn top(parents: &mut [usize], mut at: usize) -> usize {
        while parents[at] != at {
            parents[at] = parents[parents[at]];
            at = parents[at];
        }
        at
    }
    for &[a, b, c] in triangles {
        let ends = [a, b, c].map(|corner| corner as usize);
        if ends.iter().any(|&corner| corners <= corner) {
            continue;
        }
        let tops = ends.map(|corner| top(&mut parents, corner));
        let least = tops[0].min(tops[1]).min(tops[2]);
        tops.iter().for_each(|&corner| parents[corner] = least);
    }
    (0..corners).map(|corner| top(&mut parents, corner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Material, Scene, Settings, Simulation, shape};

    /// A block of 2, 4 and 6 metres, with squares of half a metre.
    #[test]
    fn squares_have_the_size_that_was_given_on_every_side_of_a_block() {
        let part = shape::block([5, 3, 7], 1.0, Material::default()).expect("a valid size");
        let mut scene = Scene::of("block", part);
        scene.bodies[0].look.pattern = Pattern::Checks;
        scene.bodies[0].look.pattern_size = 0.5;
        let block = Simulation::<f32>::new(&scene, Settings::default()).expect("a valid scene");
        let snapshot = block.snapshot();
        let mut sizes = Sizes::default();
        let repeats = sizes.repeats((0, &snapshot.bodies[0]), &snapshot);
        let mut found: Vec<_> = repeats.iter().map(|[u, v]| [u.min(*v), u.max(*v)]).collect();
        found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        found.dedup();
        assert_eq!(found, [[4.0, 8.0], [4.0, 12.0], [8.0, 12.0]]);
    }
}
