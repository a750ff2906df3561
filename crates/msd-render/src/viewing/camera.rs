//! An orbit camera: a target, a distance and two angles.

use crate::math::is_drawable;
use glam::camera::rh::{proj::directx, view::look_to_mat4};
use glam::{Mat4, Vec3};

/// The steepest pitch, radians; straight down the view would have no up direction.
const MAX_PITCH: f32 = 1.55;
/// The nearest and the farthest distance to the target, metres.
const DISTANCES: (f32, f32) = (1e-3, 1e8);
/// Room left around a framed box, as a factor on its size.
const MARGIN: f32 = 1.08;
/// Least height of the eye above ground, as a fraction of the distance to the target.
const CLEARANCE: f32 = 0.02;
/// The near plane as a fraction of the distance to the target.
const NEAR: f32 = 0.005;

/// A half line from the camera into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, metres.
    pub origin: Vec3,
    /// Direction, length one.
    pub direction: Vec3,
}

/// A camera that looks at a target from a distance and can turn around it; y is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point looked at, metres. Default the origin.
    pub target: Vec3,
    /// Distance from the target, metres; from 1e-3 to 1e8. Default 20.
    pub distance: f32,
    /// Angle about the y axis, radians; at 0 the camera is on the +z side. Default 0.6.
    pub yaw: f32,
    /// Angle above the horizon, radians; from −1.55 to 1.55. Default 0.35.
    pub pitch: f32,
    /// Vertical angle of view, degrees; from 1 to 150. Default 38.
    pub fov_deg: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self { target: Vec3::ZERO, distance: 20.0, yaw: 0.6, pitch: 0.35, fov_deg: 38.0 }
    }
}

impl Camera {
    /// Returns the position of the eye, metres.
    pub fn eye(&self) -> Vec3 {
        let camera = self.usable();
        camera.target - camera.forward() * camera.distance
    }

    /// Returns the direction of view, length one.
    pub fn forward(&self) -> Vec3 {
        let camera = self.usable();
        let (sin_yaw, cos_yaw) = camera.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = camera.pitch.sin_cos();
        -Vec3::new(cos_pitch * sin_yaw, sin_pitch, cos_pitch * cos_yaw)
    }

    /// Returns the direction to the right of the picture, length one.
    pub fn right(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.usable().yaw.sin_cos();
        Vec3::new(cos_yaw, 0.0, -sin_yaw)
    }

    /// Returns the direction to the top of the picture, length one.
    pub fn up(&self) -> Vec3 {
        self.right().cross(self.forward())
    }

    /// Returns the matrix from the world to the camera's frame.
    pub fn view_matrix(&self) -> Mat4 {
        look_to_mat4(self.eye(), self.forward(), self.up())
    }

    /// Returns the matrix from the camera's frame to clip space, for a picture `aspect` times as
    /// wide as high.
    ///
    /// Depth is 1 at the near plane and 0 at infinity: a float keeps its precision far away.
    pub fn projection_matrix(&self, aspect: f32) -> Mat4 {
        let camera = self.usable();
        let fov = camera.fov_deg.to_radians();
        directx::perspective_infinite_reverse(fov, usable_aspect(aspect), camera.near())
    }

    /// Returns the matrix from the world to clip space.
    pub fn view_projection(&self, aspect: f32) -> Mat4 {
        self.projection_matrix(aspect) * self.view_matrix()
    }

    /// Returns the distance of the near plane, metres.
    pub fn near(&self) -> f32 {
        self.usable().distance * NEAR
    }

    /// Returns the tangents of half the horizontal and half the vertical angle of view.
    pub fn tangents(&self, aspect: f32) -> [f32; 2] {
        let vertical = (0.5 * self.usable().fov_deg.to_radians()).tan();
        [vertical * usable_aspect(aspect), vertical]
    }

    /// Turns around the target: the scene follows a pointer moving `dx` right and `dy` down,
    /// radians.
    pub fn orbit(&mut self, dx: f32, dy: f32) {
        self.yaw -= dx;
        self.pitch += dy;
        *self = self.usable();
    }

    /// Moves the target so that the scene follows a pointer moving `dx` right and `dy` down,
    /// fractions of the height of the picture.
    pub fn pan(&mut self, dx: f32, dy: f32) {
        let height = 2.0 * self.usable().distance * self.tangents(1.0)[1];
        self.target += (self.up() * dy - self.right() * dx) * height;
        *self = self.usable();
    }

    /// Multiplies the distance from the target: less than one comes closer.
    pub fn zoom(&mut self, factor: f32) {
        if 0.0 < factor && factor.is_finite() {
            self.distance *= factor;
        }
        *self = self.usable();
    }

    /// Looks at the middle of a box and goes as near as all its corners stay in the picture.
    ///
    /// The angles do not change. A box that is a point or not finite is seen from the default
    /// distance.
    pub fn frame(&mut self, bounds: (Vec3, Vec3), aspect: f32) {
        *self = self.usable();
        let (low, high) = bounds;
        if !is_drawable(low) || !is_drawable(high) {
            return;
        }
        let half = (high - low).abs() * 0.5;
        let axes = [self.right(), self.up(), -self.forward()];
        let tangents = self.tangents(aspect);
        let mut distance = 0.0f32;
        for corner in 0..8 {
            let sign = |bit: i32| if corner & bit == 0 { -1.0 } else { 1.0 };
            let offset = half * Vec3::new(sign(1), sign(2), sign(4));
            let [x, y, towards] = axes.map(|axis| axis.dot(offset));
            let needed = (x.abs() / tangents[0]).max(y.abs() / tangents[1]) * MARGIN;
            distance = distance.max(towards + needed);
        }
        self.target = (low + high) * 0.5;
        self.distance = if 0.0 < distance { distance } else { Self::default().distance };
        *self = self.usable();
    }

    /// Turns up, about the target, until the eye is above a height, metres: of ground, say. Does
    /// nothing where the target is too far below it for that.
    pub fn rise_above(&mut self, height: f32) {
        *self = self.usable();
        let needed = (height - self.target.y) / self.distance + CLEARANCE;
        if needed <= 1.0 && self.pitch.sin() < needed {
            self.pitch = needed.asin();
        }
        *self = self.usable();
    }

    /// Returns the ray through a point of the picture: x from −1 left to 1 right, y from −1 bottom
    /// to 1 top.
    pub fn ray(&self, x: f32, y: f32, aspect: f32) -> Ray {
        let [horizontal, vertical] = self.tangents(aspect);
        let across = self.right() * (x * horizontal) + self.up() * (y * vertical);
        Ray { origin: self.eye(), direction: (self.forward() + across).normalize() }
    }

    /// Returns where a point appears in the picture, in the coordinates of [`Camera::ray`].
    ///
    /// Nothing if the point is not finite or not in front of the near plane. A point outside the
    /// picture has a coordinate beyond ±1.
    pub fn project(&self, point: Vec3, aspect: f32) -> Option<[f32; 2]> {
        let depth = self.depth(point);
        if !is_drawable(point) || depth < self.near() {
            return None;
        }
        let offset = point - self.eye();
        let [horizontal, vertical] = self.tangents(aspect);
        let x = self.right().dot(offset) / (depth * horizontal);
        let y = self.up().dot(offset) / (depth * vertical);
        Some([x, y])
    }

    /// Returns the distance of a point from the eye along the direction of view, metres.
    pub fn depth(&self, point: Vec3) -> f32 {
        self.forward().dot(point - self.eye())
    }

    /// The same camera with every field in its domain, so that no matrix is ever broken.
    pub(crate) fn usable(&self) -> Self {
        let fallback = Self::default();
        let pick = |value: f32, other: f32| if value.is_finite() { value } else { other };
        Self {
            target: if is_drawable(self.target) { self.target } else { fallback.target },
            distance: pick(self.distance, fallback.distance).clamp(DISTANCES.0, DISTANCES.1),
            yaw: pick(self.yaw, fallback.yaw) % std::f32::consts::TAU,
            pitch: pick(self.pitch, fallback.pitch).clamp(-MAX_PITCH, MAX_PITCH),
            fov_deg: pick(self.fov_deg, fallback.fov_deg).clamp(1.0, 150.0),
        }
    }
}

/// An aspect that a projection can use: a picture without height or width counts as square.
fn usable_aspect(aspect: f32) -> f32 {
    if aspect.is_finite() && 0.0 < aspect { aspect } else { 1.0 }
}
