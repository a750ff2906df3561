//! The limit of ever finer spacings, by Richardson's extrapolation.

use crate::space::track::Track;
use serde::{Deserialize, Serialize};

/// Result of running a scene at several spacings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The error of space is known.
    Known {
        /// Largest root mean square distance of the points from where they would be without it,
        /// metres.
        error: f64,
        /// Uncertainty of the error, metres: that of the finest spacing, times 1.25 or, of an order
        /// that was assumed, 3 (Roache, 1994).
        band: f64,
        /// The order: the error goes as this power of the spacing.
        order: f64,
        /// Whether the order was observed on three spacings; else it is assumed to be 2.
        is_seen: bool,
        /// Time up to which finer spacings agree better and better, seconds.
        until: f64,
    },
    /// The error is less than the runs can resolve, as they are not exact in time.
    Below {
        /// Upper bound of the error, metres.
        error: f64,
    },
    /// Finer spacings do not come nearer to one another.
    Lost {
        /// The order observed.
        order: f64,
    },
    /// Too few spacings were run.
    Untold,
}

/// The order of a lattice of springs; also the most that is believed of an observation: a higher
/// one is luck.
const ORDER: f64 = 2.0;
/// Below this order no limit can be extrapolated.
const LEAST_ORDER: f64 = 0.5;
/// Safety factors from the difference of two runs to their distance from the limit (Roache, 1994):
/// for an order that was observed, and for one that was assumed.
const SAFETY: [f64; 2] = [1.25, 3.0];
/// The part of the time up to which there must be a limit.
const LEAST_PART: f64 = 0.1;

/// The limit of courses at halved spacings, coarsest first, the samples up to which it holds, and
/// the verdict on the first; `times` are those of the samples, seconds.
pub(crate) fn extrapolate(tracks: &[Track], times: &[f64]) -> (Option<(Track, usize)>, Verdict) {
    let (samples, order, is_seen) = match tracks {
        [coarse, middle, fine, ..] => {
            let firsts = largest_so_far(coarse.distances(middle));
            let seconds = largest_so_far(middle.distances(fine));
            let orders: Vec<f64> =
                firsts.iter().zip(&seconds).map(|(first, second)| order(*first, *second)).collect();
            let last = orders.iter().rposition(|&order| LEAST_ORDER <= order);
            let samples = last.map_or(0, |last| last + 1);
            if (samples as f64) < LEAST_PART * times.len() as f64 {
                let order = orders.last().copied().unwrap_or_default();
                return (None, Verdict::Lost { order });
            }
            (samples, orders[samples - 1], true)
        }
        [_, _] => (times.len(), ORDER, false),
        _ => return (None, Verdict::Untold),
    };
    let [.., before, finest] = tracks else { return (None, Verdict::Untold) };
    let factor = 1.0 / (order.clamp(LEAST_ORDER, ORDER).exp2() - 1.0);
    let beyond = |(fine, before): (&Vec<_>, &Vec<_>)| {
        fine.iter().zip(before).map(|(&fine, &before)| fine + (fine - before) * factor).collect()
    };
    let right: Vec<Vec<_>> = finest.samples.iter().zip(&before.samples).map(beyond).collect();
    let limit = Track { samples: right, seconds: 0.0 };
    let verdict = Verdict::Known {
        error: tracks[0].distance(&limit, samples),
        band: SAFETY[usize::from(!is_seen)] * finest.distance(&limit, samples),
        order,
        is_seen,
        until: times[samples - 1],
    };
    (Some((limit, samples)), verdict)
}

/// The order that two differences show, each between a spacing and its half.
fn order(first: f64, second: f64) -> f64 {
    // Where both are zero the order does not matter.
    if second == 0.0 { ORDER } else { (first / second).log2() }
}

fn largest_so_far(distances: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut largest = 0.0f64;
    distances
        .map(|distance| {
            largest = largest.max(distance);
            largest
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::glam::DVec3;

    /// One point at 1 + c h^p for each spacing, at two samples.
    fn tracks(count: i32, order: f64) -> Vec<Track> {
        let at = |halvings: i32| 1.0 + 0.3 * f64::from(-halvings).exp2().powf(order);
        let track = |halvings| {
            let sample = vec![DVec3::X * at(halvings)];
            Track { samples: vec![sample.clone(), sample], seconds: 0.0 }
        };
        (0..count).map(track).collect()
    }

    #[test]
    fn a_power_of_the_spacing_is_extrapolated_exactly() {
        for power in [0.75, 1.0, 1.5, 2.0] {
            let (limit, verdict) = extrapolate(&tracks(3, power), &[0.5, 1.0]);
            let (limit, samples) = limit.unwrap();
            assert!((limit.samples[1][0].x - 1.0).abs() < 1e-13, "{power}");
            let Verdict::Known { error, order, is_seen, until, .. } = verdict else {
                panic!("{verdict:?}")
            };
            assert!((error - 0.3).abs() < 1e-13 && (order - power).abs() < 1e-12);
            assert!(is_seen && until == 1.0 && samples == 2);
        }
    }

    #[test]
    fn two_spacings_are_taken_for_order_two_and_say_so() {
        let (_, verdict) = extrapolate(&tracks(2, 2.0), &[0.5, 1.0]);
        let Verdict::Known { error, band, is_seen, .. } = verdict else { panic!("{verdict:?}") };
        // The band covers an order of 1 too: the error of the first would be twice the difference.
        assert!((error - 0.3).abs() < 1e-13 && !is_seen);
        assert!((band - 3.0 * 0.3 / 4.0).abs() < 1e-13);
        let (_, verdict) = extrapolate(&tracks(2, 1.0), &[0.5, 1.0]);
        let Verdict::Known { error, band, .. } = verdict else { panic!("{verdict:?}") };
        assert!((error - 0.3).abs() <= band, "{verdict:?}");
    }

    #[test]
    fn where_spacings_part_there_is_no_number_and_before_that_there_is() {
        let (limit, verdict) = extrapolate(&tracks(3, 0.2), &[0.5, 1.0]);
        assert!(limit.is_none() && matches!(verdict, Verdict::Lost { .. }));
        let mut parting = tracks(3, 2.0);
        parting[2].samples[1][0] = DVec3::Y;
        let (limit, verdict) = extrapolate(&parting, &[0.5, 1.0]);
        assert_eq!(limit.unwrap().1, 1);
        let Verdict::Known { error, until, .. } = verdict else { panic!("{verdict:?}") };
        assert!((error - 0.3).abs() < 1e-13 && until == 0.5);
    }
}
