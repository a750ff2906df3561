//! Event location within a substep: impacts, releases and the ends of slides.

use super::holds::{Along, Hold, Holds};
use super::stages::Stages;
use super::support::{Bearings, Spot};
use super::tableau::{self, Row, STAGES, TIMES};
use crate::columns::vector;
use crate::number::{Real, Vector};
use crate::obstacles::Obstacle;
use crate::system::Model;
use glam::DVec3;

/// Finds the first event, as a fraction of the substep, up to a fraction of a hop in front of it.
///
/// An impact is where the interpolant of a particle enters an obstacle that does not hold it. It is
/// missed if the particle is out again at the end of the substep and turned more than once within
/// it, which the tolerance makes too shallow to matter. The end of a slide is where the velocity
/// has no part left along its direction at the start.
///
/// [`Holds::gap`] must be the least distance from a plane at the end of the substep or after going
/// straight on from its start. Unless one is negative there is no impact on a plane.
pub(crate) fn first_event<R: Real>(
    model: &Model<R>,
    holds: &Holds<R>,
    stages: &Stages<R>,
) -> Option<f64> {
    let mut first = None;
    let mut held = holds.rows().iter().peekable();
    let (planes, count) = (model.obstacles.planes.len(), model.obstacles.count());
    for (particle, at) in model.slots.places().enumerate() {
        let hold = held.next_if(|hold| hold.particle == particle);
        let from = if holds.gap(at) < R::ZERO { 0 } else { planes };
        let is_idle = from == count && hold.is_none();
        if is_idle || model.inverse_mass_column[at] == R::ZERO {
            continue;
        }
        let path = Path::new(model, stages, at);
        let slack = holds.slack_within(path.start.extent());
        let is_free =
            |index: usize| hold.is_none_or(|hold| !hold.obstacles().contains(&(index as u32)));
        for index in (from..count).filter(|&index| is_free(index)) {
            first = path.impact(model, index, slack, first).or(first);
        }
        if let Some(hold) = hold {
            first = path.end_of_slide(model, hold, first).or(first);
            first = release(hold, first).or(first);
            first = path.edge(model, hold, first).or(first);
        }
    }
    first
}

/// The path of one particle within a substep.
struct Path<'a, R: Real> {
    stages: &'a Stages<R>,
    at: usize,
    start: Spot<R>,
    end: Spot<R>,
}

impl<'a, R: Real> Path<'a, R> {
    fn new(model: &Model<R>, stages: &'a Stages<R>, at: usize) -> Self {
        let radius = model.radii().at(at);
        let spot = |(position, velocity), time| Spot { position, velocity, time, radius };
        let start = spot(stages.start.get(at), stages.time);
        let end = spot(stages.here.get(at), stages.time_at(1.0));
        Path { stages, at, start, end }
    }

    /// Where it is at a fraction of the substep.
    fn spot(&self, part: f64) -> Spot<R> {
        let weights = tableau::dense_slope(part);
        let bends = tableau::bend(weights);
        let (mut kicked, mut moved) = (DVec3::ZERO, DVec3::ZERO);
        for stage in 0..STAGES {
            let slope = vector::<R>(&self.stages.slopes[stage], self.at).to_f64();
            kicked += slope * weights[stage];
            moved += slope * bends[stage];
        }
        let (length, velocity) = (self.stages.length, self.start.velocity.to_f64());
        let moved = (velocity * part + moved * length) * length;
        Spot {
            position: R::Vec3::of(self.start.position.to_f64() + moved),
            velocity: R::Vec3::of(velocity + kicked * length),
            time: self.stages.time_at(part),
            radius: self.start.radius,
        }
    }

    /// The impact on an obstacle, if it is before `first`.
    ///
    /// The distance from a plane is that of the interpolant in one direction; from any other
    /// obstacle it is computed at each place that is tried.
    fn impact(&self, model: &Model<R>, index: usize, slack: R, first: Option<f64>) -> Option<f64> {
        if let Some(plane) = model.obstacles.planes.get(index) {
            let approach = self.approach(plane, slack)?;
            let line = Line::new(self, plane.normal);
            let height = |part: f64| approach.before + line.way(part);
            return approach.impact(height, |part| line.speed(part), first);
        }
        let obstacle = model.obstacles.get(index);
        let approach = self.approach(obstacle, slack)?;
        let height = |part: f64| self.spot(part).gap(obstacle).to_f64();
        let speed = |part: f64| self.spot(part).speed_off(obstacle).to_f64();
        approach.impact(height, speed, first)
    }

    /// Its approach to an obstacle, if it may enter it.
    fn approach<O: Obstacle<R> + ?Sized>(&self, obstacle: &O, slack: R) -> Option<Approach> {
        let (before, after) = (self.start.gap(obstacle), self.end.gap(obstacle));
        // A particle may touch the obstacle, or be in it while another holds it: deeper counts.
        let level = R::min(before, R::ZERO) - slack;
        let enters = after < level;
        let may = || {
            let speed = self.start.speed_off(obstacle);
            let turns = speed < R::ZERO && R::ZERO < self.end.speed_off(obstacle);
            turns && before + speed * R::of(self.stages.length) < level
        };
        (enters || may()).then(|| Approach {
            before: before.to_f64(),
            level: level.to_f64(),
            close: 0.25 * slack.to_f64(),
            enters,
        })
    }

    /// Where a held particle goes over an edge of an obstacle, if it is before `first`.
    fn edge(&self, model: &Model<R>, hold: &Hold<R>, first: Option<f64>) -> Option<f64> {
        let (mut low, mut high) = (0.0, first.unwrap_or(1.0));
        if hold.is_flat(model) || !hold.leaves(model, &self.spot(high)) {
            return None;
        }
        for _ in 0..EDGE_ROUNDS {
            let middle = 0.5 * (low + high);
            if hold.leaves(model, &self.spot(middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(high)
    }

    /// The end of the slide of a particle, if it is before `first`.
    fn end_of_slide(&self, model: &Model<R>, hold: &Hold<R>, first: Option<f64>) -> Option<f64> {
        let (Along::Slides(direction) | Along::Creeps(direction)) = hold.along else { return None };
        // As seen from the surface; planes stand still.
        let sliding = |spot: Spot<R>| {
            let carried = Bearings::new(model, hold.obstacles(), &spot).velocity();
            (spot.velocity - carried).dot(direction)
        };
        let line = Line::new(self, direction);
        let is_flat = hold.is_flat(model);
        let speed = |part: f64| {
            if is_flat { line.speed(part) } else { sliding(self.spot(part)).to_f64() }
        };
        let mut last = first.unwrap_or(1.0);
        if R::ZERO <= sliding(self.end) || 0.0 <= speed(last) {
            return None;
        }
        // From rest it goes forward first: the end is between the last two halvings.
        let mut start = 0.0;
        while speed(0.0) <= 0.0 && speed(start) <= 0.0 {
            start = if start == 0.0 { 0.5 * last } else { 0.5 * start };
            if start < 1e-3 {
                return None;
            }
            last = start + start;
        }
        let close = 1e-9 * speed(start);
        Some(root(speed, (start, last), close))
    }
}

/// The approach of a particle to an obstacle, as distances in metres.
struct Approach {
    /// At the start of the substep.
    before: f64,
    /// Inside from here on.
    level: f64,
    /// Distance to the surface within which an impact is located.
    close: f64,
    /// Whether it is inside at the end; otherwise it turns.
    enters: bool,
}

impl Approach {
    /// The impact, if it is before `first`, from distance and speed at a fraction of the substep.
    fn impact(
        &self,
        height: impl Fn(f64) -> f64,
        speed: impl Fn(f64) -> f64,
        first: Option<f64>,
    ) -> Option<f64> {
        let &Approach { before, level, close, enters } = self;
        let last = first.unwrap_or(1.0);
        let last = if enters { last } else { turn(&speed, last) };
        if level <= height(last) {
            return None;
        }
        // From well outside down to the surface; a particle that starts at it may hop first. A
        // particle that does not hop is taken at the level.
        if close < before {
            return Some(root(height, (0.0, last), close));
        }
        let top = turn(|part| -speed(part), last);
        Some(if close < height(top) {
            root(height, (top, last), close)
        } else {
            root(|part| height(part) - level, (0.0, last), close)
        })
    }
}

/// The release of a held particle, or the end of its sticking, if it is before `first`.
///
/// The margin left is known at the stages; a cubic goes through four of them. The cut is a little
/// late, where the particle is let go: the force that held it too long was next to nothing. Only a
/// glued particle is let go with a jerk; there a first cut is early, so that the next finds the
/// time more precisely.
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
    fn new<R: Real>(path: &Path<'_, R>, direction: R::Vec3) -> Self {
        let slopes = path.stages.slopes.each_ref();
        Line {
            speed: path.start.velocity.dot(direction).to_f64(),
            slopes: slopes.map(|column| vector::<R>(column, path.at).dot(direction).to_f64()),
            length: path.stages.length,
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

/// Where `value`, which is positive at the first end and negative at the second, lies between 0 and
/// `close`. It uses false position with the weight of a retained end halved (Illinois), and
/// bisection should that be slow.
fn root(value: impl Fn(f64) -> f64, (mut low, mut high): (f64, f64), close: f64) -> f64 {
    // Aims at the middle of that range.
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

/// Halvings of a substep in the search for an edge.
const EDGE_ROUNDS: usize = 40;
/// Rounds of a search for a root: the second half alone exhausts the precision.
const MOST_ROUNDS: usize = 120;
