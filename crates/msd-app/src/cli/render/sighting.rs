//! The camera of `msd render`: position, target, and rotation during a film.

use crate::cli::arguments::{ColourBy, RenderArguments, Sight};
use crate::cli::run::prepare::Prepared;
use crate::cli::steps::{Interrupt, Steps};
use msd_app::viewer::{go_to, turn_to, usual_colours};
use msd_render::{Camera, Quantity, Style, View, bounds_with_ground, ground};
use msd_run::on;
use msd_scene::Viewpoint;

/// Reference size of lines and legend, pixels; larger pictures enlarge them.
const SIZE: [f32; 2] = [1280.0, 720.0];

/// View of a picture or a film.
pub struct Sighting {
    view: View,
    /// Rotation of the camera over a whole film, radians.
    turn: f32,
    /// Width of a picture over its height.
    aspect: f32,
    /// Viewpoint set by the author of the scene.
    viewpoint: Viewpoint,
    /// Least height of the camera, metres.
    ground: Option<f32>,
}

/// Number of directions in which an orbiting camera must keep everything in the picture.
const DIRECTIONS: u16 = 24;

impl Sighting {
    /// Reads the command line; [`Sighting::frame`] adds the bounds of the scene later.
    pub fn new(arguments: &RenderArguments, prepared: &Prepared, steps: &[u64]) -> Self {
        let [width, height] = arguments.size.map(|side| side as f32);
        let is_open = arguments.background.is_some();
        let style = Style {
            surfaces: !arguments.no_surfaces,
            wireframe: arguments.wireframe,
            colour_by: arguments.colour_by.map(quantity).or(usual_colours(&prepared.name)),
            full_scale: arguments.full_scale.map(|full| full as f32),
            legend: !arguments.no_legend,
            particles: arguments.particles,
            sky: !is_open,
            planes: !is_open,
            pixels_per_point: (width / SIZE[0]).min(height / SIZE[1]).max(1.0),
            ..Style::default()
        };
        let mut view = View { style, ..View::default() };
        turn_to(&mut view.camera, prepared.camera);
        let radians = |degrees: f64| degrees.to_radians() as f32;
        if let Some(Sight::Side([yaw, pitch])) = arguments.camera {
            (view.camera.yaw, view.camera.pitch) = (radians(yaw), radians(pitch));
        }
        view.camera.yaw = arguments.yaw_deg.map_or(view.camera.yaw, radians);
        view.camera.pitch = arguments.pitch_deg.map_or(view.camera.pitch, radians);
        let lasting = arguments.frames.map_or(0.0, |film| steps.len() as f64 * film.every);
        let turn = match arguments.camera {
            Some(Sight::Orbit(None)) => std::f32::consts::TAU,
            Some(Sight::Orbit(Some(rate))) => radians(rate * lasting),
            _ => 0.0,
        };
        // A side given on the command line overrides the viewpoint of the scene.
        let is_turned = arguments.camera.is_some()
            || arguments.yaw_deg.is_some()
            || arguments.pitch_deg.is_some();
        let viewpoint = if is_turned { Viewpoint::default() } else { prepared.camera };
        // A given elevation may also be below the ground.
        let level = on!(&prepared.runner, simulation => ground(&simulation.snapshot()));
        let ground = level.filter(|_| arguments.pitch_deg.is_none());
        Sighting { view, turn, aspect: width / height, viewpoint, ground }
    }

    /// Returns the quantity that colours represent.
    pub fn quantity(&self) -> Option<Quantity> {
        self.view.style.colour_by
    }

    /// Gives all frames of a film the same scale, which covers `largest`, unless the command line
    /// sets one.
    pub fn choose_scale(&mut self, largest: f64) {
        let style = &mut self.view.style;
        let full = style.colour_by.map(|quantity| quantity.full_scale(largest));
        style.full_scale = style.full_scale.or(full);
    }

    /// Moves the camera as near as possible with the whole box in the picture, from every angle.
    pub fn frame(&mut self, bounds: Option<(glam::Vec3, glam::Vec3)>) {
        let (Some(bounds), aspect) = (bounds, self.aspect) else { return };
        let start = self.view.camera;
        self.view.camera.frame(bounds, aspect);
        go_to(&mut self.view.camera, self.viewpoint);
        if self.turn == 0.0 {
            return;
        }
        for direction in 1..DIRECTIONS {
            let part = f32::from(direction) / f32::from(DIRECTIONS);
            let mut camera = Camera { yaw: start.yaw + self.turn * part, ..start };
            camera.frame(bounds, aspect);
            self.view.camera.distance = self.view.camera.distance.max(camera.distance);
        }
    }

    /// Returns the view of a frame at a fraction of a film, from 0 to 1.
    pub fn view(&self, part: f64) -> View {
        let mut view = self.view;
        view.camera.yaw += self.turn * part as f32;
        self.ground.iter().for_each(|&height| view.camera.rise_above(height));
        view
    }
}

fn quantity(colour_by: ColourBy) -> Quantity {
    match colour_by {
        ColourBy::Strain => Quantity::Strain,
        ColourBy::Force => Quantity::Force,
        ColourBy::Energy => Quantity::Energy,
        ColourBy::Speed => Quantity::Speed,
    }
}

/// Runs ahead for the bounds of all frames of a film: the box around all particles, and the largest
/// absolute value of the coloured quantity.
pub fn seen(
    prepared: &Prepared,
    quantity: Option<Quantity>,
    (steps, interrupt): (&[u64], &Interrupt),
) -> (Option<(glam::Vec3, glam::Vec3)>, f64) {
    let mut runner = prepared.runner.clone();
    let (mut taken, mut all) = (0, None::<(glam::Vec3, glam::Vec3)>);
    let mut largest = 0.0;
    let mut progress = Steps::new(steps.last().copied().unwrap_or(0), "computing the view");
    for &step in steps {
        while taken < step {
            // The actual run repeats the error and reports it.
            if interrupt.is_asked() || runner.step().is_err() {
                return (all, largest);
            }
            taken += 1;
            progress.tell(taken);
        }
        let now = on!(&runner, simulation => bounds_with_ground(&simulation.snapshot()));
        all = match (all, now) {
            (Some((low, high)), Some((a, b))) => Some((low.min(a), high.max(b))),
            (all, now) => all.or(now),
        };
        if let Some(quantity) = quantity {
            let now = on!(&runner, simulation => quantity.largest(&simulation.snapshot()));
            largest = f64::max(largest, now);
        }
    }
    (all, largest)
}
