//! The built-in methods by name.

use crate::error::Error;
use crate::scene::{Shell, any_meet};
use alloc::string::ToString;
use alloc::vec::Vec;

/// The built-in methods.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Integrator {
    /// x' = x + h v, v' = v + h a(x, v): the textbook baseline; it adds energy.
    ExplicitEuler,
    /// v' = v + h a(x, v), x' = x + h v': the method that most programs that claim to use Euler
    /// really use.
    SymplecticEuler,
    /// Kick, drift, kick: second order at the price of one evaluation. Dampers are evaluated at a
    /// predicted velocity.
    #[default]
    VelocityVerlet,
    /// The classical Runge-Kutta method of fourth order.
    Rk4,
    /// The pair of orders 5 and 4 of Dormand and Prince: its step follows a tolerance and ends at
    /// every impact.
    DormandPrince,
    /// v' = v + h a(x', v'), x' = x + h v', linearised: any step is stable, and damps.
    BackwardEuler,
    /// v' = v + h a at the middle of the step: any step is stable for linear springs; no mode is
    /// damped.
    ImplicitMidpoint,
    /// Extended position based dynamics: springs as compliant constraints.
    Xpbd,
}

impl Integrator {
    /// Every method.
    pub const ALL: [Integrator; 8] = [
        Integrator::ExplicitEuler,
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
        Integrator::DormandPrince,
        Integrator::BackwardEuler,
        Integrator::ImplicitMidpoint,
        Integrator::Xpbd,
    ];

    /// The methods that evaluate forces only, at a given substep.
    pub const EXPLICIT: [Integrator; 4] = [
        Integrator::ExplicitEuler,
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
    ];

    /// The name a user writes.
    pub fn name(self) -> &'static str {
        match self {
            Integrator::ExplicitEuler => "explicit-euler",
            Integrator::SymplecticEuler => "symplectic-euler",
            Integrator::VelocityVerlet => "velocity-verlet",
            Integrator::Rk4 => "rk4",
            Integrator::DormandPrince => "dormand-prince",
            Integrator::BackwardEuler => "backward-euler",
            Integrator::ImplicitMidpoint => "implicit-midpoint",
            Integrator::Xpbd => "xpbd",
        }
    }

    /// Its purpose, in a line.
    pub fn purpose(self) -> &'static str {
        match self {
            Integrator::ExplicitEuler => "the textbook baseline: it gains energy",
            Integrator::SymplecticEuler => "what most programs call Euler: robust, rough",
            Integrator::VelocityVerlet => "the default: the best for the price nearly always",
            Integrator::Rk4 => "for errors of 1/100 000 of the size and less",
            Integrator::DormandPrince => "as accurate as you ask; chooses its own substeps",
            Integrator::BackwardEuler => "for a few very stiff springs: it calms motion",
            Integrator::ImplicitMidpoint => "for stiff springs that go on swinging",
            Integrator::Xpbd => "cheap, stable without contact: 5 % off or more",
        }
    }

    /// Order of convergence on smooth motion, without contact.
    pub fn order(self) -> u32 {
        match self {
            Integrator::ExplicitEuler
            | Integrator::SymplecticEuler
            | Integrator::BackwardEuler
            | Integrator::Xpbd => 1,
            Integrator::VelocityVerlet | Integrator::ImplicitMidpoint => 2,
            Integrator::Rk4 => 4,
            Integrator::DormandPrince => 5,
        }
    }

    /// Whether it chooses its own substep by a tolerance.
    pub fn is_adaptive(self) -> bool {
        self == Integrator::DormandPrince
    }

    /// Whether it lets shells meet, see [`crate::scene::Shell`].
    pub fn lets_shells_meet(self) -> bool {
        self != Integrator::DormandPrince
    }

    /// Refuses a method that does not let shells meet where there are some.
    pub(crate) fn check_shells(self, shells: &[Shell]) -> Result<(), Error> {
        if self.lets_shells_meet() || !any_meet(shells) {
            return Ok(());
        }
        let able = Integrator::ALL.into_iter().filter(|other| other.lets_shells_meet());
        let able = able.map(Integrator::name).collect::<Vec<_>>().join(", ");
        Err(Error::Unable { method: self.name(), able })
    }

    /// Whether it solves a linear system in each substep.
    pub fn is_implicit(self) -> bool {
        matches!(self, Integrator::BackwardEuler | Integrator::ImplicitMidpoint)
    }
}

impl core::fmt::Display for Integrator {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

impl core::str::FromStr for Integrator {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let known = Integrator::ALL.into_iter().find(|integrator| integrator.name() == name);
        let names: Vec<&str> = Integrator::ALL.map(Integrator::name).to_vec();
        known.ok_or_else(|| Error::UnknownName {
            what: "integrator",
            name: name.to_string(),
            expected: names.join(", "),
        })
    }
}
