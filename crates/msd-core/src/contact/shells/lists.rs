//! Lists of features that may be near each other, which serve for many substeps.

use super::clusters::{Cluster, Clusters};
use super::distance::{between_edges, minus, of_edge, of_face};
use super::features::{At, Shells};
use super::margins::Margins;
use super::row::{EDGE, EDGES, FACE, key};
use crate::columns::extent::Extent;
use crate::columns::{LANES, load};
use crate::number::{Real, Vector, at_level};
use crate::pack::{Pack, zip};
use crate::scene::shell::do_meet;
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::{Level, Simd};

/// Two features, a vertex and a face, a vertex and an edge of no face, or two edges, and how far
/// their clusters must come closer to each other before the gap may be closed, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListedPair {
    pub(super) key: u64,
    pub(super) until: f64,
}

/// Two clusters, or one twice, and the features of both that may be near each other.
#[derive(Clone, Debug)]
pub(super) struct ClusterPair<R> {
    pub(super) clusters: [u32; 2],
    /// How far they may have come closer to each other since the pair was found, metres.
    pub(super) worn: f64,
    /// The wear from which on one of the features may matter.
    pub(super) until: f64,
    /// The wear up to which no feature that is not listed matters.
    pub(super) listed_to: f64,
    /// The margin of this substep, metres.
    pub(super) margin: R,
    /// The distance at which the shells stop each other, metres.
    pub(super) stop: R,
    pub(super) features: Range<u32>,
}

/// Features that may be near each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates<R: Real> {
    /// None before the first look at some features.
    pub(super) clusters: Clusters,
    /// The pairs that may matter in this substep, in order.
    pub(super) due: Vec<u32>,
    pub(super) pairs: Vec<ClusterPair<R>>,
    before: Vec<ClusterPair<R>>,
    pub(super) features: Vec<ListedPair>,
    /// The vertices of the clusters of those pairs and those that edges join to them.
    pub(super) vertices: Vec<u32>,
    is_listed: bool,
    /// How far any two clusters may have come closer to each other since the pairs were found, and
    /// up to where no other pair matters, metres.
    worn: f64,
    found_to: f64,
    /// Positions at the last look, metres, and the box around them.
    last: Vec<R>,
    around: Extent<R>,
    /// Whether each cluster, and each vertex, is one that may matter.
    are_due: [Vec<bool>; 2],
    /// How far each cluster has moved since the last look.
    moved: Vec<Extent<R>>,
    search: FeatureSearch<R>,
}

impl<R: Real> Candidates<R> {
    /// Discards the lists: features are other ones.
    pub(super) fn forget(&mut self) {
        self.is_listed = false;
        self.clusters = Clusters::default();
    }

    /// Whether no features can be within their reach and a margin, metres, that holds for all; then
    /// none is due. The first margin holds where no obstacle can be met, the second anywhere.
    pub(super) fn are_apart(
        &mut self,
        at: &At<'_, R>,
        positions: &[R],
        (free, margin): (R, R),
    ) -> bool {
        let shells = at.shells;
        self.due.clear();
        self.vertices.clear();
        if self.clusters.rows.is_empty() {
            self.clusters = Clusters::new(shells);
        }
        if !self.is_listed {
            return false;
        }
        let moved = at_level!(at.level, simd => ways(simd, shells, [&self.last, positions]));
        let way = moved.diagonal().sqrt().to_f64();
        let needed = |margin: R| way + margin.to_f64() + shells.reach() * NOISE;
        let spare = self.spare();
        if needed(margin) <= spare {
            return true;
        }
        if needed(free) <= spare && self.is_clear(at, moved, margin) {
            return true;
        }
        self.worn += way;
        self.wear_out(shells, positions);
        false
    }

    /// Whether no obstacle can be met in a substep in which particles come closer to it by at most
    /// a margin, metres, and have moved so much since the last look.
    fn is_clear(&self, at: &At<'_, R>, moved: Extent<R>, margin: R) -> bool {
        let way = moved.with_origin().diagonal().sqrt() + margin + R::of(at.shells.reach());
        at.obstacles.are_beyond(self.around, way)
    }

    /// Finds the pairs of clusters whose features may be within their reach and the margin of both,
    /// and lists these anew where the lists may lack some; `most` is the largest margin, metres.
    /// Returns whether the lists hold all. Where each feature would be near hundreds of others, as
    /// in a run that diverges, they do not.
    pub(super) fn serve(
        &mut self,
        level: Level,
        shells: &Shells,
        positions: &[R],
        (margins, most): (&Margins<R>, R),
    ) -> bool {
        let noise = shells.reach() * NOISE;
        let needed = most.to_f64() + noise;
        self.last.clear();
        self.last.extend_from_slice(positions);
        self.around = at_level!(level, simd => {
            Extent::of(simd, &shells.records, |at, part| load(simd, &positions[at..], part))
        });
        if !self.is_listed || self.found_to < self.worn + needed {
            self.pair_clusters(shells, positions, needed);
        }
        self.is_listed = true;
        for number in 0..self.pairs.len() {
            let pair = &mut self.pairs[number];
            pair.margin = margins.between(pair.clusters);
            let needed = pair.margin.to_f64() + noise;
            if pair.listed_to < pair.worn + needed {
                self.list(level, shells, positions, (number, needed));
            }
            let pair = &self.pairs[number];
            if pair.until < pair.worn + needed {
                self.due.push(number as u32);
            }
        }
        self.mark(shells);
        let most = MOST_PAIRS * (shells.vertices.len() + shells.faces.len() + shells.edges.len());
        let are_all = self.pack() <= most;
        if !are_all {
            // Not to be served from again.
            self.is_listed = false;
        }
        are_all
    }

    /// How far any two clusters may come closer before a pair may matter, metres.
    fn spare(&self) -> f64 {
        let of_pair = |pair: &ClusterPair<R>| pair.until.min(pair.listed_to) - pair.worn;
        self.pairs.iter().map(of_pair).fold(self.found_to - self.worn, f64::min)
    }

    /// Adds to the wear of each pair how far its clusters may have come closer since the last look.
    fn wear_out(&mut self, shells: &Shells, positions: &[R]) {
        let Candidates { clusters, moved, last, pairs, .. } = self;
        moved.clear();
        moved.extend(clusters.rows.iter().map(|cluster| {
            let way = |&vertex: &u32| {
                shells.point::<R>(positions, vertex) - shells.point::<R>(last, vertex)
            };
            Extent::around(cluster.corners.iter().map(way))
        }));
        for pair in pairs {
            let [own, other] = pair.clusters.map(|cluster| moved[cluster as usize]);
            pair.worn += own.with(other).diagonal().sqrt().to_f64();
        }
    }

    /// Finds the clusters that may be near each other, up to a distance of about their own size.
    /// Those that were found before keep their features.
    fn pair_clusters(&mut self, shells: &Shells, positions: &[R], needed: f64) {
        let boxes = &mut self.moved;
        boxes.clear();
        boxes.extend(self.clusters.rows.iter().map(|cluster| cluster.extent(shells, positions)));
        let sizes = boxes.iter().map(|extent| extent.diagonal().sqrt().to_f64()).sum::<f64>();
        let beyond = (BEYOND * sizes / boxes.len() as f64).max(2.0 * needed);
        let far = R::of(shells.reach() + beyond);
        (self.worn, self.found_to) = (0.0, beyond);
        core::mem::swap(&mut self.pairs, &mut self.before);
        let is_listed = self.is_listed;
        let mut known = self.before.drain(..).filter(|_| is_listed).peekable();
        let all = boxes.iter().copied().fold(Extent::default(), Extent::with);
        let along = all.longest_axis();
        let order = &mut self.search.order;
        order.clear();
        order.extend(0..boxes.len() as u32);
        let low = |cluster: u32| boxes[cluster as usize].low().components()[along].to_f64();
        order.sort_unstable_by(|&a, &b| low(a).total_cmp(&low(b)).then(a.cmp(&b)));
        let found = &mut self.search.found;
        found.clear();
        for (at, &own) in order.iter().enumerate() {
            let last = boxes[own as usize].high().components()[along].to_f64() + far.to_f64();
            for &other in order[at..].iter().take_while(|&&other| low(other) <= last) {
                let clusters = [own.min(other), own.max(other)];
                let [a, b] =
                    clusters.map(|cluster| self.clusters.rows[cluster as usize].shell(shells));
                let distance = || boxes[own as usize].distance(boxes[other as usize]);
                if do_meet(shells.rows(), [a, b]) && distance() < far {
                    found.push(clusters);
                }
            }
        }
        found.sort_unstable();
        for &clusters in &*found {
            while known.next_if(|before| before.clusters < clusters).is_some() {}
            let new = || {
                let [own, other] = clusters.map(|cluster| boxes[cluster as usize]);
                let apart = own.distance(other).to_f64() - shells.reach();
                let first =
                    clusters.map(|cluster| self.clusters.rows[cluster as usize].vertices[0]);
                ClusterPair {
                    clusters,
                    worn: 0.0,
                    until: apart,
                    listed_to: apart,
                    margin: R::ZERO,
                    stop: shells.stop_of(first[0], first[1]),
                    features: 0..0,
                }
            };
            let before = known.next_if(|before| before.clusters == clusters);
            self.pairs.push(before.unwrap_or_else(new));
        }
    }

    /// Lists the features of a pair that are within their reach and some distance of each other.
    fn list(
        &mut self,
        level: Level,
        shells: &Shells,
        positions: &[R],
        (number, needed): (usize, f64),
    ) {
        let pair = &mut self.pairs[number];
        let [own, other] = pair.clusters.map(|cluster| &self.clusters.rows[cluster as usize]);
        let boxes = [own, other].map(|cluster| cluster.extent(shells, positions));
        let stop = pair.stop;
        let apart = (boxes[0].distance(boxes[1]) - stop).to_f64();
        let edge = own.longest(shells, positions).max(other.longest(shells, positions));
        let skin = (SKIN * edge.to_f64()).max(2.0 * needed) + needed;
        let first = self.features.len() as u32;
        pair.listed_to = pair.worn + skin.max(apart);
        pair.until = pair.listed_to;
        if apart < skin {
            self.search.reach = stop + R::of(skin);
            let is_one = pair.clusters[0] == pair.clusters[1];
            let sides = [own, other];
            at_level!(level, simd => {
                self.search.list(simd, (shells, positions), (sides, boxes, is_one))
            });
            for &(key, square) in &self.search.near {
                let until = pair.worn + (square.sqrt() - stop).to_f64();
                pair.until = pair.until.min(until);
                self.features.push(ListedPair { key, until });
            }
        }
        pair.features = first..self.features.len() as u32;
    }

    /// Drops the features of earlier lists once they are most; returns how many there are.
    fn pack(&mut self) -> usize {
        let count = self.pairs.iter().map(|pair| pair.features.len()).sum::<usize>();
        if 2 * count < self.features.len() {
            let kept = &mut self.search.kept;
            kept.clear();
            for pair in &mut self.pairs {
                let first = kept.len() as u32;
                let features = pair.features.start as usize..pair.features.end as usize;
                kept.extend_from_slice(&self.features[features]);
                pair.features = first..kept.len() as u32;
            }
            core::mem::swap(kept, &mut self.features);
        }
        count
    }

    /// Lists all vertices of two shells, too.
    pub(super) fn mark_all(&mut self, shells: &Shells, pair: [usize; 2]) {
        pair.into_iter().for_each(|shell| self.vertices.extend(shells.vertices_of(shell)));
        self.vertices.sort_unstable();
        self.vertices.dedup();
    }

    /// Lists the vertices of the pairs that may matter and those beside them.
    fn mark(&mut self, shells: &Shells) {
        if self.due.is_empty() {
            return;
        }
        let [clusters, vertices] = &mut self.are_due;
        clusters.clear();
        clusters.resize(self.clusters.rows.len(), false);
        vertices.clear();
        vertices.resize(shells.vertices.len(), false);
        for &pair in &self.due {
            for cluster in self.pairs[pair as usize].clusters {
                if core::mem::replace(&mut clusters[cluster as usize], true) {
                    continue;
                }
                for &vertex in &self.clusters.rows[cluster as usize].around {
                    if !core::mem::replace(&mut vertices[vertex as usize], true) {
                        self.vertices.push(vertex);
                    }
                }
            }
        }
    }
}

/// The most pairs for each feature.
const MOST_PAIRS: usize = 256;
/// More than the part of a reach that rounding is worth.
pub(super) const NOISE: f64 = 0.01;
/// How far clusters are looked for, in their size.
const BEYOND: f64 = 0.5;
/// How far beyond their reach features are listed, in edges: less than features that share no
/// vertex are apart in flat surface.
const SKIN: f64 = 0.33;

/// The box around all displacements.
#[inline(always)]
fn ways<S: Simd, R: Real>(simd: S, shells: &Shells, [from, to]: [&[R]; 2]) -> Extent<R> {
    let way = |at: usize, part| {
        zip(load(simd, &to[at..], part), load(simd, &from[at..], part), |a, b| a - b)
    };
    Extent::of(simd, &shells.records, way)
}

impl Cluster {
    fn shell(&self, shells: &Shells) -> usize {
        shells.shell_of(self.vertices[0])
    }

    /// The box around its features.
    pub(super) fn extent<R: Real>(&self, shells: &Shells, positions: &[R]) -> Extent<R> {
        Extent::around(self.corners.iter().map(|&vertex| shells.point(positions, vertex)))
    }

    /// The length of its longest edge, metres.
    fn longest<R: Real>(&self, shells: &Shells, positions: &[R]) -> R {
        let square = |&edge: &u32| {
            let [a, b]: [R::Vec3; 2] = shells.points(positions, shells.edges[edge as usize].ends);
            (b - a).dot(b - a)
        };
        self.edges.iter().map(square).fold(R::ZERO, R::max).sqrt()
    }
}

/// What a search for features of two clusters takes note of.
#[derive(Clone, Debug, Default)]
struct FeatureSearch<R: Real> {
    /// How far apart features may be, metres.
    reach: R,
    vertices: FeatureLanes<R, 1>,
    edges: FeatureLanes<R, 2>,
    faces: FeatureLanes<R, 3>,
    /// Features that are near each other, and the squares of their distances.
    near: Vec<(u64, R)>,
    order: Vec<u32>,
    found: Vec<[u32; 2]>,
    kept: Vec<ListedPair>,
}

impl<R: Real> FeatureSearch<R> {
    /// Finds the features of two clusters, or of one, that are within reach of each other.
    #[inline(always)]
    fn list<S: Simd>(
        &mut self,
        simd: S,
        at: (&Shells, &[R]),
        (sides, boxes, is_one): ([&Cluster; 2], [Extent<R>; 2], bool),
    ) {
        self.near.clear();
        for (own, other) in [(0, 1), (1, 0)] {
            if is_one && own == 1 {
                break;
            }
            self.vertices.fill(at, (&sides[own].vertices, |v| [v]), (boxes[other], self.reach));
            let corners = |face: u32| at.0.faces[face as usize].corners;
            self.faces.fill(at, (&sides[other].faces, corners), (boxes[own], self.reach));
            self.see_faces(simd, at.0);
            let ends = |edge: u32| at.0.edges[edge as usize].ends;
            if !sides[other].bare.is_empty() {
                self.edges.fill(at, (&sides[other].bare, ends), (boxes[own], self.reach));
                self.see_bare(simd, at.0);
            }
        }
        let ends = |edge: u32| at.0.edges[edge as usize].ends;
        self.edges.fill(at, (&sides[1].edges, ends), (boxes[0], self.reach));
        for (number, &edge) in sides[0].edges.iter().enumerate() {
            let [a, b]: [R::Vec3; 2] = at.0.points(at.1, ends(edge));
            if !boxes[1].is_near(Extent::around([a, b].into_iter()), self.reach) {
                continue;
            }
            let line = [splat(simd, a), splat(simd, b)];
            let own = ends(edge);
            let near = &mut self.near;
            let square = |other| between_edges(line, other);
            // Of two edges of one cluster the first sees the other.
            let first = if is_one { number + 1 } else { 0 };
            self.edges.see(simd, (first, self.reach), square, |other, square| {
                if ends(other).iter().all(|end| !own.contains(end)) {
                    near.push((key(EDGES, edge.min(other), edge.max(other)), square));
                }
            });
        }
    }

    #[inline(always)]
    fn see_faces<S: Simd>(&mut self, simd: S, shells: &Shells) {
        for at in 0..self.vertices.features.len() {
            let (vertex, here) = self.vertices.one(simd, at);
            let near = &mut self.near;
            let square = |[a, b, c]: [[Pack<S, R>; 3]; 3]| {
                of_face([minus(a, here), minus(b, here), minus(c, here)])
            };
            self.faces.see(simd, (0, self.reach), square, |face, square| {
                if !shells.faces[face as usize].corners.contains(&vertex) {
                    near.push((key(FACE, vertex, face), square));
                }
            });
        }
    }

    #[inline(always)]
    fn see_bare<S: Simd>(&mut self, simd: S, shells: &Shells) {
        for at in 0..self.vertices.features.len() {
            let (vertex, here) = self.vertices.one(simd, at);
            let near = &mut self.near;
            let square =
                |ends: [[Pack<S, R>; 3]; 2]| of_edge(ends.map(|end| zip(end, here, |a, b| a - b)));
            self.edges.see(simd, (0, self.reach), square, |edge, square| {
                if !shells.edges[edge as usize].ends.contains(&vertex) {
                    near.push((key(EDGE, vertex, edge), square));
                }
            });
        }
    }
}

/// A vector in each lane.
#[inline(always)]
fn splat<S: Simd, R: Real>(simd: S, vector: R::Vec3) -> [Pack<S, R>; 3] {
    let [x, y, z] = vector.components();
    [Pack::new(simd, x), Pack::new(simd, y), Pack::new(simd, z)]
}

/// Features of so many points each, in columns of whole registers.
#[derive(Clone, Debug)]
struct FeatureLanes<R: Real, const POINTS: usize> {
    features: Vec<u32>,
    columns: [[Vec<R>; 3]; POINTS],
}

impl<R: Real, const POINTS: usize> Default for FeatureLanes<R, POINTS> {
    fn default() -> Self {
        let columns = core::array::from_fn(|_| [Vec::new(), Vec::new(), Vec::new()]);
        FeatureLanes { features: Vec::new(), columns }
    }
}

impl<R: Real, const POINTS: usize> FeatureLanes<R, POINTS> {
    /// Overwrites the features by those of some that are within reach of a box.
    fn fill(
        &mut self,
        (shells, positions): (&Shells, &[R]),
        (features, points): (&[u32], impl Fn(u32) -> [u32; POINTS]),
        (around, reach): (Extent<R>, R),
    ) {
        self.features.clear();
        let columns = &mut self.columns;
        columns.as_flattened_mut().iter_mut().for_each(Vec::clear);
        for &feature in features {
            let points: [R::Vec3; POINTS] = shells.points(positions, points(feature));
            if !around.is_near(Extent::around(points.into_iter()), reach) {
                continue;
            }
            self.features.push(feature);
            for (column, point) in columns.iter_mut().zip(points) {
                for (numbers, number) in column.iter_mut().zip(point.components()) {
                    numbers.push(number);
                }
            }
        }
        let whole = self.features.len().next_multiple_of(LANES);
        for numbers in columns.as_flattened_mut() {
            let last = numbers.last().copied().unwrap_or_default();
            numbers.resize(whole, last);
        }
    }

    /// A feature of one point.
    #[inline(always)]
    fn one<S: Simd>(&self, simd: S, at: usize) -> (u32, [Pack<S, R>; 3]) {
        let [x, y, z] = &self.columns[0];
        let here = R::Vec3::from_components([x[at], y[at], z[at]]);
        (self.features[at], splat(simd, here))
    }

    /// Sees the features within reach from one of them on, by the squares of their distances, a
    /// register at a time.
    #[inline(always)]
    fn see<S: Simd>(
        &self,
        simd: S,
        (first, reach): (usize, R),
        square: impl Fn([[Pack<S, R>; 3]; POINTS]) -> Pack<S, R>,
        mut see: impl FnMut(u32, R),
    ) {
        let lanes = Pack::<S, R>::LEN;
        let most = reach * reach;
        for part in (first / lanes * lanes..self.features.len()).step_by(lanes) {
            let read = |numbers: &Vec<R>| Pack::from_slice(simd, &numbers[part..][..lanes]);
            let mut points = [[Pack::<S, R>::new(simd, R::ZERO); 3]; POINTS];
            for (point, column) in points.iter_mut().zip(&self.columns) {
                *point = [read(&column[0]), read(&column[1]), read(&column[2])];
            }
            let mut squares = [R::ZERO; LANES];
            square(points).store_slice(&mut squares[..lanes]);
            let features = self.features[part..].iter().zip(squares).take(lanes);
            for (&feature, square) in features.skip(first.saturating_sub(part)) {
                if square < most {
                    see(feature, square);
                }
            }
        }
    }
}
