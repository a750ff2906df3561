//! Cost and effect of each part of the model, which is switched off one at a time: the change of
//! the answer, and the time that it saves.

use crate::measure::clock::CpuClock;
use crate::measure::errors::rms_distance;
use crate::measure::reference::size_of;
use crate::measure::trial::{state, time_run};
use crate::monitor::{Halt, Monitor, Progress, unless_refused};
use crate::quantity::rounded;
use msd_core::{Error, Scene, Settings, Spring, State};
use msd_run::Runner;
use msd_scene::parts::Part;
use msd_scene::{Loaded, Precision};
use serde::{Deserialize, Serialize};

/// Effect and cost of a part of the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TermRow {
    /// The part.
    pub term: String,
    /// Distance of the run without it from the whole run at the end, root mean square over the
    /// particles, metres; none if that run diverged.
    pub change: Option<f64>,
    /// The largest such distance after any step, metres.
    pub worst: Option<f64>,
    /// `change` as a fraction of the size of the scene.
    pub relative: Option<f64>,
    /// Cost of the part, percent of the time of the whole run; negative where the run without it
    /// takes longer; none if it diverged.
    pub cost_percent: Option<f64>,
    /// All of that in plain words.
    pub words: String,
}

/// Time of the processor after which costs are not measured again, seconds.
const PATIENCE: f64 = 2.0;
/// The fewest and the most runs of which the fastest counts.
const ROUNDS: (usize, usize) = (3, 25);
/// A scene with a part switched off.
struct Variant {
    term: &'static str,
    /// The change, as the subject of a sentence.
    act: String,
    scene: Scene,
    precision: Precision,
}

/// Switches off every part that a scene has, one at a time, and compares the runs with that of the
/// whole scene, over `duration` seconds, at the scene's own settings.
///
/// The parts are damping; gravity; face and space diagonals of regular bodies; bending springs of
/// shells, which are known by the triangles that they bridge; drag; contact; values of each spring
/// against their mean; and the precision against the other one. Costs are the best of several runs
/// that take turns, so that a busy machine hits them all.
///
/// # Errors
/// A scene that a simulation refuses; a scene that diverges unchanged; the error of
/// [`Monitor::proceed`].
pub fn terms(
    loaded: &Loaded,
    duration: f64,
    monitor: &mut dyn Monitor,
) -> Result<Vec<TermRow>, Halt> {
    monitor.report(Progress::of("switching off one part at a time"));
    // Automatic substeps are those of the start, for all of the runs.
    let settings = Runner::open(loaded)?.settings();
    let steps = (duration / settings.step).round().max(1.0) as u64;
    let size = size_of(&loaded.scene)?;
    let (act, precision) = (String::new(), loaded.precision);
    let whole = Variant { term: "", act, scene: loaded.scene.clone(), precision };
    let mut right = Vec::new();
    whole.run(settings, steps, monitor, |state| right.push(state))?;
    let variants = variants(loaded);
    let mut changes = Vec::new();
    for variant in &variants {
        let (mut change, mut rows) = ([0.0f64; 2], right.iter());
        let ran = variant.run(settings, steps, monitor, |state| {
            change[0] = rows.next().map_or(0.0, |right| rms_distance(&state, right));
            change[1] = change[1].max(change[0]);
        });
        changes.push(match ran {
            Ok(()) => Ok(change),
            Err(Halt::Refused(error)) => Err(error),
            Err(halt) => return Err(halt),
        });
    }
    let mut all = vec![whole];
    all.extend(variants);
    let seconds = race(&all, settings, steps, monitor)?;
    let rows = all[1..].iter().zip(&changes).zip(&seconds[1..]);
    Ok(rows
        .map(|((variant, change), &time)| row(variant, change, (time, seconds[0]), size))
        .collect())
}

/// The best time of the processor that each variant takes for its steps, seconds per simulated
/// second.
fn race(
    variants: &[Variant],
    settings: Settings,
    steps: u64,
    monitor: &mut dyn Monitor,
) -> Result<Vec<f64>, Halt> {
    let mut best = vec![f64::INFINITY; variants.len()];
    let clock = CpuClock::start();
    for round in 0..ROUNDS.1 {
        if ROUNDS.0 <= round && PATIENCE < clock.seconds() {
            break;
        }
        for (best, variant) in best.iter_mut().zip(variants) {
            let runner = Runner::new(&variant.scene, settings, variant.precision);
            let time = runner.map_err(Halt::from).and_then(|run| time_run(run, steps, monitor));
            *best = best.min(unless_refused(time)?.unwrap_or(f64::INFINITY));
        }
    }
    Ok(best)
}

impl Variant {
    /// Runs `steps` steps, showing the state after each.
    fn run(
        &self,
        settings: Settings,
        steps: u64,
        monitor: &mut dyn Monitor,
        mut see: impl FnMut(State<f64>),
    ) -> Result<(), Halt> {
        let mut runner = Runner::new(&self.scene, settings, self.precision)?;
        for _ in 0..steps {
            monitor.proceed()?;
            runner.step()?;
            see(state(&runner));
        }
        Ok(())
    }
}

fn row(
    Variant { term, act, .. }: &Variant,
    change: &Result<[f64; 2], Error>,
    (time, whole): (f64, f64),
    size: f64,
) -> TermRow {
    let term = (*term).to_owned();
    let [end, worst] = match change {
        Ok(change) => *change,
        Err(error) => {
            let words = format!("{act} makes the run fail: {error}");
            let (change, worst, relative, cost_percent) = (None, None, None, None);
            return TermRow { term, change, worst, relative, cost_percent, words };
        }
    };
    let cost = 100.0 * (1.0 - time / whole);
    // Costs of a run repeat within one or two percent.
    let saving = match cost {
        cost if cost.abs() < 2.0 => "saves no time that can be measured".into(),
        cost if cost < 0.0 => format!("takes {:.0} % more time", -cost),
        cost => format!("saves {cost:.0} % of the time"),
    };
    let change = match 100.0 * end / size {
        0.0 => "does not change the answer".into(),
        percent if percent < 0.01 => format!("changes the answer by {percent:.0e} % of its size"),
        percent => format!("changes the answer by {} % of its size", rounded(percent, 2)),
    };
    TermRow {
        term,
        change: Some(end),
        worst: Some(worst),
        relative: Some(end / size),
        cost_percent: Some(cost),
        words: format!("{act} {change} and {saving}"),
    }
}

/// The scene without each part that it has.
fn variants(loaded: &Loaded) -> Vec<Variant> {
    let (scene, precision) = (&loaded.scene, loaded.precision);
    let off = |part: Part| {
        let (term, act) = (part.name(), format!("switching off {}", part.name()));
        part.without(scene).map(|scene| Variant { term, act, scene, precision })
    };
    let mut found: Vec<Variant> = Part::ALL.into_iter().filter_map(off).collect();
    let uniform = uniform(scene);
    if uniform != *scene {
        let (term, act) = ("values of each spring", "giving all springs the mean stiffness");
        found.push(Variant { term, act: format!("{act} and damping"), scene: uniform, precision });
    }
    let (term, other, act) = match precision {
        Precision::F64 => ("double precision", Precision::F32, "running in single precision"),
        Precision::F32 => ("single precision", Precision::F64, "running in double precision"),
    };
    found.push(Variant { term, act: act.into(), scene: scene.clone(), precision: other });
    found
}

/// Every spring with the mean stiffness and damping.
fn uniform(scene: &Scene) -> Scene {
    let mean = |of: fn(&Spring) -> f64| {
        let first = scene.springs.first().map_or(0.0, of);
        // A mean of equal values that is not that value would be a difference that is none.
        if scene.springs.iter().all(|spring| of(spring) == first) {
            return first;
        }
        scene.springs.iter().map(of).sum::<f64>() / scene.springs.len() as f64
    };
    let (stiffness, damping) = (mean(|spring| spring.stiffness), mean(|spring| spring.damping));
    let mut alike = scene.clone();
    for spring in &mut alike.springs {
        (spring.stiffness, spring.damping) = (stiffness, damping);
    }
    alike
}
