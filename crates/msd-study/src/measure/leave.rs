//! Leave to go on, asked for again and again by work that takes long.

use msd_core::Error;

/// Asked after every frame or so of long work: may wait, as while the work is paused; `false` ends
/// it.
pub type Leave<'a> = &'a mut dyn FnMut() -> bool;

/// The end of long work without a result.
#[derive(Clone, Debug, PartialEq)]
pub enum Halt {
    /// The core refused something.
    Refused(Error),
    /// Leave to go on was not given.
    Stopped,
    /// The time that it may take was over before there was anything to choose from.
    Late,
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Halt::Refused(error)
    }
}

/// Asks for leave.
pub(crate) fn ask(leave: Leave<'_>) -> Result<(), Halt> {
    if leave() { Ok(()) } else { Err(Halt::Stopped) }
}

/// Does work to its end.
pub(crate) fn unstopped<T>(work: impl FnOnce(Leave<'_>) -> Result<T, Halt>) -> Result<T, Error> {
    work(&mut || true).map_err(|halt| match halt {
        Halt::Refused(error) => error,
        Halt::Stopped | Halt::Late => unreachable!("leave is always given"),
    })
}
