//! The steps of a long command: which are asked for, how far it is, and whether it goes on.

mod interrupt;
mod moments;
mod progress;

pub use interrupt::Interrupt;
pub use moments::Moments;
pub use progress::{SlowNotice, Steps, Terminal};
