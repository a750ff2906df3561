//! What an interaction changes.

use crate::interaction::Interaction;

/// What may differ after an interaction from what was before, each for whoever remembers it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects {
    /// Which springs there are, or their stiffness, damping or rest length.
    pub springs: bool,
    /// Masses, or which particles are pinned.
    pub masses: bool,
    /// Positions or velocities.
    pub state: bool,
    /// The energy of one and the same state.
    pub energy: bool,
    /// The grabs that hold, or how strongly.
    pub grabs: bool,
}

impl Interaction {
    /// Says what the interaction changes, whatever the model.
    ///
    /// A push and new properties of a plane change none of it: they act on the steps to come.
    pub fn effects(&self) -> Effects {
        use Interaction::*;
        let none = Effects::default();
        match self {
            Grab { .. } | Release { .. } => Effects { grabs: true, ..none },
            Pin { .. } => Effects { masses: true, state: true, ..none },
            Unpin { .. } => Effects { masses: true, ..none },
            Cut { .. } | SetStiffness { .. } => Effects { springs: true, energy: true, ..none },
            SetRestLength { .. } | ScaleRestLength { .. } | Freeze { .. } => {
                Effects { springs: true, energy: true, ..none }
            }
            SetDamping { .. } => Effects { springs: true, ..none },
            // A grab is weakened to what a lighter particle can follow.
            SetMass { .. } => Effects { masses: true, energy: true, grabs: true, ..none },
            Impulse { .. } | Spin { .. } => Effects { state: true, ..none },
            SetGravity { .. } => Effects { energy: true, ..none },
            Push { .. } | SetPlane { .. } => none,
        }
    }
}
