//! Which methods are there? Names, orders and what kind of machinery each needs.
//!
//! | method | order | stable for an undamped mode of frequency w | file |
//! |---|---|---|---|
//! | explicit Euler | 1 | never | [`crate::explicit`] |
//! | symplectic Euler | 1 | h w ≤ 2 | [`crate::explicit`] |
//! | velocity Verlet | 2 | h w ≤ 2 | [`crate::explicit`] |
//! | RK4 | 4 | h w ≤ 2 √2 | [`crate::explicit`] |
//! | Dormand-Prince | 5 | the step follows a tolerance | [`crate::dormand_prince`] |
//! | backward Euler | 1 | always | [`crate::implicit`] |
//! | implicit midpoint | 2 | always, for linear springs | [`crate::implicit`] |
//! | XPBD | 1 | always | [`crate::xpbd`] |

use crate::error::Error;
use alloc::string::ToString;
use alloc::vec::Vec;

/// The methods.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Integrator {
    /// x' = x + h v, v' = v + h a(x, v): the textbook baseline; it adds energy.
    ExplicitEuler,
    /// v' = v + h a(x, v), x' = x + h v': what most programs called Euler really are.
    SymplecticEuler,
    /// Kick, drift, kick: second order at the price of one evaluation. Dampers are evaluated at a
    /// predicted velocity, see [`crate::explicit::advance`].
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

/// The methods by the machinery they need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Evaluate forces only, at a given substep.
    Explicit(Explicit),
    /// Choose their own substep by a tolerance.
    Adaptive,
    /// Solve a linear system per substep.
    Implicit(Implicit),
    /// Project springs one by one.
    Projected,
}

/// The methods of [`crate::explicit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Explicit {
    /// See [`Integrator::ExplicitEuler`].
    Euler,
    /// See [`Integrator::SymplecticEuler`].
    SymplecticEuler,
    /// See [`Integrator::VelocityVerlet`].
    VelocityVerlet,
    /// See [`Integrator::Rk4`].
    Rk4,
}

/// The methods of [`crate::implicit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Implicit {
    /// See [`Integrator::BackwardEuler`].
    BackwardEuler,
    /// See [`Integrator::ImplicitMidpoint`].
    Midpoint,
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

    /// The machinery it needs.
    pub fn family(self) -> Family {
        match self {
            Integrator::ExplicitEuler => Family::Explicit(Explicit::Euler),
            Integrator::SymplecticEuler => Family::Explicit(Explicit::SymplecticEuler),
            Integrator::VelocityVerlet => Family::Explicit(Explicit::VelocityVerlet),
            Integrator::Rk4 => Family::Explicit(Explicit::Rk4),
            Integrator::DormandPrince => Family::Adaptive,
            Integrator::BackwardEuler => Family::Implicit(Implicit::BackwardEuler),
            Integrator::ImplicitMidpoint => Family::Implicit(Implicit::Midpoint),
            Integrator::Xpbd => Family::Projected,
        }
    }

    /// Whether it chooses its own substep by a tolerance.
    pub fn is_adaptive(self) -> bool {
        self.family() == Family::Adaptive
    }

    /// Whether it solves a linear system per substep.
    pub fn is_implicit(self) -> bool {
        matches!(self.family(), Family::Implicit(_))
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
