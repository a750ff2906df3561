//! The viewport: a camera, and the part of the window that shows what it sees.
//!
//! The window is in points here, as egui measures it: the renderer alone knows pixels.

use egui::{Pos2, Rect, pos2};
use glam::Vec3;
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
    fn dragging_keeps_the_depth() {
        let viewport = viewport();
        let held = Vec3::new(1.0, 2.0, 0.5);
        let dragged = viewport.drag_point(pos2(700.0, 100.0), held);
        assert!((viewport.camera.depth(dragged) - viewport.camera.depth(held)).abs() < 1e-4);
    }
}
