//! Strokes and boxes on the screen: springs that a stroke crosses, particles in a box.
//!
//! Both act on the whole scene, including objects hidden behind a surface.

use crate::viewer::Viewport;
use egui::{Pos2, Rect};
use glam::Vec4;
use msd_core::Vector;
use msd_run::{Runner, on};

/// Returns the uncut springs whose screen line a segment of a stroke crosses.
pub(super) fn crossed(viewport: &Viewport, runner: &Runner, stroke: [Pos2; 2]) -> Vec<usize> {
    on!(runner, simulation => {
        let snapshot = simulation.snapshot();
        let clip_matrix = viewport.clip_matrix();
        let points = snapshot.positions().map(|place| clip_matrix * place.to_f32().extend(1.0));
        let points: Vec<Vec4> = points.collect();
        let springs = snapshot.ends.iter().enumerate();
        let there = springs.filter(|&(spring, _)| !snapshot.is_cut(spring));
        let is_crossed = |ends: &[u32; 2]| {
            let picture = viewport.line(ends.map(|end| points[end as usize]));
            picture.is_some_and(|picture| meet(stroke, picture))
        };
        there.filter(|(_, ends)| is_crossed(ends)).map(|(spring, _)| spring).collect()
    })
}

/// Returns the particles inside a box on the screen.
pub(super) fn inside(viewport: &Viewport, runner: &Runner, area: Rect) -> Vec<usize> {
    let is_inside = |point| viewport.project(point).is_some_and(|place| area.contains(place));
    on!(runner, simulation => {
        let model = simulation.model();
        let places = simulation.positions().map(|place| place.to_f32()).enumerate();
        let there = places.filter(|&(particle, _)| !model.is_removed(particle));
        there.filter(|&(_, place)| is_inside(place)).map(|(particle, _)| particle).collect()
    })
}

/// Returns whether two segments cross: each has its ends on different sides of the other.
fn meet([a, b]: [Pos2; 2], [c, d]: [Pos2; 2]) -> bool {
    let side = |from: Pos2, to: Pos2, of: Pos2| {
        let (way, arm) = (to - from, of - from);
        way.x * arm.y - way.y * arm.x
    };
    let (first, second) = (side(a, b, c) * side(a, b, d), side(c, d, a) * side(c, d, b));
    // Collinear segments do not count.
    first <= 0.0 && second <= 0.0 && (first < 0.0 || second < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn segments_meet_where_they_cross_and_not_where_only_their_lines_do() {
        let across = [pos2(0.0, 1.0), pos2(2.0, 1.0)];
        assert!(meet(across, [pos2(1.0, 0.0), pos2(1.0, 2.0)]));
        assert!(meet([pos2(1.0, 2.0), pos2(1.0, 0.0)], across));
        assert!(!meet(across, [pos2(3.0, 0.0), pos2(3.0, 2.0)]));
        assert!(!meet(across, [pos2(1.0, 1.5), pos2(1.0, 2.0)]));
        // A spring seen end on is a point, and a stroke along a spring does not cross it.
        assert!(!meet(across, [pos2(1.0, 1.5), pos2(1.0, 1.5)]));
        assert!(!meet(across, [pos2(0.5, 1.0), pos2(1.5, 1.0)]));
        assert!(!meet(across, [pos2(f32::NAN, 0.0), pos2(1.0, 2.0)]));
    }
}
