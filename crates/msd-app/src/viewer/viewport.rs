//! What of the scene is under a point of the window, and where in the window is a particle?
//!
//! The window is in points here, as egui measures it: the renderer alone knows pixels.

use egui::{Pos2, Rect, pos2};
use glam::Vec3;
use msd_core::{Real, Snapshot, Vector};
use msd_lab::{Runner, on};
use msd_render::{Camera, Ray};

/// How near to a particle a click must be, points.
const REACH: f32 = 18.0;

/// A camera and the part of the window that shows what it sees.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// The camera.
    pub camera: Camera,
    /// The part of the window, points.
    pub rect: Rect,
}

impl Lens {
    fn aspect(&self) -> f32 {
        self.rect.width() / self.rect.height()
    }

    /// The ray into the scene through a point of the window.
    pub fn ray(&self, at: Pos2) -> Ray {
        let across = (at - self.rect.center()) / (self.rect.size() * 0.5);
        self.camera.ray(across.x, -across.y, self.aspect())
    }

    /// Where a point of the scene appears in the window; nowhere if it is behind the camera.
    pub fn place(&self, point: Vec3) -> Option<Pos2> {
        let [x, y] = self.camera.project(point, self.aspect())?;
        let (centre, half) = (self.rect.center(), self.rect.size() * 0.5);
        Some(pos2(centre.x + x * half.x, centre.y - y * half.y))
    }

    /// Where a hand that holds `through` is when the pointer is at a point of the window.
    pub fn drag_point(&self, at: Pos2, through: Vec3) -> Vec3 {
        msd_render::drag_point(&self.camera, &self.ray(at), through)
    }

    /// The particle under a point of the window: the nearest corner of the surface there, or a
    /// particle close by.
    pub fn pick(&self, runner: &Runner, at: Pos2) -> Option<usize> {
        on!(runner, simulation => self.pick_in(&simulation.snapshot(), at))
    }

    fn pick_in<R: Real>(&self, snapshot: &Snapshot<'_, R>, at: Pos2) -> Option<usize> {
        let position = |particle: usize| snapshot.position(particle).to_f32();
        let ray = self.ray(at);
        let hit = nearest_triangle(snapshot, &ray);
        let pointer = at - self.rect.min;
        let (pointer, size) = ([pointer.x, pointer.y], [self.rect.width(), self.rect.height()]);
        let close = msd_render::pick(snapshot, &self.camera, pointer, size, REACH);
        let Some((corners, distance)) = hit else { return close };
        // A particle in front of the surface, as of a rope, wins over the surface.
        let depth = self.camera.depth(ray.origin + ray.direction * distance);
        let in_front = close.filter(|&particle| self.camera.depth(position(particle)) < depth);
        in_front.or_else(|| {
            let away = |&particle: &usize| {
                self.place(position(particle)).map_or(f32::INFINITY, |place| place.distance(at))
            };
            corners.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)))
        })
    }
}

/// The particles of the triangle that a ray meets first, and how far along it.
fn nearest_triangle<R: Real>(snapshot: &Snapshot<'_, R>, ray: &Ray) -> Option<([usize; 3], f32)> {
    let surfaces = snapshot.bodies.iter().map(|body| &body.surface);
    let triangles = surfaces.flat_map(|surface| {
        let particle = |corner: u32| surface.corners[corner as usize].particle as usize;
        surface.triangles.iter().map(move |triangle| triangle.map(particle))
    });
    let hits = triangles.filter_map(|particles| {
        let corners = particles.map(|particle| snapshot.position(particle).to_f32());
        Some((particles, crossing(ray, corners)?))
    });
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// How far along a ray a triangle is met (Möller and Trumbore, 1997).
fn crossing(ray: &Ray, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let normal = ray.direction.cross(ac);
    let determinant = ab.dot(normal);
    if determinant == 0.0 {
        return None;
    }
    let from_a = ray.origin - a;
    let u = from_a.dot(normal) / determinant;
    let across = from_a.cross(ab);
    let v = ray.direction.dot(across) / determinant;
    let distance = ac.dot(across) / determinant;
    (0.0 <= u && 0.0 <= v && u + v <= 1.0 && 0.0 < distance).then_some(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Material, Scene, Settings, shape};
    use msd_lab::Precision;

    fn lens() -> Lens {
        let rect = Rect::from_min_max(pos2(170.0, 20.0), pos2(970.0, 620.0));
        Lens { camera: Camera::default(), rect }
    }

    fn block() -> Runner {
        let part = shape::block([3, 3, 3], 2.0, Material::default()).expect("a valid size");
        Runner::new(&Scene::of("block", part), Settings::default(), Precision::F32)
            .expect("a valid scene")
    }

    #[test]
    fn a_point_on_a_ray_appears_where_the_ray_started() {
        let at = pos2(400.0, 200.0);
        let ray = lens().ray(at);
        let place = lens().place(ray.origin + ray.direction * 7.0).expect("in front");
        // Single precision at a few hundred points.
        assert!(place.distance(at) < 1e-2, "{place:?}");
    }

    #[test]
    fn the_middle_of_a_face_belongs_to_a_corner_of_that_face() {
        // Close up, so that the corners are far from the pointer.
        let mut lens = lens();
        lens.camera = Camera { distance: 6.0, yaw: 0.0, pitch: 0.0, ..lens.camera };
        let front = Vec3::new(0.9, 0.9, 2.0);
        let at = lens.place(front).expect("in front");
        let runner = block();
        let picked = lens.pick(&runner, at).expect("the face is under the pointer");
        let position = on!(&runner, simulation => simulation.position(picked).to_f64().as_vec3());
        assert_eq!(position.z, 2.0);
        assert!(position.x.abs() <= 2.0 && (position - front).length() < 2.0);
    }

    #[test]
    fn beside_the_body_there_is_nothing() {
        assert_eq!(lens().pick(&block(), pos2(175.0, 25.0)), None);
    }

    #[test]
    fn dragging_keeps_the_depth() {
        let lens = lens();
        let held = Vec3::new(1.0, 2.0, 0.5);
        let dragged = lens.drag_point(pos2(700.0, 100.0), held);
        assert!((lens.camera.depth(dragged) - lens.camera.depth(held)).abs() < 1e-4);
    }
}
