//! The live estimate of the error beside the truth, over built-in and generated scenes.

use crate::promise::random_scene;
use msd_core::{Error, Friction, Integrator, Settings};
use msd_scene::{BUILTINS, Loaded};
use msd_study::choice::FRAME;
use msd_study::ladder::ladders;
use msd_study::live_error::{Calibration, calibrate};

/// Frames of a window, as in the window of msd.
const FRAMES: u32 = 30;
/// Times at which windows start in built-in scenes, seconds.
const STARTS: [f64; 3] = [0.0, 1.0, 2.0];
/// The factor within which an estimate counts as right.
pub const BAND: f64 = 3.0;

/// One window.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The scene.
    pub scene: String,
    /// The estimate and the truth.
    pub calibration: Calibration,
}

impl Window {
    /// The estimate as a multiple of the truth; 1 where both are below rounding, as all that is
    /// said of the error then is that it is.
    pub fn ratio(&self) -> f64 {
        let Calibration { estimated, true_error, rounding, .. } = self.calibration;
        if estimated == true_error {
            1.0
        } else {
            estimated.max(rounding) / true_error.max(rounding)
        }
    }

    /// Returns whether the estimate is right within [`BAND`].
    pub fn is_right(&self) -> bool {
        (1.0 / BAND..=BAND).contains(&self.ratio())
    }
}

/// Estimates and truths of every built-in scene and of `generated` others, as far as their name
/// contains `only`; calls `tell` with each window. Scenes that diverge are left out. So are all
/// scenes with contact but `drape`, as their references take long.
pub fn windows(generated: u64, only: &str, tell: &mut dyn FnMut(&Window)) -> Vec<Window> {
    let mut found = Vec::new();
    let builtin = BUILTINS.iter().filter_map(|builtin| msd_scene::open(builtin.name).ok());
    let others = (0..generated).filter_map(|seed| scene(seed).ok());
    let is_brief = |loaded: &Loaded| loaded.scene.shells.is_empty() || loaded.name == "drape";
    let wanted = |loaded: &Loaded| loaded.name.contains(only) && is_brief(loaded);
    for loaded in builtin.chain(others).filter(wanted) {
        for start in STARTS {
            // One at a time: a scene that diverges later counts until then.
            let Ok(calibrations) = calibrate(&loaded, &[start], FRAMES) else { break };
            for calibration in calibrations {
                let window = Window { scene: loaded.name.clone(), calibration };
                tell(&window);
                found.push(window);
            }
        }
    }
    found
}

/// A generated scene, stepped a little finer than it must be; half of those with a plane have the
/// friction of the report of 2014.
fn scene(seed: u64) -> Result<Loaded, Error> {
    let mut scene = random_scene(seed)?;
    for plane in &mut scene.planes {
        if let (Friction::Coulomb(factor), true) = (plane.friction, seed % 2 == 1) {
            plane.friction = Friction::TangentialLoss(factor.min(1.0));
        }
    }
    let method = Integrator::default();
    let ladder = ladders(&scene)?.into_iter().find(|ladder| ladder.integrator == method);
    let fewest = ladder.and_then(|ladder| ladder.fewest).unwrap_or(8);
    let substeps = (fewest + fewest.div_ceil(4)).max(4);
    let settings = Settings { step: FRAME, substeps, ..Settings::default() };
    Ok(Loaded::new(format!("generated {seed}"), scene, settings))
}
