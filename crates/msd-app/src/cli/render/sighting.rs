//! The view of `msd render`: from where it looks, at what, and how fast it turns.

use crate::cli::arguments::{ColourBy, RenderArguments, Sight};
use crate::cli::run::prepare::Prepared;
use crate::cli::steps::{Interrupt, Steps};
use msd_app::viewer::{go_to, turn_to, usual_colours};
use msd_render::{Camera, Quantity, Style, View, bounds_with_ground, ground};
use msd_run::on;
use msd_scene::Viewpoint;

/// The size for which lines and the legend are made, pixels; larger pictures enlarge them.
const SIZE: [f32; 2] = [1280.0, 720.0];

/// How a picture or a film looks at a scene.
pub struct Sighting {
    view: View,
    /// By how much the camera turns in the whole of a film, radians.
    turn: f32,
    /// By how much a picture is wider than high.
    aspect: f32,
    /// Where the author of the scene wants the camera.
    viewpoint: Viewpoint,
    /// The height that it stays above, metres.
    ground: Option<f32>,
}

/// Directions in which a camera that turns is asked whether all is in the picture.
const DIRECTIONS: u16 = 24;

impl Sighting {
    /// By what the command line says; it knows no scene yet, see [`Sighting::frame`].
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
        // Who asks for another side wants to see it all.
        let is_turned = arguments.camera.is_some()
            || arguments.yaw_deg.is_some()
            || arguments.pitch_deg.is_some();
        let viewpoint = if is_turned { Viewpoint::default() } else { prepared.camera };
        // Whoever gives an elevation may look up from below.
        let level = on!(&prepared.runner, simulation => ground(&simulation.snapshot()));
        let ground = level.filter(|_| arguments.pitch_deg.is_none());
        Sighting { view, turn, aspect: width / height, viewpoint, ground }
    }

    /// What colours stand for.
    pub fn quantity(&self) -> Option<Quantity> {
        self.view.style.colour_by
    }

    /// Sees to it that all frames of a film have the same scale, which none of them exceeds, unless
    /// the command line says another.
    pub fn choose_scale(&mut self, largest: f64) {
        let style = &mut self.view.style;
        let full = style.colour_by.map(|quantity| quantity.full_scale(largest));
        style.full_scale = style.full_scale.or(full);
    }

    /// Goes as near as all of a box stays in the picture, from wherever it is looked at.
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

    /// The view of a frame that is so far into a film, from 0 to 1.
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

/// What all frames of a film show, which is only known once it was run: the box in which all
/// particles are, and the largest size of what colours stand for.
pub fn seen(
    prepared: &Prepared,
    quantity: Option<Quantity>,
    (steps, interrupt): (&[u64], &Interrupt),
) -> (Option<(glam::Vec3, glam::Vec3)>, f64) {
    let mut runner = prepared.runner.clone();
    let (mut taken, mut all) = (0, None::<(glam::Vec3, glam::Vec3)>);
    let mut largest = 0.0;
    let mut progress = Steps::new(steps.last().copied().unwrap_or(0), "looking where it goes");
    for &step in steps {
        while taken < step {
            // What is wrong is told where it happens again.
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
