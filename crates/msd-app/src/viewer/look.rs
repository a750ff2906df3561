//! The camera of a viewer: framing and following the scene, and its last view.

use super::{Outlook, Viewer};
use glam::Vec3;
use msd_film::{go_to, turn_to};
use msd_render::Camera;
use msd_run::on;
use msd_scene::Viewpoint;

/// Time constant of the following camera, seconds.
const FOLLOW_TIME: f64 = 0.2;

/// Largest lag of the camera, relative to its distance, so that fast bodies stay in view.
const BEHIND: f32 = 0.25;

/// Distance from the destination, relative to that of the target, at which the camera has arrived:
/// a fraction of a pixel.
const ARRIVED: f32 = 2e-4;

/// Growth of a scene since its start that counts as divergence.
const DEBRIS: f64 = 10.0;

/// Target of the camera.
#[derive(Debug)]
pub struct Aim {
    /// Whether the camera keeps the scene in the middle of the view.
    pub follow: bool,
    /// Whether the scene will be framed once the size of the window is known.
    pub(super) unframed: bool,
    /// The camera after the scene was framed.
    pub(super) framed: Camera,
    /// Last target, and its offset from the centre of the scene by the user.
    pub(super) aimed: Vec3,
    pub(super) beside: Vec3,
    /// Whether the camera is still moving.
    pub(super) is_gliding: bool,
}

impl Default for Aim {
    fn default() -> Self {
        let (framed, aimed, beside) = (Camera::default(), Vec3::ZERO, Vec3::ZERO);
        Aim { follow: true, unframed: true, framed, aimed, beside, is_gliding: false }
    }
}

impl Viewer {
    /// Frames every particle, nearby solids and the ground below.
    pub fn frame_all(&mut self) {
        let Some(subject) = self.subject() else { return };
        let rect = self.viewport().rect;
        let aspect = if rect.is_positive() { rect.aspect_ratio() } else { 1.5 };
        self.camera.frame(subject, aspect);
        // Extra space for the motion to come.
        self.camera.zoom(1.35);
        (self.aim.aimed, self.aim.beside) = (self.camera.target, Vec3::ZERO);
    }

    /// Returns the box around every particle, nearby solids and the ground below: low and high
    /// corner, metres.
    pub(super) fn subject(&self) -> Option<(Vec3, Vec3)> {
        let runner = self.session.runner();
        let (mut low, high) =
            on!(runner, simulation => msd_render::bounds_with_solids(&simulation.snapshot()))?;
        let room = (high - low).max_element().max(1.0);
        if let Some(ground) = self.ground() {
            // Ground far below is ignored: the scene would be a dot.
            low.y = low.y.min(ground.max(low.y - room));
        }
        Some((low, high))
    }

    /// Returns the height of the highest horizontal plane, metres.
    fn ground(&self) -> Option<f32> {
        on!(self.session.runner(), simulation => msd_render::ground(&simulation.snapshot()))
    }

    /// Frames a new scene once the size of the window is known.
    pub(crate) fn frame_once(&mut self) {
        if self.aim.unframed && self.layout.rect.is_positive() {
            self.aim.unframed = false;
            self.camera = Camera::default();
            let viewpoint = self.session.loaded().camera;
            turn_to(&mut self.camera, viewpoint);
            self.frame_all();
            // After `frame_all`, so that another target counts as an offset from the centre.
            go_to(&mut self.camera, viewpoint);
            self.aim.framed = self.camera;
            if let Some(&outlook) = self.preferences.cameras.get(&self.session.loaded().name) {
                self.look_again(outlook);
            }
        }
    }

    /// Restores the last camera of the scene. A following one starts at its destination, as the
    /// centre may have moved since.
    fn look_again(&mut self, outlook: Outlook) {
        // The centre from `frame_all`: the viewpoint of the scene may have another target.
        let middle = self.aim.aimed;
        self.camera = outlook.camera();
        if self.aim.follow {
            self.aim.beside = outlook.beside.into();
            self.camera.target = middle + self.aim.beside;
        }
        self.aim.aimed = self.camera.target;
    }

    /// Returns the current viewpoint.
    pub(super) fn viewpoint(&self) -> Viewpoint {
        let Camera { target, distance, yaw, pitch, .. } = self.camera;
        let degrees = |radians: f32| Some(f64::from(radians).to_degrees());
        Viewpoint {
            yaw_deg: degrees(yaw),
            pitch_deg: degrees(pitch),
            target: Some(target.to_array().map(f64::from)),
            distance: Some(f64::from(distance)),
        }
    }

    /// Stores the camera of the scene, if the user has moved it.
    pub(super) fn keep_camera(&mut self) {
        let look = |camera: &Camera| (camera.yaw, camera.pitch, camera.distance);
        let is_moved =
            look(&self.camera) != look(&self.aim.framed) || self.aim.beside != Vec3::ZERO;
        if !self.aim.unframed && is_moved {
            let outlook = Outlook::of(&self.camera, self.aim.beside);
            self.preferences.keep_outlook(&self.session.loaded().name, outlook);
        }
    }

    /// Moves the camera, once per frame, after the steps; `real` is the wall-clock time of the
    /// frame in seconds.
    ///
    /// It moves to the centre of the scene, not only by the motion of the centre: dragged bodies
    /// return into view. An offset by the user stays.
    pub fn look(&mut self, real: f64) {
        self.sharpness.follow(self.quality, self.session.pace());
        if self.layout.side_by_side && self.session.twin().is_none() {
            self.set_side_by_side(false);
        }
        self.aim.beside += self.camera.target - self.aim.aimed;
        self.aim.aimed = self.camera.target;
        if let Some(height) = self.ground() {
            self.camera.rise_above(height);
        }
        self.aim.is_gliding = false;
        if !self.aim.follow {
            self.aim.beside = Vec3::ZERO;
            return;
        }
        // The view stays still during a grab.
        if self.session.is_holding() {
            return;
        }
        let Some((low, high)) = self.subject() else { return };
        // The camera does not follow debris.
        let size = on!(self.session.runner(), simulation => simulation.model().size());
        if DEBRIS * size < f64::from((high - low).max_element()) {
            return;
        }
        let way = (low + high) * 0.5 + self.aim.beside - self.camera.target;
        let left = way * (-real / FOLLOW_TIME).exp() as f32;
        let part = way - left.clamp_length_max(BEHIND * self.camera.distance);
        if part.is_finite() {
            self.camera.target += part;
            self.aim.aimed = self.camera.target;
            self.aim.is_gliding = ARRIVED * self.camera.distance < (way - part).length();
        }
    }

    /// Returns the offset of a following camera from the centre of the bodies, metres.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn beside_middle(&self) -> Vec3 {
        // The centre that it follows includes the ground below.
        let everything = self.subject().map_or(Vec3::ZERO, |(low, high)| (low + high) * 0.5);
        let bodies = on!(self.session.runner(), simulation => {
            msd_render::bounds(&simulation.snapshot())
        });
        let bodies = bodies.map_or(everything, |(low, high)| (low + high) * 0.5);
        self.aim.beside + everything - bodies
    }

    /// Returns whether the camera is still moving, and so needs more frames.
    pub fn is_gliding(&self) -> bool {
        self.aim.is_gliding
    }
}
