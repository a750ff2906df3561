//! The viewport: a camera and its area of the window; and the resolution, half of it if software
//! rendering falls behind.
//!
//! Sizes are in points, as in egui; only the renderer uses pixels.

use crate::session::Pace;
use egui::{Pos2, Rect, pos2};
use glam::{Mat4, Vec3, Vec4};
use msd_render::{Camera, Quality, Ray};

/// A camera and its area of the window.
#[derive(Clone, Copy, Debug)]
pub struct Viewport {
    /// The camera.
    pub camera: Camera,
    /// The area of the window, points.
    pub rect: Rect,
}

impl Viewport {
    fn aspect(&self) -> f32 {
        self.rect.width() / self.rect.height()
    }

    /// Returns the ray into the scene through a point of the window.
    pub fn ray(&self, at: Pos2) -> Ray {
        let across = (at - self.rect.center()) / (self.rect.size() * 0.5);
        self.camera.ray(across.x, -across.y, self.aspect())
    }

    /// Returns the position of a point of the scene in the window; `None` behind the camera.
    pub fn project(&self, point: Vec3) -> Option<Pos2> {
        let [x, y] = self.camera.project(point, self.aspect())?;
        let (centre, half) = (self.rect.center(), self.rect.size() * 0.5);
        Some(pos2(centre.x + x * half.x, centre.y - y * half.y))
    }

    /// Returns the matrix from the scene to clip space, for [`Viewport::line`]: for many points,
    /// for which [`Viewport::project`] is too slow.
    pub(crate) fn clip_matrix(&self) -> Mat4 {
        self.camera.view_projection(self.aspect())
    }

    /// Returns the part of a line between two points of clip space that is in front of the camera,
    /// in the window.
    pub fn line(&self, ends: [Vec4; 2]) -> Option<[Pos2; 2]> {
        let near = self.camera.near();
        let [a, b] = ends;
        let at_near = || a + (b - a) * ((near - a.w) / (b.w - a.w));
        let ends = match [near <= a.w, near <= b.w] {
            [true, true] => ends,
            [true, false] => [a, at_near()],
            [false, true] => [at_near(), b],
            [false, false] => return None,
        };
        let (centre, half) = (self.rect.center(), self.rect.size() * 0.5);
        Some(
            ends.map(|end| {
                pos2(centre.x + end.x / end.w * half.x, centre.y - end.y / end.w * half.y)
            }),
        )
    }

    /// Returns the target of a grab at `through` for a position of the pointer.
    pub fn drag_point(&self, at: Pos2, through: Vec3) -> Vec3 {
        msd_render::drag_point(&self.camera, &self.ray(at), through)
    }
}

/// Frame time above which the resolution is halved, milliseconds: 20 frames per second.
const LONGEST_MS: f64 = 50.0;
/// Number of consecutive slow frames needed: a short load does not count.
const FRAMES: u32 = 20;

/// Whether the view has half the resolution in each direction, and by whose choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sharpness {
    is_half: bool,
    /// Whether the user has chosen.
    is_set: bool,
    /// Number of consecutive slow frames.
    slow: u32,
}

impl Sharpness {
    /// Returns whether the view has half the resolution.
    pub fn is_half(self) -> bool {
        self.is_half
    }

    /// Returns whether the resolution was halved automatically, as frames took too long.
    pub fn is_automatic(self) -> bool {
        self.is_half && !self.is_set
    }

    /// Sets the resolution permanently.
    pub fn set(&mut self, is_half: bool) {
        *self = Sharpness { is_half, is_set: true, slow: 0 };
    }

    /// Halves the resolution after enough consecutive slow frames, measured without steps. It
    /// applies only to software rendering, and unless the user has chosen.
    pub fn follow(&mut self, quality: Quality, pace: Option<Pace>) {
        let Some(pace) = pace.filter(|pace| 0.0 < pace.frame_rate) else { return };
        let drawing_ms = 1e3 / pace.frame_rate - pace.steps_per_frame * pace.step_ms;
        let is_slow = quality == Quality::Fast && LONGEST_MS < drawing_ms;
        self.slow = if is_slow { self.slow + 1 } else { 0 };
        self.is_half |= FRAMES <= self.slow && !self.is_set;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn viewport() -> Viewport {
        let rect = Rect::from_min_max(pos2(170.0, 20.0), pos2(970.0, 620.0));
        Viewport { camera: Camera::default(), rect }
    }

    #[test]
    fn a_point_on_a_ray_appears_where_the_ray_started() {
        let at = pos2(400.0, 200.0);
        let ray = viewport().ray(at);
        let place = viewport().project(ray.origin + ray.direction * 7.0).expect("in front");
        // Single precision at a few hundred points.
        assert!(place.distance(at) < 1e-2, "{place:?}");
    }

    #[test]
    fn a_line_ends_where_its_points_appear_and_is_cut_off_behind_the_camera() {
        let viewport = viewport();
        let at = |point: Vec3| viewport.clip_matrix() * point.extend(1.0);
        let (a, b) = (Vec3::new(1.0, 2.0, 0.5), Vec3::new(-3.0, 0.0, 1.0));
        let line = viewport.line([at(a), at(b)]).expect("in front");
        for (end, point) in line.into_iter().zip([a, b]) {
            assert!(end.distance(viewport.project(point).expect("in front")) < 1e-2);
        }
        let behind = viewport.camera.eye() - viewport.camera.forward();
        let [shown, cut] = viewport.line([at(a), at(behind)]).expect("in part");
        assert!(shown.distance(line[0]) < 1e-2 && cut.is_finite());
        assert!(viewport.line([at(behind), at(behind)]).is_none());
    }

    #[test]
    fn dragging_keeps_the_depth() {
        let viewport = viewport();
        let held = Vec3::new(1.0, 2.0, 0.5);
        let dragged = viewport.drag_point(pos2(700.0, 100.0), held);
        assert!((viewport.camera.depth(dragged) - viewport.camera.depth(held)).abs() < 1e-4);
    }

    fn after(frames: u32, frame_rate: f64, step_ms: f64, quality: Quality) -> Sharpness {
        let pace = Pace { frame_rate, steps_per_frame: 4.0, step_ms, ..Pace::default() };
        let mut sharpness = Sharpness::default();
        (0..frames).for_each(|_| sharpness.follow(quality, Some(pace)));
        sharpness
    }

    #[test]
    fn a_processor_that_draws_less_than_20_pictures_a_second_draws_half_of_the_pixels() {
        assert!(after(FRAMES, 13.0, 1.0, Quality::Fast).is_automatic());
        assert!(!after(FRAMES - 1, 13.0, 1.0, Quality::Fast).is_half());
        assert!(!after(100, 25.0, 1.0, Quality::Fast).is_half());
        // Slow steps, or a hardware GPU.
        assert!(!after(100, 13.0, 10.0, Quality::Fast).is_half());
        assert!(!after(100, 13.0, 1.0, Quality::Full).is_half());
    }

    #[test]
    fn what_the_user_sets_stays() {
        let pace = Pace { frame_rate: 5.0, ..Pace::default() };
        let mut sharpness = Sharpness::default();
        sharpness.set(false);
        (0..100).for_each(|_| sharpness.follow(Quality::Fast, Some(pace)));
        assert!(!sharpness.is_half());
        sharpness.set(true);
        assert!(sharpness.is_half() && !sharpness.is_automatic());
    }
}
