//! Picking and dragging: the particle under the pointer, and where it is dragged to.

use crate::math::is_drawable;
use crate::viewing::camera::{Camera, Ray};
use glam::{DVec3, Vec3};
use msd_core::obstacles::Placed;
use msd_core::{Real, Shape, Snapshot, Vector};

/// Returns the smallest box around all particles, lowest and highest corner, metres.
///
/// Positions that are not finite are left out; without particles the result is `None`.
pub fn bounds<R: Real>(snapshot: &Snapshot<'_, R>) -> Option<(Vec3, Vec3)> {
    let points = snapshot.positions().map(|position| position.to_f32());
    let mut drawable = points.filter(|&point| is_drawable(point));
    let first = drawable.next()?;
    Some(drawable.fold((first, first), |(low, high), point| (low.min(point), high.max(point))))
}

/// Returns normal and offset, metres, of each plane and of the surface of each half space.
pub(crate) fn flats<R: Real>(snapshot: &Snapshot<'_, R>) -> impl Iterator<Item = (Vec3, f32)> {
    let planes = snapshot.planes.iter();
    let planes = planes.map(|plane| (plane.normal.to_f32(), plane.offset.to_f64() as f32));
    let solids = snapshot.solids.iter().filter(|solid| solid.shape == Shape::HalfSpace);
    planes.chain(solids.map(|solid| {
        let placed = Placed::new(solid, snapshot.time);
        let normal = placed.axes.y_axis;
        (normal.as_vec3(), normal.dot(placed.middle) as f32)
    }))
}

/// Returns the height of the highest level plane or half space, metres.
pub fn ground<R: Real>(snapshot: &Snapshot<'_, R>) -> Option<f32> {
    let level = flats(snapshot).filter(|(normal, _)| 0.9 < normal.y);
    level.map(|(_, offset)| offset).filter(|height| height.is_finite()).reduce(f32::max)
}

/// Distance around the particles within which solids count, as a part of the longest side of their
/// box.
const ROOM: f32 = 1.5;
/// Largest size of a solid that is seen as a whole, as a part of the same.
const LARGE: f32 = 4.0;

/// Returns the box of [`bounds`] and the solids near it: all of those that are not much larger, and
/// the near parts of others.
pub fn bounds_with_solids<R: Real>(snapshot: &Snapshot<'_, R>) -> Option<(Vec3, Vec3)> {
    let (low, high) = bounds(snapshot)?;
    let size = (high - low).max_element();
    let near = [low - ROOM * size, high + ROOM * size];
    let mut all = (low, high);
    for solid in snapshot.solids {
        let Some((middle, half)) = extents(&solid.shape) else { continue };
        let placed = Placed::new(solid, snapshot.time);
        let axes = [placed.axes.x_axis, placed.axes.y_axis, placed.axes.z_axis];
        let half = (0..3).map(|axis| axes[axis].abs() * half[axis]).sum::<DVec3>().as_vec3();
        let middle = (placed.middle + placed.axes * middle).as_vec3();
        let (mut a, mut b) = (middle - half, middle + half);
        let is_near = a.cmple(near[1]).all() && near[0].cmple(b).all();
        if !is_near || !is_drawable(a) || !is_drawable(b) {
            continue;
        }
        if LARGE * size < (b - a).max_element() {
            (a, b) = (a.max(near[0]), b.min(near[1]));
        }
        all = (all.0.min(a), all.1.max(b));
    }
    Some(all)
}

/// The middle and half of the sides of the box around a shape, metres; none without an end.
fn extents(shape: &Shape) -> Option<(DVec3, DVec3)> {
    let half = match *shape {
        Shape::Sphere { radius } => DVec3::splat(radius),
        Shape::Capsule { radius, length } => DVec3::new(radius, radius + 0.5 * length, radius),
        Shape::Cylinder { radius, length } => DVec3::new(radius, 0.5 * length, radius),
        Shape::Torus { radius, tube } => DVec3::new(radius + tube, tube, radius + tube),
        Shape::Box { size } => 0.5 * size,
        Shape::Mesh(ref grid) => {
            let first = *grid.corners.first()?;
            let corners = grid.corners.iter();
            let (low, high) =
                corners.fold((first, first), |(low, high), &at| (low.min(at), high.max(at)));
            return Some(((low + high) * 0.5, (high - low) * 0.5));
        }
        Shape::HalfSpace => return None,
    };
    Some((DVec3::ZERO, half))
}

/// Returns the box of [`bounds_with_solids`] and the ground below it, as far as that is near enough
/// to be seen beside it.
pub fn bounds_with_ground<R: Real>(snapshot: &Snapshot<'_, R>) -> Option<(Vec3, Vec3)> {
    let (mut low, high) = bounds_with_solids(snapshot)?;
    let room = 0.6 * (high - low).max_element();
    if let Some(height) = ground(snapshot) {
        low.y = low.y.min(height.max(low.y - room));
    }
    Some((low, high))
}

/// Returns the particle nearest to the pointer within `radius`, pixels; of several, a near one
/// wins over one behind it.
///
/// `pointer` is in pixels from the upper left corner of a picture of `size` pixels. The score is
/// the distance on the screen plus the distance behind the foremost candidate, measured in
/// diameters of the search disc at that depth.
pub fn pick<R: Real>(
    snapshot: &Snapshot<'_, R>,
    camera: &Camera,
    pointer: [f32; 2],
    size: [f32; 2],
    radius: f32,
) -> Option<usize> {
    // Written so that NaN is refused.
    if !(0.0 < size[0] && 0.0 < size[1]) {
        return None;
    }
    let aspect = size[0] / size[1];
    let on_screen = |(index, point): (usize, Vec3)| {
        let [x, y] = camera.project(point, aspect)?;
        let dx = (x + 1.0) * 0.5 * size[0] - pointer[0];
        let dy = (1.0 - y) * 0.5 * size[1] - pointer[1];
        let pixels = dx.hypot(dy);
        (pixels <= radius).then(|| (index, pixels, camera.depth(point)))
    };
    let points = snapshot.positions().map(|position| position.to_f32());
    let candidates: Vec<_> = points.enumerate().filter_map(on_screen).collect();
    let nearest = candidates.iter().map(|&(_, _, depth)| depth).reduce(f32::min)?;
    let metres_per_pixel = 2.0 * nearest * camera.tangents(aspect)[1] / size[1];
    let diameter = (2.0 * radius * metres_per_pixel).max(f32::MIN_POSITIVE);
    let score = |&(_, pixels, depth): &(usize, f32, f32)| {
        pixels / radius.max(f32::MIN_POSITIVE) + (depth - nearest) / diameter
    };
    let best = candidates.iter().min_by(|a, b| score(a).total_cmp(&score(b)))?;
    Some(best.0)
}

/// Returns where a ray meets the plane through `through` that faces the camera, metres.
///
/// That is where a pointer drags a particle it holds: at the depth where it was taken. A ray that
/// misses the plane leaves the point where it is.
pub fn drag_point(camera: &Camera, ray: &Ray, through: Vec3) -> Vec3 {
    let forward = camera.forward();
    let speed = forward.dot(ray.direction);
    let distance = forward.dot(through - ray.origin) / speed;
    let point = ray.origin + ray.direction * distance;
    let hits = 0.0 < speed && 0.0 <= distance && is_drawable(point);
    if hits { point } else { through }
}
