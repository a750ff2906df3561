//! Methods of time integration.
//!
//! | method | order | stable for an undamped mode of frequency w | file |
//! |---|---|---|---|
//! | explicit Euler | 1 | never | `explicit.rs` |
//! | symplectic Euler | 1 | h w ≤ 2 | `explicit.rs` |
//! | velocity Verlet | 2 | h w ≤ 2 | `explicit.rs` |
//! | RK4 | 4 | h w ≤ 2 √2 | `explicit.rs` |
//! | Dormand-Prince | 5 | the step follows a tolerance | `dormand_prince/` |
//! | backward Euler | 1 | always | `implicit/` |
//! | implicit midpoint | 2 | always, for linear springs | `implicit/` |
//! | XPBD | 1 | always | `xpbd.rs` |
//!
//! A method is a function of a [`StepContext`]; the built-in ones are the variants of
//! [`Integrator`], and a caller may bring another. A step starts from positions and velocities
//! alone, whatever the method: that makes state files, stepping back and replay exact.

mod integrator;
mod settings;
mod context;
mod explicit;
pub(crate) mod xpbd;
pub(crate) mod implicit;
pub(crate) mod dormand_prince;

pub(crate) use context::{Done, Failure, Scratch};
pub use context::{Parts, StepContext};
pub use dormand_prince::Work;
pub use implicit::Solved;
pub use integrator::Integrator;
pub use settings::Settings;

use crate::number::{Real, of_type};
use crate::stability::Region;
use alloc::sync::Arc;
use core::fmt::Debug;

/// A way to advance a system by a step.
///
/// ```
/// use msd_core::Real;
/// use msd_core::methods::{Method, Parts, StepContext};
/// use msd_core::stability::Region;
///
/// /// Symplectic Euler once more: v' = v + h a(x, v), x' = x + h v'.
/// #[derive(Debug)]
/// struct KickDrift;
///
/// impl<R: Real> Method<R> for KickDrift {
///     fn region(&self) -> Region {
///         Region::SymplecticEuler
///     }
///     fn advance(&self, step: &mut StepContext<'_, R>) {
///         let h = step.substep();
///         for _ in 0..step.substeps() {
///             let power = step.set_forces(step.time());
///             let Parts { positions, velocities, forces, inverse_masses, .. } = step.parts();
///             for i in 0..positions.len() {
///                 velocities[i] += forces[i] * inverse_masses[i] * h;
///                 positions[i] += velocities[i] * h;
///             }
///             step.finish_substep(power * h.to_f64());
///         }
///     }
/// }
/// ```
pub trait Method<R: Real>: Debug + Send + Sync {
    /// Its stability region, for the prediction of the stable step.
    fn region(&self) -> Region;

    /// The number of work columns it needs beside the forces. Default 0.
    fn columns(&self) -> usize {
        0
    }

    /// Advances the state by one step, contact included.
    fn advance(&self, step: &mut StepContext<'_, R>);
}

impl<R: Real> Method<R> for Integrator {
    fn region(&self) -> Region {
        match self {
            Integrator::ExplicitEuler => Region::EXPLICIT_EULER,
            Integrator::SymplecticEuler => Region::SymplecticEuler,
            Integrator::VelocityVerlet => Region::VelocityVerlet,
            Integrator::Rk4 => Region::RK4,
            Integrator::DormandPrince => Region::DORMAND_PRINCE,
            Integrator::BackwardEuler | Integrator::ImplicitMidpoint | Integrator::Xpbd => {
                Region::Everything
            }
        }
    }

    fn columns(&self) -> usize {
        match self {
            Integrator::VelocityVerlet => explicit::VERLET_COLUMNS,
            Integrator::Rk4 => explicit::RK4_COLUMNS,
            _ => 0,
        }
    }

    fn advance(&self, step: &mut StepContext<'_, R>) {
        match self {
            Integrator::ExplicitEuler => explicit::explicit_euler(step),
            Integrator::SymplecticEuler => explicit::symplectic_euler(step),
            Integrator::VelocityVerlet => explicit::velocity_verlet(step),
            Integrator::Rk4 => explicit::rk4(step),
            Integrator::DormandPrince => dormand_prince::advance(step),
            Integrator::BackwardEuler => implicit::backward_euler(step),
            Integrator::ImplicitMidpoint => implicit::midpoint(step),
            Integrator::Xpbd => xpbd::advance(step),
        }
    }
}

impl From<Integrator> for Region {
    fn from(integrator: Integrator) -> Self {
        Method::<f64>::region(&integrator)
    }
}

/// A user-defined method, for either precision.
#[derive(Clone, Debug)]
pub(crate) struct OwnMethod {
    single: Arc<dyn Method<f32>>,
    double: Arc<dyn Method<f64>>,
}

impl OwnMethod {
    pub(crate) fn new<M: Method<f32> + Method<f64> + 'static>(method: M) -> Self {
        let method = Arc::new(method);
        OwnMethod { single: method.clone(), double: method }
    }

    pub(crate) fn of<R: Real>(&self) -> &dyn Method<R> {
        &**of_type::<Arc<dyn Method<R>>>(&self.single, &self.double)
    }
}
