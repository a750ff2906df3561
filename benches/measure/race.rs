//! Races: timings of rivals in turn, on a machine whose speed changes from second to second.
//!
//! All run in short batches, so that each has its share of good and of bad seconds.

use std::time::Instant;

/// Length of a batch unless a step takes longer, seconds.
const BATCH: f64 = 0.004;
/// The fewest rounds.
const ROUNDS: usize = 7;

/// Something that takes steps.
pub struct Rival<'a> {
    /// Its name in the tables.
    pub name: String,
    /// Spring updates of a step, or how often what is timed happens in one.
    pub updates: f64,
    /// Takes a number of steps.
    pub run: Box<dyn FnMut(u64) + 'a>,
}

/// How fast something is, updates per second.
#[derive(Clone, Debug)]
pub struct Speed {
    pub name: String,
    pub best: f64,
    pub median: f64,
}

/// How patient a race is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Patience {
    /// A number of seconds for each.
    Seconds(f64),
    /// A step of each, to see that it runs.
    Once,
}

/// Lets rivals run in turn.
pub fn race(mut rivals: Vec<Rival<'_>>, patience: Patience) -> Vec<Speed> {
    let times = times(&mut rivals, patience);
    let speed = |(rival, mut times): (Rival<'_>, Vec<f64>)| {
        times.sort_by(f64::total_cmp);
        let [best, median] = [0, times.len() / 2].map(|at| rival.updates / times[at]);
        Speed { name: rival.name, best, median }
    };
    rivals.into_iter().zip(times).map(speed).collect()
}

/// Lets rivals run in turn; returns the time of a step of each in each round, seconds.
pub fn times(rivals: &mut [Rival<'_>], patience: Patience) -> Vec<Vec<f64>> {
    let time = |rival: &mut Rival<'_>, steps: u64| {
        let start = Instant::now();
        (rival.run)(steps);
        start.elapsed().as_secs_f64() / steps as f64
    };
    let mut times: Vec<Vec<f64>> = rivals.iter_mut().map(|rival| vec![time(rival, 1)]).collect();
    if let Patience::Seconds(seconds) = patience {
        // The first step compiled a plan and touched its memory for the first time.
        let warm = rivals.iter_mut().map(|rival| time(rival, 1).min(time(rival, 1)));
        let steps: Vec<u64> = warm.map(|fastest| (BATCH / fastest) as u64 + 1).collect();
        times.iter_mut().for_each(Vec::clear);
        let (start, patience) = (Instant::now(), seconds * rivals.len() as f64);
        while times[0].len() < ROUNDS || start.elapsed().as_secs_f64() < patience {
            for ((rival, times), &steps) in rivals.iter_mut().zip(&mut times).zip(&steps) {
                times.push(time(rival, steps));
            }
        }
    }
    times
}
