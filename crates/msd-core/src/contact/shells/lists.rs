//! Lists of features that may be near each other, which serve for many substeps.

use super::clusters::{Cluster, Clusters, Feature};
use super::distance::{FeatureLanes, between_edges, minus, of_edge, of_face};
use super::features::{At, Shells};
use super::margins::Margins;
use super::row::{EDGE, EDGES, FACE, key};
use crate::columns::extent::Extent;
use crate::columns::load;
use crate::number::{Real, Vector, at_level};
use crate::pack::{Pack, splat, zip};
use crate::scene::shell::do_meet;
use alloc::vec::Vec;
use core::ops::Range;
use fearless_simd::{Level, Simd};

/// Two features: a vertex and a face, a vertex and an edge of no face, or two edges. `until` is the
/// approach of their clusters before which the gap cannot close, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListedPair {
    pub(super) key: u64,
    pub(super) until: f64,
}

/// Two clusters, or one twice, and the features of both that may be near each other.
#[derive(Clone, Debug)]
pub(super) struct ClusterPair<R> {
    pub(super) clusters: [u32; 2],
    /// Most by which they may have come closer to each other since the pair was found, metres.
    pub(super) worn: f64,
    /// The wear from which on one of the features may matter.
    pub(super) until: f64,
    /// The wear up to which no feature that is not listed matters.
    pub(super) listed_to: f64,
    /// The margin of this substep, metres.
    pub(super) margin: R,
    /// The distance at which the shells stop each other, metres.
    pub(super) stop: R,
    /// The length of the longest edge of both as they were found, metres.
    edge: R,
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
    pairs_before: Vec<ClusterPair<R>>,
    pub(super) features: Vec<ListedPair>,
    /// The vertices of the clusters of those pairs and those that edges join to them.
    pub(super) vertices: Vec<u32>,
    is_listed: bool,
    /// Most by which any two clusters may have come closer to each other since the pairs were
    /// found, and the value up to which no other pair matters, metres.
    worn: f64,
    found_to: f64,
    /// Most by which any two clusters may come closer before a pair may matter, metres, where
    /// known.
    spare: Option<f64>,
    /// Positions at the last look, metres, and the box around them.
    last: Vec<R>,
    around: Extent<R>,
    /// Most by which any two vertices may have come closer since, and any one may have moved,
    /// metres, as long as velocities alone moved them.
    crept: Option<[f64; 2]>,
    /// Whether each cluster, and each vertex, is one that may matter.
    are_due: [Vec<bool>; 2],
    /// Where the corners of all clusters are, and where they were at the last look, metres.
    pub(super) corners: Vec<R::Vec3>,
    before: Vec<R::Vec3>,
    /// A box for each cluster: around its way since the last look, or around its features.
    boxes: Vec<Extent<R>>,
    search: FeatureSearch<R>,
}

impl<R: Real> Candidates<R> {
    /// Discards the lists: features are other ones.
    pub(super) fn forget(&mut self) {
        self.is_listed = false;
        self.clusters = Clusters::default();
    }

    /// Discards the known ways since the last look: not velocities alone made them.
    pub(super) fn lose_track(&mut self) {
        self.crept = None;
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
            self.read_corners(shells, positions);
            return false;
        }
        let [free, margin] = [free, margin].map(R::to_f64);
        let spare = self.spare();
        let known = self.crept.take();
        let needed = |[way, _]: [f64; 2], margin| way + margin + shells.reach() * NOISE;
        let is_known = |&way: &[f64; 2]| needed(way, free) <= spare;
        let ways = known.filter(is_known).unwrap_or_else(|| {
            let moved = at_level!(at.level, simd => ways(simd, shells, [&self.last, positions]));
            [moved, moved.with_origin()].map(|of| of.diagonal().sqrt().to_f64())
        });
        if needed(ways, free) <= spare && self.is_clear(at, ways[1] + margin) {
            self.crept = Some([ways[0] + free, ways[1] + margin]);
            return true;
        }
        if needed(ways, margin) <= spare {
            return true;
        }
        self.worn += ways[0];
        self.wear_out(shells, positions);
        false
    }

    /// Whether no obstacle can be met by particles that move by at most a way, metres, from where
    /// they were at the last look.
    fn is_clear(&self, at: &At<'_, R>, way: f64) -> bool {
        at.obstacles.is_empty()
            || at.obstacles.are_beyond(self.around, R::of(way + at.shells.reach()))
    }

    /// Finds the pairs of clusters whose features may be within their reach and the margin of both,
    /// and lists these anew where the lists may lack some. `most` is the largest margin, metres.
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
        self.spare = None;
        self.last.clear();
        self.last.extend_from_slice(positions);
        self.around = at_level!(level, simd => {
            Extent::of(simd, &shells.records, |at, part| load(simd, &positions[at..], part))
        });
        if !self.is_listed || self.found_to < self.worn + needed {
            self.pair_clusters(shells, needed);
        }
        self.is_listed = true;
        for number in 0..self.pairs.len() {
            let pair = &mut self.pairs[number];
            pair.margin = margins.between(pair.clusters);
            let needed = pair.margin.to_f64() + noise;
            if pair.listed_to < pair.worn + needed {
                self.list(level, shells, (number, needed));
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

    /// Most by which any two clusters may come closer before a pair may matter, metres.
    fn spare(&mut self) -> f64 {
        let of_pair = |pair: &ClusterPair<R>| pair.until.min(pair.listed_to) - pair.worn;
        let least = || self.pairs.iter().map(of_pair).fold(self.found_to - self.worn, f64::min);
        *self.spare.get_or_insert_with(least)
    }

    /// Adds to the wear of each pair the most by which its clusters may have come closer since the
    /// last look.
    fn wear_out(&mut self, shells: &Shells, positions: &[R]) {
        core::mem::swap(&mut self.corners, &mut self.before);
        self.read_corners(shells, positions);
        let Candidates { clusters, corners, before, boxes, pairs, .. } = self;
        boxes.clear();
        boxes.extend(clusters.rows.iter().map(|cluster| {
            let [now, before] = [&*corners, &*before].map(|all| &all[cluster.corners.clone()]);
            Extent::around(now.iter().zip(before).map(|(&now, &before)| now - before))
        }));
        for pair in pairs {
            let [own, other] = pair.clusters.map(|cluster| boxes[cluster as usize]);
            pair.worn += own.with(other).diagonal().sqrt().to_f64();
        }
    }

    /// Reads where the corners of the clusters are.
    fn read_corners(&mut self, shells: &Shells, positions: &[R]) {
        let here = |&vertex: &u32| shells.point::<R>(positions, vertex);
        self.corners.clear();
        self.corners.extend(self.clusters.corners.iter().map(here));
    }

    /// Finds the clusters that may be near each other, up to a distance of about their own size.
    /// Those that were found before keep their features.
    fn pair_clusters(&mut self, shells: &Shells, needed: f64) {
        let boxes = &mut self.boxes;
        boxes.clear();
        boxes.extend(self.clusters.rows.iter().map(|cluster| cluster.extent::<R>(&self.corners)));
        let sizes = boxes.iter().map(|extent| extent.diagonal().sqrt().to_f64()).sum::<f64>();
        let beyond = (BEYOND * sizes / boxes.len() as f64).max(2.0 * needed);
        let far = R::of(shells.reach() + beyond);
        (self.worn, self.found_to) = (0.0, beyond);
        core::mem::swap(&mut self.pairs, &mut self.pairs_before);
        let is_listed = self.is_listed;
        let mut known = self.pairs_before.drain(..).filter(|_| is_listed).peekable();
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
                let rows = clusters.map(|cluster| &self.clusters.rows[cluster as usize]);
                let first = rows.map(|cluster| cluster.vertices[0].number);
                let longest = rows.map(|cluster| cluster.longest::<R>(&self.corners));
                ClusterPair {
                    clusters,
                    worn: 0.0,
                    until: apart,
                    listed_to: apart,
                    margin: R::ZERO,
                    stop: shells.stop_of(first[0], first[1]),
                    edge: longest[0].max(longest[1]),
                    features: 0..0,
                }
            };
            let before = known.next_if(|before| before.clusters == clusters);
            self.pairs.push(before.unwrap_or_else(new));
        }
    }

    /// Lists the features of a pair that are within their reach and some distance of each other.
    fn list(&mut self, level: Level, shells: &Shells, (number, needed): (usize, f64)) {
        let pair = &mut self.pairs[number];
        let sides = pair.clusters.map(|cluster| {
            let cluster = &self.clusters.rows[cluster as usize];
            let corners = &self.corners[cluster.corners.clone()];
            PlacedCluster { cluster, corners, around: cluster.extent::<R>(&self.corners) }
        });
        let stop = pair.stop;
        let apart = (sides[0].around.distance(sides[1].around) - stop).to_f64();
        let skin = (SKIN * pair.edge.to_f64()).max(2.0 * needed) + needed;
        let first = self.features.len() as u32;
        pair.listed_to = pair.worn + skin.max(apart);
        pair.until = pair.listed_to;
        if apart < skin {
            self.search.reach = stop + R::of(skin);
            let is_one = pair.clusters[0] == pair.clusters[1];
            at_level!(level, simd => self.search.list(simd, shells, (&sides, is_one)));
            for &(key, square) in &self.search.near {
                let until = pair.worn + (square.sqrt() - stop).to_f64();
                pair.until = pair.until.min(until);
                self.features.push(ListedPair { key, until });
            }
        }
        pair.features = first..self.features.len() as u32;
    }

    /// Drops the features of earlier lists once they are most; returns their number.
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
/// Distance up to which clusters are searched, in their size.
const BEYOND: f64 = 0.5;
/// Distance beyond their reach up to which features are listed, in edges: less than the distance in
/// flat surface between features that share no vertex.
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
        shells.shell_of(self.vertices[0].number)
    }

    /// The box around its features, by the corners of all clusters.
    pub(super) fn extent<R: Real>(&self, corners: &[R::Vec3]) -> Extent<R> {
        Extent::around(corners[self.corners.clone()].iter().copied())
    }

    /// The length of its longest edge, metres.
    fn longest<R: Real>(&self, corners: &[R::Vec3]) -> R {
        let corners = &corners[self.corners.clone()];
        let square = |edge: &Feature<2>| {
            let [a, b] = edge.corners.map(|corner| corners[corner as usize]);
            (b - a).dot(b - a)
        };
        self.edges.iter().map(square).fold(R::ZERO, R::max).sqrt()
    }
}

/// A cluster as a search sees it.
struct PlacedCluster<'a, R: Real> {
    cluster: &'a Cluster,
    /// Where its corners are, metres, and the box around them.
    corners: &'a [R::Vec3],
    around: Extent<R>,
}

/// Notes of a search for features of two clusters.
#[derive(Clone, Debug, Default)]
struct FeatureSearch<R: Real> {
    /// Largest distance between features, metres.
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
        shells: &Shells,
        (sides, is_one): (&[PlacedCluster<'_, R>; 2], bool),
    ) {
        self.near.clear();
        let reach = self.reach;
        for (own, other) in [(0, 1), (1, 0)] {
            if is_one && own == 1 {
                break;
            }
            let [PlacedCluster { cluster, corners, around }, others] = [&sides[own], &sides[other]];
            self.vertices.fill((&cluster.vertices, corners), (others.around, reach));
            self.faces.fill((&others.cluster.faces, others.corners), (*around, reach));
            self.see_faces(simd, shells);
            if !others.cluster.bare.is_empty() {
                self.edges.fill((&others.cluster.bare, others.corners), (*around, reach));
                self.see_bare(simd, shells);
            }
        }
        let ends = |edge: u32| shells.edges[edge as usize].ends;
        let [PlacedCluster { cluster, corners, around }, others] = sides;
        self.edges.fill((&others.cluster.edges, others.corners), (*around, reach));
        for (number, edge) in cluster.edges.iter().enumerate() {
            let [a, b] = [corners[edge.corners[0] as usize], corners[edge.corners[1] as usize]];
            let around = Extent::around([a, b].into_iter());
            if !others.around.is_near(around, reach) {
                continue;
            }
            let line = [splat(simd, a.components()), splat(simd, b.components())];
            let edge = edge.number;
            let own = ends(edge);
            let near = &mut self.near;
            let square = |other| between_edges(line, other);
            // Of two edges of one cluster the first sees the other.
            let first = if is_one { number + 1 } else { 0 };
            self.edges.see(simd, (around, reach, first), square, |other, square| {
                if ends(other).iter().all(|end| !own.contains(end)) {
                    near.push((key(EDGES, edge.min(other), edge.max(other)), square));
                }
            });
        }
    }

    #[inline(always)]
    fn see_faces<S: Simd>(&mut self, simd: S, shells: &Shells) {
        for at in 0..self.vertices.features.len() {
            let (vertex, around, here) = self.vertices.one(simd, at);
            let near = &mut self.near;
            let square = |[a, b, c]: [[Pack<S, R>; 3]; 3]| {
                of_face([minus(a, here), minus(b, here), minus(c, here)])
            };
            self.faces.see(simd, (around, self.reach, 0), square, |face, square| {
                if !shells.faces[face as usize].corners.contains(&vertex) {
                    near.push((key(FACE, vertex, face), square));
                }
            });
        }
    }

    #[inline(always)]
    fn see_bare<S: Simd>(&mut self, simd: S, shells: &Shells) {
        for at in 0..self.vertices.features.len() {
            let (vertex, around, here) = self.vertices.one(simd, at);
            let near = &mut self.near;
            let square =
                |ends: [[Pack<S, R>; 3]; 2]| of_edge(ends.map(|end| zip(end, here, |a, b| a - b)));
            self.edges.see(simd, (around, self.reach, 0), square, |edge, square| {
                if !shells.edges[edge as usize].ends.contains(&vertex) {
                    near.push((key(EDGE, vertex, edge), square));
                }
            });
        }
    }
}
