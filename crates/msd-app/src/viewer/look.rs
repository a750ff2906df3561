//! The camera of a viewer: on everything, after it as it moves, or as it was left.

use super::{Outlook, Viewer};
use glam::Vec3;
use msd_film::{go_to, turn_to};
use msd_render::Camera;
use msd_run::on;
use msd_scene::Viewpoint;

/// How soon the camera follows, seconds.
const FOLLOW_TIME: f64 = 0.2;

/// How far the camera falls behind at most, as a part of its distance: what is fast stays in the
/// picture.
const BEHIND: f32 = 0.25;

/// The camera is where it goes once it is as near as this part of its distance: a fraction of a
/// pixel.
const ARRIVED: f32 = 2e-4;

/// A scene that is so many times as large as at its start has blown up.
const DEBRIS: f64 = 10.0;

/// What the camera follows.
#[derive(Debug)]
pub struct Aim {
    /// Whether it keeps everything in the middle of the picture.
    pub follow: bool,
    /// Whether the scene is to be brought into view once the size of the window is known.
    pub(super) unframed: bool,
    /// The camera as it brought the scene into view.
    pub(super) framed: Camera,
    /// Where it was left looking, and how far beside everything the user moved it.
    pub(super) aimed: Vec3,
    pub(super) beside: Vec3,
    /// Whether it is still on its way.
    pub(super) is_gliding: bool,
}

impl Default for Aim {
    fn default() -> Self {
        let (framed, aimed, beside) = (Camera::default(), Vec3::ZERO, Vec3::ZERO);
        Aim { follow: true, unframed: true, framed, aimed, beside, is_gliding: false }
    }
}

impl Viewer {
    /// Brings every particle, the solids near by and the ground below into view.
    pub fn frame_all(&mut self) {
        let Some(subject) = self.subject() else { return };
        let rect = self.viewport().rect;
        let aspect = if rect.is_positive() { rect.aspect_ratio() } else { 1.5 };
        self.camera.frame(subject, aspect);
        // Room for what it is about to do.
        self.camera.zoom(1.35);
        (self.aim.aimed, self.aim.beside) = (self.camera.target, Vec3::ZERO);
    }

    /// The box around every particle, the solids near by and the ground below: low and high corner,
    /// metres.
    pub(super) fn subject(&self) -> Option<(Vec3, Vec3)> {
        let runner = self.session.runner();
        let (mut low, high) =
            on!(runner, simulation => msd_render::bounds_with_solids(&simulation.snapshot()))?;
        let room = (high - low).max_element().max(1.0);
        if let Some(ground) = self.ground() {
            // Ground far below is left out: the scene would be a dot.
            low.y = low.y.min(ground.max(low.y - room));
        }
        Some((low, high))
    }

    /// The height of the highest level plane, metres.
    fn ground(&self) -> Option<f32> {
        on!(self.session.runner(), simulation => msd_render::ground(&simulation.snapshot()))
    }

    /// Brings a new scene into view once the size of the window is known.
    pub(crate) fn frame_once(&mut self) {
        if self.aim.unframed && self.layout.rect.is_positive() {
            self.aim.unframed = false;
            self.camera = Camera::default();
            let viewpoint = self.session.loaded().camera;
            turn_to(&mut self.camera, viewpoint);
            self.frame_all();
            // Beside the middle of everything, which a camera that follows is aimed at.
            go_to(&mut self.camera, viewpoint);
            self.aim.framed = self.camera;
            if let Some(&outlook) = self.preferences.cameras.get(&self.session.loaded().name) {
                self.look_again(outlook);
            }
        }
    }

    /// Looks at the scene as it was looked at before. A camera that follows is where it would go:
    /// the middle was elsewhere when it was left.
    fn look_again(&mut self, outlook: Outlook) {
        // A scene may say where its own camera looks; all of it was framed before.
        let middle = self.aim.aimed;
        self.camera = outlook.camera();
        if self.aim.follow {
            self.aim.beside = outlook.beside.into();
            self.camera.target = middle + self.aim.beside;
        }
        self.aim.aimed = self.camera.target;
    }

    /// From where the scene is looked at now.
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

    /// Remembers how the scene is looked at, if the user chose that.
    pub(super) fn keep_camera(&mut self) {
        let look = |camera: &Camera| (camera.yaw, camera.pitch, camera.distance);
        let is_moved =
            look(&self.camera) != look(&self.aim.framed) || self.aim.beside != Vec3::ZERO;
        if !self.aim.unframed && is_moved {
            let outlook = Outlook::of(&self.camera, self.aim.beside);
            self.preferences.keep_outlook(&self.session.loaded().name, outlook);
        }
    }

    /// Lets the camera keep up, once per frame, after the steps; `real` is the wall-clock time of
    /// the frame in seconds.
    ///
    /// It turns to the middle of everything, not only as far as that moved: what was dragged
    /// away comes back into the picture. A camera that the user moved aside stays aside.
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
        // While something is held the picture stays still.
        if self.session.is_holding() {
            return;
        }
        let Some((low, high)) = self.subject() else { return };
        // Debris is not followed: what is left is where the rest was.
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

    /// How far beside the middle of everything a camera that follows looks, metres.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn beside_middle(&self) -> Vec3 {
        // The middle that it follows has the ground below in it.
        let everything = self.subject().map_or(Vec3::ZERO, |(low, high)| (low + high) * 0.5);
        let bodies = on!(self.session.runner(), simulation => {
            msd_render::bounds(&simulation.snapshot())
        });
        let bodies = bodies.map_or(everything, |(low, high)| (low + high) * 0.5);
        self.aim.beside + everything - bodies
    }

    /// Whether the camera is still on its way to what it follows, and wants more frames.
    pub fn is_gliding(&self) -> bool {
        self.aim.is_gliding
    }
}
