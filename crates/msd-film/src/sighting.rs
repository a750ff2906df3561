//! The view of a picture or a film: from where it looks, at what, and how fast it turns.

use glam::Vec3;
use msd_render::{Camera, Quantity, Style, View, bounds_with_ground, ground};
use msd_run::{Runner, on};
use msd_scene::{Sight, Viewpoint};

/// The size for which lines and the legend are made, pixels; larger pictures enlarge them.
const SIZE: [f32; 2] = [1280.0, 720.0];
/// Directions in which a camera that turns is asked whether all is in the picture.
const DIRECTIONS: u16 = 24;

/// Returns the default colours of a scene: strain in the flat squares, which consist mostly of
/// springs.
pub fn usual_colours(name: &str) -> Option<Quantity> {
    matches!(name, "square" | "square4").then_some(Quantity::Strain)
}

/// Rotates a camera to the viewpoint of a scene.
pub fn turn_to(camera: &mut Camera, Viewpoint { yaw_deg, pitch_deg, .. }: Viewpoint) {
    camera.yaw = yaw_deg.map_or(camera.yaw, radians);
    camera.pitch = pitch_deg.map_or(camera.pitch, radians);
}

/// Moves a camera to the viewpoint of a scene.
pub fn go_to(camera: &mut Camera, Viewpoint { target, distance, .. }: Viewpoint) {
    let vector = |place: [f64; 3]| Vec3::from_array(place.map(|part| part as f32));
    camera.target = target.map_or(camera.target, vector);
    camera.distance = distance.map_or(camera.distance, |distance| distance as f32);
}

fn radians(degrees: f64) -> f32 {
    degrees.to_radians() as f32
}

/// A picture or a film that is to be taken.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The side; by default that of the author of the scene.
    pub camera: Option<Sight>,
    /// Azimuth in place of that of the side, degrees.
    pub yaw_deg: Option<f64>,
    /// Elevation in place of that of the side, degrees.
    pub pitch_deg: Option<f64>,
    /// The parts that are shown; a [`Sighting`] sets its `pixels_per_point`.
    pub style: Style,
    /// Duration of a film, seconds; 0 of a picture.
    pub lasting: f64,
}

/// How a picture or a film looks at a scene.
#[derive(Debug)]
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

impl Sighting {
    /// The view of a shot of a run whose author gives a viewpoint; [`Sighting::frame`] moves it to
    /// what there is to see.
    pub fn new(shot: &Shot, runner: &Runner, author: Viewpoint) -> Self {
        let [width, height] = shot.size.map(|side| side as f32);
        let pixels_per_point = (width / SIZE[0]).min(height / SIZE[1]).max(1.0);
        let style = Style { pixels_per_point, ..shot.style };
        let mut view = View { style, ..View::default() };
        turn_to(&mut view.camera, author);
        if let Some(Sight::Side([yaw, pitch])) = shot.camera {
            (view.camera.yaw, view.camera.pitch) = (radians(yaw), radians(pitch));
        }
        view.camera.yaw = shot.yaw_deg.map_or(view.camera.yaw, radians);
        view.camera.pitch = shot.pitch_deg.map_or(view.camera.pitch, radians);
        let turn = match shot.camera {
            Some(Sight::Orbit(None)) => std::f32::consts::TAU,
            Some(Sight::Orbit(Some(rate))) => radians(rate * shot.lasting),
            _ => 0.0,
        };
        // From another side, the whole scene is framed.
        let is_turned = shot.camera.is_some() || shot.yaw_deg.is_some() || shot.pitch_deg.is_some();
        let viewpoint = if is_turned { Viewpoint::default() } else { author };
        // Whoever gives an elevation may look up from below.
        let level = on!(runner, simulation => ground(&simulation.snapshot()));
        let ground = level.filter(|_| shot.pitch_deg.is_none());
        Sighting { view, turn, aspect: width / height, viewpoint, ground }
    }

    /// Frames the current state of a run.
    pub fn frame(&mut self, runner: &Runner) {
        self.frame_box(on!(runner, simulation => bounds_with_ground(&simulation.snapshot())));
    }

    /// Shows all that the frames of a film see, on one scale of colours that none of them exceeds,
    /// unless the style has another.
    pub fn frame_film(&mut self, seen: Seen) {
        self.frame_box(seen.bounds);
        let style = &mut self.view.style;
        let full = style.colour_by.map(|quantity| quantity.full_scale(seen.largest));
        style.full_scale = style.full_scale.or(full);
    }

    /// Goes as near as all of a box stays in the picture, from wherever it is looked at.
    fn frame_box(&mut self, bounds: Option<(Vec3, Vec3)>) {
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

/// The extent and the largest colour value of all frames of a film.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// The box in which all particles are, metres.
    bounds: Option<(Vec3, Vec3)>,
    /// Largest magnitude of the quantity of the colours, in its unit.
    largest: f64,
}

impl Seen {
    /// Takes in the frame that a run shows now.
    pub fn look(&mut self, runner: &Runner, colour_by: Option<Quantity>) {
        let now = on!(runner, simulation => bounds_with_ground(&simulation.snapshot()));
        self.bounds = match (self.bounds, now) {
            (Some((low, high)), Some((a, b))) => Some((low.min(a), high.max(b))),
            (all, now) => all.or(now),
        };
        if let Some(quantity) = colour_by {
            let now = on!(runner, simulation => quantity.largest(&simulation.snapshot()));
            self.largest = self.largest.max(now);
        }
    }
}

/// Runs ahead on a copy and returns what the frames after these steps show.
///
/// Ends if a step fails, as it will fail again, or if `goes_on` of the steps taken returns false.
pub fn seen(
    mut runner: Runner,
    (steps, colour_by): (&[u64], Option<Quantity>),
    mut goes_on: impl FnMut(u64) -> bool,
) -> Seen {
    let (mut taken, mut all) = (0, Seen::default());
    for &step in steps {
        while taken < step {
            if !goes_on(taken) || runner.step().is_err() {
                return all;
            }
            taken += 1;
        }
        all.look(&runner, colour_by);
    }
    all
}
