//! The steps of a long command: which are asked for, how far it is, and whether it goes on.

mod interrupt;
mod moments;
mod progress;
mod follower;

pub use follower::Patient;
pub use interrupt::Interrupt;
pub use moments::Moments;
pub use progress::{Bar, SlowNotice, Steps};
