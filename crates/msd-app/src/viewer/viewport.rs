//! The viewport: a camera, and the part of the window that shows what it sees.
//!
//! The window is in points here, as egui measures it: the renderer alone knows pixels.

use egui::{Pos2, Rect, pos2};
use glam::{Mat4, Vec3, Vec4};
use msd_render::{Camera, Ray};

/// A camera and the part of the window that shows what it sees.
#[derive(Clone, Copy, Debug)]
pub struct Viewport {
    /// The camera.
    pub camera: Camera,
    /// The part of the window, points.
    pub rect: Rect,
}

impl Viewport {
    fn aspect(&self) -> f32 {
        self.rect.width() / self.rect.height()
    }

    /// The ray into the scene through a point of the window.
    pub fn ray(&self, at: Pos2) -> Ray {
        let across = (at - self.rect.center()) / (self.rect.size() * 0.5);
        self.camera.ray(across.x, -across.y, self.aspect())
    }

    /// Where a point of the scene appears in the window; nowhere if it is behind the camera.
    pub fn project(&self, point: Vec3) -> Option<Pos2> {
        let [x, y] = self.camera.project(point, self.aspect())?;
        let (centre, half) = (self.rect.center(), self.rect.size() * 0.5);
        Some(pos2(centre.x + x * half.x, centre.y - y * half.y))
    }

    /// The matrix from the scene to clip space, for [`Viewport::line`]: for many points, where
    /// [`Viewport::project`] takes its time.
    pub fn to_clip(&self) -> Mat4 {
        self.camera.view_projection(self.aspect())
    }

    /// Where a line between two points of clip space appears in the window, as far as it is in
    /// front of the camera.
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

    /// Where a grab pulls what was taken at `through` when the pointer is at a point of the window.
    pub fn drag_point(&self, at: Pos2, through: Vec3) -> Vec3 {
        msd_render::drag_point(&self.camera, &self.ray(at), through)
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
        let at = |point: Vec3| viewport.to_clip() * point.extend(1.0);
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
}
