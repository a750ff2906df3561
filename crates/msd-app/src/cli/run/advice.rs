//! Advice for a run with too long a step: options with which a copy of it does not diverge.

use crate::cli::steps::SlowNotice;
use msd_run::Runner;
use msd_run::rescue::{Offer, Origin, Remedy, Rescue};
use web_time::Instant;

/// Wall-clock limit of the search for options, seconds.
const BUDGET: f64 = 3.0;

/// Returns options in words: each was tried from `start` for `lasting` simulated seconds, or is
/// marked as only predicted. `frame` is the time that `--substeps` divides, and `stable` the
/// predicted longest stable substep, seconds.
pub fn advise(start: &Runner, frame: f64, stable: f64, lasting: f64) -> String {
    let _notice = SlowNotice::new("searching for a stable step".to_owned());
    let clock = Instant::now();
    let mut rescue = Rescue::new(start.settings(), stable, (&[Origin::Start], u32::MAX), lasting);
    rescue.work(&|_| Some(start.clone()), BUDGET, &|| clock.elapsed().as_secs_f64());
    let is_done = rescue.is_done();
    rescue.end();
    let frames = frame / start.settings().step;
    let substeps = start.settings().substeps;
    let options = rescue.offers().iter().filter_map(|offer| option(offer, substeps, frames));
    let options: Vec<String> = options.collect();
    if !options.is_empty() {
        return format!("try {}", options.join(" or "));
    }
    let all = "no method or number of substeps tried is stable";
    if is_done { all } else { "the search for a stable setting timed out" }.to_owned()
}

/// Formats advice as the end of a sentence; empty if there is none, or if it was given before.
pub fn appended(advice: Option<&str>) -> String {
    let advice = advice.filter(|advice| !advice.is_empty());
    advice.map_or(String::new(), |advice| format!("; {advice}"))
}

/// Formats an offer as options of the command line; `now` is the current number of substeps, and
/// `frames` the number of frames per step.
fn option(offer: &Offer, now: u32, frames: f64) -> Option<String> {
    // Slightly less: rounding may lift the quotient of equal times above one.
    let substeps = |count: u32| format!("--substeps {}", (f64::from(count) * frames - 1e-6).ceil());
    let option = match offer.remedy {
        Remedy::Substeps(count) => substeps(count),
        Remedy::Tolerance(tolerance) => format!("--tolerance {tolerance}"),
        Remedy::Method(method, count) if count == now => format!("--integrator {method}"),
        Remedy::Method(method, count) => format!("--integrator {method} {}", substeps(count)),
        Remedy::Back | Remedy::SceneValues => return None,
    };
    Some(if offer.is_tried { option } else { option + " (predicted)" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::Integrator;

    #[test]
    fn substeps_are_those_of_a_frame() {
        let offer =
            |remedy, is_tried| Offer { remedy, origin: Origin::Start, is_tried, cost: None };
        let text = |remedy, frames| option(&offer(remedy, true), 1, frames);
        assert_eq!(text(Remedy::Substeps(3), 1.0).as_deref(), Some("--substeps 3"));
        // Steps of a fifth of a frame in three substeps each.
        assert_eq!(text(Remedy::Substeps(3), 5.0).as_deref(), Some("--substeps 15"));
        let verlet = |substeps| Remedy::Method(Integrator::VelocityVerlet, substeps);
        assert_eq!(text(verlet(1), 1.0).as_deref(), Some("--integrator velocity-verlet"));
        let both = "--integrator velocity-verlet --substeps 2";
        assert_eq!(text(verlet(2), 1.0).as_deref(), Some(both));
        let predicted = option(&offer(Remedy::Tolerance(1e-4), false), 1, 1.0);
        assert_eq!(predicted.as_deref(), Some("--tolerance 0.0001 (predicted)"));
        assert_eq!(text(Remedy::SceneValues, 1.0), None);
    }
}
