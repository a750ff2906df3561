//! The steps of a long command: their choice, progress, and interruption.

mod interrupt;
mod moments;
mod progress;

pub use interrupt::Interrupt;
pub use moments::Moments;
pub use progress::{SlowNotice, Steps, Terminal};
