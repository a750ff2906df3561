//! When within a substep does a particle hit a plane or end its slide?

use crate::holds::{Along, Hold, Holds, distance};
use crate::real::{Real, Vector};
use crate::stages::Stages;
use crate::system::{Model, PlaneColumn};
use crate::tableau::{self, Row, TIMES};

/// Finds the first event, as a fraction of the substep, up to a fraction of a hop in front of it.
///
/// An impact is where the interpolant of a particle enters a plane that does not hold it. It is
/// missed if the particle is out again at the end of the substep and turned more than once within
/// it, which the tolerance makes too shallow to matter. The end of a slide is where the velocity
/// has no part left along its direction at the start.
pub(crate) fn first_event<R: Real>(
    model: &Model<R>,
    holds: &Holds<R>,
    path: &Stages<R>,
) -> Option<f64> {
    let mut first = None;
    let mut held = holds.rows().iter().peekable();
    for (particle, &inverse_mass) in model.inverse_masses.iter().enumerate() {
        let hold = held.next_if(|hold| hold.particle == particle);
        if inverse_mass == R::ZERO {
            continue;
        }
        let slack = holds.slack_at(path.start.positions[particle]);
        for (index, plane) in model.planes.iter().enumerate() {
            if hold.is_none_or(|hold| !hold.planes().contains(&(index as u32))) {
                first = impact(plane, slack, (particle, path), first).or(first);
            }
        }
        if let Some(hold) = hold {
            first = end_of_slide(hold, path, first).or(first);
            first = release(hold, first).or(first);
        }
    }
    first
}

/// The impact of a particle on a plane, if it is before `first`.
fn impact<R: Real>(
    plane: &PlaneColumn<R>,
    slack: R,
    (particle, path): (usize, &Stages<R>),
    first: Option<f64>,
) -> Option<f64> {
    let before = distance(plane, path.start.positions[particle]);
    let after = distance(plane, path.here.positions[particle]);
    // A particle may touch the plane, or be in one while another holds it: only deeper counts.
    let level = R::min(before, R::ZERO) - slack;
    let enters = after < level;
    let speed = path.start.velocities[particle].dot(plane.normal);
    let turns = speed < R::ZERO && R::ZERO < path.here.velocities[particle].dot(plane.normal);
    let may = turns && before + speed * R::of(path.length) < level;
    if !enters && !may {
        return None;
    }
    let line = Line::new(path, particle, plane.normal);
    let height = |part: f64| before.to_f64() + line.way(part);
    let (level, close) = (level.to_f64(), 0.25 * slack.to_f64());
    let last = first.unwrap_or(1.0);
    let last = if enters { last } else { turn(|part| line.speed(part), last) };
    if level <= height(last) {
        return None;
    }
    // From well outside down to the plane; a particle that starts at it may hop first. One that
    // does not is taken at the level.
    if close < before.to_f64() {
        return Some(root(height, (0.0, last), close));
    }
    let top = turn(|part| -line.speed(part), last);
    Some(if close < height(top) {
        root(height, (top, last), close)
    } else {
        root(|part| height(part) - level, (0.0, last), close)
    })
}

/// The end of the slide of a particle, if it is before `first`.
fn end_of_slide<R: Real>(hold: &Hold<R>, path: &Stages<R>, first: Option<f64>) -> Option<f64> {
    let (Along::Slides(direction) | Along::Creeps(direction)) = hold.along else { return None };
    let particle = hold.particle;
    if R::ZERO <= path.here.velocities[particle].dot(direction) {
        return None;
    }
    let line = Line::new(path, particle, direction);
    let mut last = first.unwrap_or(1.0);
    if 0.0 <= line.speed(last) {
        return None;
    }
    // From rest it goes forward first: the end is between the last two halvings.
    let mut start = 0.0;
    while line.speed <= 0.0 && line.speed(start) <= 0.0 {
        start = if start == 0.0 { 0.5 * last } else { 0.5 * start };
        if start < 1e-3 {
            return None;
        }
        last = start + start;
    }
    let close = 1e-9 * line.speed(start);
    Some(root(|part| line.speed(part), (start, last), close))
}

/// The release of a held particle, or the end of its sticking, if it is before `first`.
///
/// What is left until then is known at the stages; a cubic goes through four of them. The cut is a
/// little late, where the particle is let go: what held it too long was next to nothing. Only what
/// is glued is let go with a jerk; a first cut is early, so that the next finds the time better.
fn release<R: Real>(hold: &Hold<R>, first: Option<f64>) -> Option<f64> {
    let samples = SAMPLES.map(|stage| hold.margins[stage].to_f64());
    let times = SAMPLES.map(|stage| TIMES[stage]);
    let late = samples.iter().position(|&margin| margin < 0.0)?;
    let margin = |part: f64| cubic(times, samples, part);
    let last = times[late].min(first.unwrap_or(1.0));
    if 0.0 <= margin(last) {
        return None;
    }
    let found = if late == 0 { 0.0 } else { root(margin, (0.0, last), 1e-6 * samples[0]) };
    let cut = match hold.along {
        Along::Glued if 0.05 < found => 0.9 * found,
        Along::Glued => found + 1e-5,
        _ => found + 1e-3,
    };
    (cut < first.unwrap_or(1.0)).then_some(cut)
}

/// Stages between which a margin is interpolated: the first, the last and two well apart.
const SAMPLES: [usize; 4] = [0, 2, 3, 6];

/// The cubic through four points, by Lagrange's formula.
fn cubic(times: [f64; 4], values: [f64; 4], at: f64) -> f64 {
    let mut sum = 0.0;
    for (i, value) in values.into_iter().enumerate() {
        let others = times.iter().enumerate().filter(|&(j, _)| j != i);
        sum += others.fold(value, |term, (_, time)| term * (at - time) / (times[i] - time));
    }
    sum
}

/// The interpolant of one particle in one direction.
struct Line {
    speed: f64,
    slopes: Row,
    length: f64,
}

impl Line {
    fn new<R: Real>(path: &Stages<R>, particle: usize, direction: R::Vec3) -> Self {
        let component = |stage: usize| path.slopes[stage][particle].dot(direction).to_f64();
        Line {
            speed: path.start.velocities[particle].dot(direction).to_f64(),
            slopes: core::array::from_fn(component),
            length: path.length,
        }
    }

    /// The way from the start, metres.
    fn way(&self, part: f64) -> f64 {
        let weights = tableau::bend(tableau::dense_slope(part));
        self.length * (part * self.speed + self.length * sum(&weights, &self.slopes))
    }

    /// The speed, metres per second.
    fn speed(&self, part: f64) -> f64 {
        self.speed + self.length * sum(&tableau::dense_slope(part), &self.slopes)
    }
}

fn sum(weights: &Row, slopes: &Row) -> f64 {
    weights.iter().zip(slopes).map(|(weight, slope)| weight * slope).sum()
}

/// Where a speed that is negative at 0 and positive at `last` vanishes, to a part in a thousand.
fn turn(speed: impl Fn(f64) -> f64, last: f64) -> f64 {
    let (mut low, mut high) = (0.0, last);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        if speed(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Where `value`, which is positive at the first end and negative at the second, is from 0 to
/// `close`: false position with the weight of an end that stays halved (Illinois), and bisection
/// should that be slow.
fn root(value: impl Fn(f64) -> f64, (mut low, mut high): (f64, f64), close: f64) -> f64 {
    // Aimed at the middle of what is wanted.
    let value = |part| value(part) - 0.5 * close;
    let (mut above, mut below) = (value(low), value(high));
    if above <= 0.5 * close {
        return low;
    }
    for round in 0..MOST_ROUNDS {
        let fraction = if round < MOST_ROUNDS / 2 { above / (above - below) } else { 0.5 };
        let middle = low + (high - low) * fraction;
        let here = value(middle);
        if here.abs() <= 0.5 * close {
            return middle;
        }
        if 0.0 < here {
            (low, above, below) = (middle, here, 0.5 * below);
        } else {
            (high, above, below) = (middle, 0.5 * above, here);
        }
    }
    low
}

/// Rounds of a search for a root: the second half alone exhausts the precision.
const MOST_ROUNDS: usize = 120;
