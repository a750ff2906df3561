//! The drift detector: reports energy that the integrator adds, from occasional samples.
//!
//! While no user input does work, kinetic + elastic + gravitational energy and that of user-defined
//! elements can only fall: dampers, drag and contact dissipate it. Energy that moving solids and
//! user-defined elements supply, see [`Energy::supplied`], is subtracted first: a driving force is
//! not a gain of the integrator. A lasting rise is then an error of the method: a step beyond the
//! limit of stability, explicit Euler, a contact that returns more than it took.
//!
//! Symplectic methods let the energy oscillate without ever gaining any. A mode of frequency w
//! oscillates by a fraction h² w² / 4 of its energy, and far more near the limit of stability. So
//! no single value counts, but the *lowest* of a window of samples. The swing of a mode comes back
//! to where it started within half its period, and the modes whose swing is large are those whose
//! period is a few steps. A gain is reported where even the lowest is above the previous energy by
//! more than a tenth of the kinetic and elastic energy, both of that sample and of the time before.
//! It must also be more than rounding can have added. A tenth, because energy that passes from slow
//! modes to fast ones does raise the measured value. It does so by h² w² / 8 on average, 6 % where
//! a mode at a third of its stable step takes all.
//!
//! The method books supplied energy by its own quadrature, so a tenth of that since the reference
//! is allowed as well, and a hundredth of all. The reference follows the energy down, never up, so
//! a gain after long damping shows as well. The net energy that obstacles have added by their own
//! account, see [`Simulation::contacts`], is checked separately, since dampers may dissipate it at
//! once. It adds up from the start, and is compared with the most that was in motion since then.
//!
//! Energy that dampers dissipate as fast as it is added shows in the balance alone:
//! [`Energy::total`], which only an error of the method changes, see [`Witness::imbalance`]. A rise
//! by more than a tenth of the most that was in motion is reported separately, see
//! [`Witness::surplus`]: it says that the balance is wrong. The motion need not be, as at long
//! steps the work of dampers is booked coarsely. A fall by as much, see [`Witness::loss`], is
//! energy that nothing took: a bounce that returns too little, or the damping that a method such as
//! backward Euler has by design. It counts where it lasts for a window of samples, wherever that
//! begins, and so does a lasting rise, see [`Witness::rise`]. Methods under which the energy of a
//! mode does not swing, such as RK4, have no excuse for a change that comes and goes. There four
//! samples are enough.
//!
//! The detector sees no gain before the second window, and before the end of the first such a rise
//! only where it is half of the energy in motion.

use super::Simulation;
use crate::energy::Energy;
use crate::methods::Integrator;
use crate::number::Real;

/// Samples in a window.
const WINDOW: u32 = 16;
/// Samples before which nothing is judged. A body that starts at rest has moved for so few substeps
/// that a method of first order is off by much of its energy.
const EARLY: u32 = 4;
/// Samples for which a change of the balance must last where modes do not swing: an impact is
/// booked within a few.
const BRIEF: usize = 4;
/// The part of the kinetic and elastic energy that may come and go with the modes.
const FRACTION: f64 = 0.1;
/// The part of all supplied energy by which it may be booked wrongly, and come back.
const BOOKED: f64 = 0.01;

/// The part of the largest kinetic and elastic energy so far below which the kinetic energy is that
/// of a body at rest.
const REST: f64 = 1e-6;

/// The part of the largest kinetic and elastic energy so far below which nothing is reported. The
/// remainder of a motion that has died out is the error of the method, and comes and goes.
const NOISE: f64 = 1e-7;

/// Bound of the energy that rounding has added, as a multiple of the root of the sum of squares.
/// Roundings of different substeps are uncorrelated, those of one may be fully correlated.
const ROUNDINGS: f64 = 4.0;

/// Watches the energy of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Witness {
    /// The reference that the energy may not stay above, joules; `None` before the first sample.
    reference: Option<f64>,
    /// Largest kinetic and elastic energy of the window in which it was least, joules.
    scale: f64,
    /// The largest so far, joules.
    most: f64,
    /// The energy that rounding can have added since the reference was found, joules.
    rounding: f64,
    /// The energy that obstacles have added in all, less that dissipated by them, joules.
    fed: f64,
    /// Energy supplied: at the first sample, at the reference, and at the current one, joules.
    supplied: [f64; 3],
    /// The step of the last look.
    seen: u64,
    window: Window,
    balance: Balance,
    gain: f64,
    loss: f64,
    rise: f64,
}

/// The change of the total.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Balance {
    /// The total of the last sample, joules.
    last: Option<f64>,
    /// Since the first sample, joules: at the current one, and at the end of the last window.
    change: f64,
    settled: f64,
    /// The changes of the last samples, in a ring, and their number; at rest the last change in
    /// motion.
    recent: [f64; WINDOW as usize],
    count: usize,
    /// Whether the energy of a mode keeps from swinging, by the method.
    is_steady: bool,
    /// The largest kinetic energy of this window, joules.
    kinetic: f64,
    /// Most energy that rounding can have added since the first sample, joules, if all of it has
    /// one sign.
    rounding: f64,
    /// The sum of the squares of its possible additions in each substep, square joules.
    squares: f64,
}

impl Balance {
    /// Takes a sample after so many substeps; `most` is the most kinetic and elastic energy so far.
    fn take(&mut self, energy: Energy, (rounding, substeps): (f64, f64), most: f64) {
        self.rounding += rounding * substeps;
        self.squares += rounding * rounding * substeps;
        let total = energy.total();
        let change = self.last.map_or(0.0, |last| total - last);
        // A graphics device does not measure what it dissipates: the total is unknown after that.
        self.change += if change.is_nan() { 0.0 } else { change };
        self.last = Some(total);
        let length = self.recent.len();
        let before = self.recent[(self.count + length - 1) % length];
        let is_moving = REST * most < energy.kinetic;
        self.recent[self.count % length] = if is_moving { self.change } else { before };
        self.count += 1;
        self.kinetic = self.kinetic.max(energy.kinetic);
    }

    /// Ends a window. Sums in a body at rest are left out, as there methods book falls within a
    /// substep, which take nothing.
    fn settle(&mut self, most: f64) {
        if self.kinetic <= REST * most {
            self.change = self.settled;
        }
        (self.settled, self.kinetic) = (self.change, 0.0);
    }

    /// The part of the change that rounding may have added, joules.
    fn noise(&self) -> f64 {
        ROUNDINGS * self.squares.sqrt()
    }

    /// The rise and the fall that the last samples have in common, joules; one is not positive.
    fn lasting(&self) -> [f64; 2] {
        let length = self.recent.len();
        if self.count < length {
            return [0.0; 2];
        }
        let last = if self.is_steady { BRIEF } else { length };
        let last = (self.count - last..self.count).map(|sample| self.recent[sample % length]);
        let lowest = last.clone().fold(f64::INFINITY, f64::min);
        let highest = last.fold(f64::NEG_INFINITY, f64::max);
        [lowest, -highest]
    }
}

/// Whether the method keeps or damps the energy of a mode in each substep, without a swing.
fn is_steady<R: Real>(simulation: &Simulation<R>) -> bool {
    use Integrator::{BackwardEuler, DormandPrince, ImplicitMidpoint, Rk4};
    let integrator = simulation.settings().integrator;
    simulation.own_method.is_none()
        && matches!(integrator, Rk4 | DormandPrince | ImplicitMidpoint | BackwardEuler)
}

/// The samples since the last verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Window {
    count: u32,
    lowest: f64,
    highest: f64,
    /// Kinetic and elastic energy of the lowest sample, and the largest, joules.
    moving: f64,
    scale: f64,
}

impl Witness {
    /// Looks at a simulation, after every step or now and then, and returns its energy.
    ///
    /// While work is done that is in no account, see [`Simulation::is_handled`], the detector
    /// starts anew. Changes between two steps, by an interaction or [`Simulation::set_state`], are
    /// for the caller to report: see [`Witness::restart`].
    pub fn watch<R: Real>(&mut self, simulation: &Simulation<R>) -> Energy {
        let (energy, rounding) = simulation.energy_and_rounding();
        if simulation.is_handled() {
            self.restart();
        } else {
            // A substep adds at most one rounding of everything, whatever their signs.
            let substeps = f64::from(simulation.settings().substeps);
            let steps = simulation.steps().saturating_sub(self.seen);
            let steps = if self.reference.is_none() { 0 } else { steps };
            let contacts = simulation.contacts();
            self.fed = contacts.added - contacts.taken;
            self.balance.is_steady = is_steady(simulation);
            self.take(energy, (rounding, substeps * steps as f64));
            self.seen = simulation.steps();
        }
        energy
    }

    /// Takes a sample of the energy; `rounding` is the energy that rounding can have added since
    /// the last one, joules.
    pub fn see(&mut self, energy: Energy, rounding: f64) {
        self.take(energy, (rounding, 1.0));
    }

    /// Takes a sample after so many substeps, in each of which rounding can have added so much,
    /// joules.
    fn take(&mut self, energy: Energy, (rounding, substeps): (f64, f64)) {
        let moving = energy.kinetic + energy.elastic;
        let now = energy.mechanical() - energy.supplied;
        if self.reference.is_none() {
            self.supplied = [energy.supplied; 3];
        }
        self.supplied[2] = energy.supplied;
        let reference = *self.reference.get_or_insert(now);
        let window = &mut self.window;
        let most = Real::max(self.most, Real::max(window.scale, moving));
        self.balance.take(energy, (rounding, substeps), most);
        let driven = self.supplied[2] - self.supplied[0];
        let allowed = FRACTION * (most + driven) + self.balance.noise();
        let told = |change: f64| if allowed < change { change } else { 0.0 };
        [self.rise, self.loss] = self.balance.lasting().map(told);
        if window.count == 0 || now < window.lowest {
            (window.lowest, window.moving) = (now, moving);
        }
        if window.count == 0 {
            window.highest = now;
        }
        window.count += 1;
        self.rounding += rounding * substeps;
        window.highest = Real::max(window.highest, now);
        window.scale = Real::max(window.scale, moving);
        if !now.is_finite() {
            self.gain = f64::INFINITY;
        } else if WINDOW <= window.count && self.gain.is_finite() {
            self.conclude(reference);
        }
    }

    /// Ends a window.
    fn conclude(&mut self, reference: f64) {
        let Window { lowest, highest, moving, scale, .. } = self.window;
        self.most = Real::max(self.most, scale);
        // Follows down: a single large sample does not outlast the next window.
        self.scale = if self.scale == 0.0 { scale } else { Real::min(self.scale, scale) };
        let swinging = Real::max(moving, self.scale);
        let [first, at_reference, supplied] = self.supplied;
        let driven = FRACTION * (supplied - at_reference) + BOOKED * (supplied - first);
        let allowed = FRACTION * swinging + driven + NOISE * self.most + self.rounding;
        let gained = lowest - reference;
        // Dampers may dissipate the energy that contact adds, so that is checked separately.
        let is_fed = self.at_stake() + self.balance.rounding < self.fed;
        let gained = if is_fed { Real::max(gained, self.fed) } else { gained };
        self.gain = if is_fed || allowed < gained { gained } else { 0.0 };
        self.balance.settle(self.most);
        if highest < reference {
            (self.reference, self.rounding) = (Some(highest), 0.0);
            self.supplied[1] = supplied;
        }
        self.window = Window::default();
    }

    /// Starts anew, as after user input has changed the energy.
    pub fn restart(&mut self) {
        *self = Witness::default();
    }

    /// The change of [`Energy::total`] since the first sample or the last restart, joules, less the
    /// sums in a body at rest. It is the error of the method in the balance of the energy.
    pub fn imbalance(&self) -> f64 {
        self.balance.change
    }

    /// The part of the most kinetic and elastic energy so far, and of the supplied energy, that
    /// errors of the balance may reach, joules.
    fn at_stake(&self) -> f64 {
        let [first, _, supplied] = self.supplied;
        FRACTION * (self.most + (supplied - first))
    }

    /// That change where it is a fall that lasts, by more than rounding and a tenth of the most
    /// kinetic and elastic energy so far, joules, as a positive number. It is energy that nothing
    /// took by any account. Else 0.
    pub fn loss(&self) -> f64 {
        self.loss
    }

    /// The same of a lasting rise, joules; else 0.
    pub fn rise(&self) -> f64 {
        self.rise
    }

    /// That change where it is a rise by more than rounding and a tenth of the most kinetic and
    /// elastic energy so far, joules. Before the end of the first window it is a rise by more than
    /// half of it. Else 0.
    pub fn surplus(&self) -> f64 {
        let change = self.balance.change;
        let allowed = match self.most {
            0.0 if self.window.count < EARLY => f64::INFINITY,
            0.0 => 0.5 * self.window.scale,
            _ => self.at_stake(),
        };
        if allowed + self.balance.noise() < change { change } else { 0.0 }
    }

    /// Energy that the integrator has added for good, joules: 0 if none was seen, infinite if the
    /// energy is no longer finite.
    pub fn gain(&self) -> f64 {
        self.gain
    }
}
