//! Picking of the particle or the solid under the pointer.

use crate::viewer::Viewport;
use egui::Pos2;
use glam::Vec3;
use msd_core::obstacles::{Obstacle, Placed};
use msd_core::{Real, Snapshot, Vector};
use msd_render::Ray;
use msd_run::{Runner, on};

/// Largest distance from a click to a particle that it picks, points.
const REACH: f32 = 18.0;

/// An object that the mouse can grab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Taken {
    /// A particle.
    Particle(usize),
    /// A solid, at a point of its surface, metres.
    Solid(usize, Vec3),
}

/// A particle that lies deeper than a solid by more than this part of the solid's depth is hidden:
/// a body that lies on a solid is picked before the solid.
const COVER: f32 = 0.05;

/// Returns the object under a point of the window: a particle, unless a solid hides it.
pub(super) fn pick_any(viewport: &Viewport, runner: &Runner, at: Pos2) -> Option<Taken> {
    let particle = pick(viewport, runner, at);
    let ray = viewport.ray(at);
    let solid = on!(runner, simulation => nearest_solid(&simulation.snapshot(), &ray));
    let Some((solid, distance)) = solid else { return particle.map(Taken::Particle) };
    let place = ray.origin + ray.direction * distance;
    let is_hidden = |&particle: &usize| {
        let position = on!(runner, simulation => simulation.position(particle).to_f64());
        let depth = viewport.camera.depth(place);
        (1.0 + COVER) * depth < viewport.camera.depth(position.as_vec3())
    };
    Some(match particle.filter(|particle| !is_hidden(particle)) {
        Some(particle) => Taken::Particle(particle),
        None => Taken::Solid(solid, place),
    })
}

/// Most steps along a ray to a solid, and the part of the gap that each step covers: the distance
/// to a mesh is approximate.
const MOST_STEPS: usize = 256;
const SAFE: f64 = 0.9;

/// Returns the first solid along a ray and its distance, metres, by sphere tracing (Hart, 1996):
/// each step is as long as the gap to the nearest surface.
fn nearest_solid<R: Real>(snapshot: &Snapshot<'_, R>, ray: &Ray) -> Option<(usize, f32)> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let hits = snapshot.solids.iter().enumerate().filter_map(|(solid, row)| {
        let placed = Placed::new(row, snapshot.time);
        let far = (placed.middle - origin).length() + row.shape.reach();
        // Infinite solids are ground: if one could be grabbed, no place would be left to orbit.
        if far.is_infinite() {
            return None;
        }
        let mut distance = 0.0;
        for _ in 0..MOST_STEPS {
            let gap: f64 = placed.gap(origin + direction * distance, snapshot.time);
            if gap <= 1e-3 * distance {
                return Some((solid, distance as f32));
            }
            distance += SAFE * gap;
            if far < distance {
                return None;
            }
        }
        None
    });
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the particle under a point of the window: the nearest corner of the surface there, or a
/// particle close by.
pub(super) fn pick(viewport: &Viewport, runner: &Runner, at: Pos2) -> Option<usize> {
    on!(runner, simulation => pick_in(viewport, &simulation.snapshot(), at))
}

fn pick_in<R: Real>(viewport: &Viewport, snapshot: &Snapshot<'_, R>, at: Pos2) -> Option<usize> {
    let position = |particle: usize| snapshot.position(particle).to_f32();
    let ray = viewport.ray(at);
    let hit = nearest_triangle(snapshot, &ray);
    let Viewport { camera, rect } = viewport;
    let pointer = at - rect.min;
    let (pointer, size) = ([pointer.x, pointer.y], [rect.width(), rect.height()]);
    let close = msd_render::pick(snapshot, camera, pointer, size, REACH);
    let Some((corners, distance)) = hit else { return close };
    // A particle in front of the surface, as of a rope, wins over the surface.
    let depth = camera.depth(ray.origin + ray.direction * distance);
    let in_front = close.filter(|&particle| camera.depth(position(particle)) < depth);
    in_front.or_else(|| {
        let away = |&particle: &usize| {
            viewport.project(position(particle)).map_or(f32::INFINITY, |place| place.distance(at))
        };
        corners.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)))
    })
}

/// Returns the particles of the first triangle along a ray, and the distance to it.
fn nearest_triangle<R: Real>(snapshot: &Snapshot<'_, R>, ray: &Ray) -> Option<([usize; 3], f32)> {
    let surfaces = snapshot.bodies.iter().map(|body| &body.surface);
    let triangles = surfaces.flat_map(|surface| surface.particles());
    let triangles = triangles.map(|corners| corners.map(|particle| particle as usize));
    let hits = triangles.filter_map(|particles| {
        let corners = particles.map(|particle| snapshot.position(particle).to_f32());
        Some((particles, crossing(ray, corners)?))
    });
    hits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the distance along a ray to a triangle (Möller and Trumbore, 1997).
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
    use egui::{Rect, pos2};
    use glam::DVec3;
    use msd_core::{Material, Scene, Settings, Shape, Solid, shape};
    use msd_render::Camera;
    use msd_scene::Precision;

    fn viewport() -> Viewport {
        let rect = Rect::from_min_max(pos2(170.0, 20.0), pos2(970.0, 620.0));
        Viewport { camera: Camera::default(), rect }
    }

    fn block() -> Runner {
        let part = shape::block([3, 3, 3], 2.0, Material::default()).expect("a valid size");
        Runner::new(&Scene::of("block", part), Settings::default(), Precision::F32)
            .expect("a valid scene")
    }

    #[test]
    fn the_middle_of_a_face_belongs_to_a_corner_of_that_face() {
        // Close up, so that the corners are far from the pointer.
        let mut viewport = viewport();
        viewport.camera = Camera { distance: 6.0, yaw: 0.0, pitch: 0.0, ..viewport.camera };
        let front = Vec3::new(0.9, 0.9, 2.0);
        let at = viewport.project(front).expect("in front");
        let runner = block();
        let picked = pick(&viewport, &runner, at).expect("the face is under the pointer");
        let position = on!(&runner, simulation => simulation.position(picked).to_f64().as_vec3());
        assert_eq!(position.z, 2.0);
        assert!(position.x.abs() <= 2.0 && (position - front).length() < 2.0);
    }

    #[test]
    fn a_solid_is_taken_where_it_hides_the_body_and_not_where_the_body_lies_on_it() {
        let at = viewport().rect.center();
        let middle = viewport().camera.target.as_dvec3();
        let towards_eye = -viewport().camera.forward().as_dvec3();
        let taken = |place: DVec3, radius: f64| {
            let part = shape::block([3, 3, 3], 2.0, Material::default()).expect("a valid size");
            let ball = Solid { position: place, ..Solid::new(Shape::Sphere { radius }) };
            let mut scene = Scene { solids: vec![ball], ..Scene::of("block", part) };
            scene.particles.iter_mut().for_each(|particle| particle.position += middle);
            let runner = Runner::new(&scene, Settings::default(), Precision::F32).expect("a scene");
            pick_any(&viewport(), &runner, at).expect("something is there")
        };
        let near = middle + towards_eye * 6.0;
        let Taken::Solid(0, hit) = taken(near, 1.0) else { panic!("the ball is in front") };
        assert!((hit.as_dvec3() - near - towards_eye).length() < 0.02, "{hit}");
        // A ball behind the block, or inside it with a surface that is no nearer than the block's.
        assert!(matches!(taken(middle - towards_eye * 6.0, 1.0), Taken::Particle(_)));
        assert!(matches!(taken(middle, 0.5), Taken::Particle(_)));
    }

    #[test]
    fn beside_the_body_there_is_nothing() {
        assert_eq!(pick(&viewport(), &block(), pos2(175.0, 25.0)), None);
        assert_eq!(pick_any(&viewport(), &block(), pos2(175.0, 25.0)), None);
    }
}
