//! Checks in a page of a browser, which has no threads: within a frame, and rarer the longer they
//! take.

use super::again::{Again, Difference, Taken};
use std::time::Duration;

/// The rest after a check, in durations of the check.
const REST: u32 = 9;
/// Duration of a check that a frame has room for. The rest after a longer one grows with the square
/// of its duration: one of 40 ms rests for 3.6 s.
const ROOM: Duration = Duration::from_millis(4);

/// Takes a step again where it is begun.
#[derive(Debug)]
pub struct FrameWorker {
    again: Again,
    result: Option<Option<Difference>>,
}

impl FrameWorker {
    pub fn new() -> Self {
        FrameWorker { again: Again::default(), result: None }
    }

    /// Takes a step again.
    pub fn begin(&mut self, taken: Taken) {
        self.result = Some(self.again.take(taken));
    }

    /// The result, if there is a new one.
    pub fn result(&mut self) -> Option<Option<Difference>> {
        self.result.take()
    }

    /// The result of the step that was begun.
    pub fn wait(&mut self) -> Option<Option<Difference>> {
        self.result()
    }

    /// The time from the end of a check to the start of the next, at least.
    pub fn rest_after(check: Duration) -> Duration {
        check.mul_f64(f64::from(REST) * check.div_duration_f64(ROOM).max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use msd_core::{Material, Scene, Settings, Simulation, shape};

    #[test]
    fn a_long_check_takes_a_share_of_the_time_that_falls_with_its_duration() {
        let ms = Duration::from_millis;
        for (check, rest) in [(0, 0), (1, 9), (4, 36), (8, 144), (40, 3600), (400, 360_000)] {
            assert_eq!(FrameWorker::rest_after(ms(check)), ms(rest), "{check} ms");
        }
    }

    #[test]
    fn a_right_step_passes_and_a_wrong_bit_is_found() {
        let cloth = shape::cloth([4, 4], 0.1, Material::default()).expect("a cloth");
        let scene = Scene::of("cloth", cloth);
        let mut simulation = Simulation::<f32>::new(&scene, Settings::default()).expect("a scene");
        let mut worker = FrameWorker::new();
        let taken = |simulation: &mut Simulation<f32>, other: bool| {
            let (before, steps) = (simulation.state(), simulation.steps());
            let other = other.then(|| Box::new(simulation.clone()));
            simulation.step().expect("a step");
            Taken { simulation: other, before, steps, after: simulation.state() }
        };
        worker.begin(taken(&mut simulation, true));
        assert!(matches!(worker.result(), Some(None)));
        assert!(worker.result().is_none());
        let mut wrong = taken(&mut simulation, false);
        let y = &mut wrong.after.positions[7].y;
        *y = f32::from_bits(y.to_bits() ^ 1);
        worker.begin(wrong);
        let difference = worker.wait().flatten().expect("a difference");
        assert_eq!((difference.particle, difference.steps), (7, 1));
    }
}
