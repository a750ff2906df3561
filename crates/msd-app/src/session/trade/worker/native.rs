//! A thread of low priority that takes a bounded share of one core.

use super::{BROKEN, LATE, Report, Task};
use crate::background::lower_priority;
use msd_study::choice::Choice;
use msd_study::conduct::Progress;
use msd_study::leave::Halt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What a worker takes of the machine, in words.
pub const MANNERS: &str =
    "It takes at most half of one core, at low priority; resting it takes nothing";
/// The largest share of one core that a worker takes.
const SHARE: f64 = 0.5;
/// How long it works before it rests, seconds: less than a frame, so that none waits for long.
const SLICE: f64 = 4e-3;

/// What both threads see.
#[derive(Debug)]
struct Desk<T> {
    report: Report<T>,
    paused: bool,
    /// Whether nobody wants the result any more.
    ended: bool,
    wish: Option<Choice>,
}

#[derive(Debug)]
struct Shared<T> {
    desk: Mutex<Desk<T>>,
    woken: Condvar,
}

impl<T> Shared<T> {
    fn desk(&self) -> MutexGuard<'_, Desk<T>> {
        // A thread that panicked left whole values.
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Desk<T>)) {
        change(&mut self.desk());
        self.woken.notify_all();
    }
}

/// The window's end: reads what was found. When it is dropped the work ends.
#[derive(Debug)]
pub(crate) struct Worker<T>(Arc<Shared<T>>);

impl<T: Send + Sync + 'static> Worker<T> {
    /// Begins to work.
    pub(crate) fn start(mut work: impl Task<Found = T>) -> Self {
        let report = Report::default();
        let desk = Mutex::new(Desk { report, paused: false, ended: false, wish: None });
        let shared = Arc::new(Shared { desk, woken: Condvar::new() });
        let mut job = Job { shared: shared.clone(), since: Instant::now() };
        let spawned = spawn(move || {
            // A panic would end the whole program.
            let to_the_end = AssertUnwindSafe(|| {
                while work.advance(&mut job)? {}
                Ok(())
            });
            let failure = match catch_unwind(to_the_end) {
                Ok(Err(Halt::Refused(error))) => Some(error.to_string()),
                Ok(Err(Halt::Late)) => Some(LATE.to_owned()),
                Ok(Ok(()) | Err(Halt::Stopped)) => None,
                Err(_) => Some(BROKEN.to_owned()),
            };
            job.shared.change(|desk| (desk.report.idle, desk.report.failure) = (true, failure));
        });
        if let Err(error) = spawned {
            shared.change(|desk| (desk.report.idle, desk.report.failure) = (true, Some(error)));
        }
        Worker(shared)
    }

    /// What there is to show.
    pub(crate) fn report(&self) -> Report<T> {
        self.0.desk().report.clone()
    }

    /// Rests or goes on.
    pub(crate) fn set_paused(&self, paused: bool) {
        self.0.change(|desk| desk.paused = paused);
    }

    /// Asks for a choice to be tried next.
    pub(crate) fn wish(&self, choice: Choice) {
        self.0.change(|desk| desk.wish = Some(choice));
    }
}

impl<T> Drop for Worker<T> {
    fn drop(&mut self) {
        self.0.change(|desk| desk.ended = true);
    }
}

/// The thread's end.
#[derive(Debug)]
pub(crate) struct Job<T> {
    shared: Arc<Shared<T>>,
    /// When the present slice of work began.
    since: Instant,
}

impl<T> Job<T> {
    /// Rests when it is time to, waits while paused; whether the result is still wanted.
    pub(crate) fn may_go_on(&mut self) -> bool {
        let worked = self.since.elapsed().as_secs_f64();
        let desk = self.shared.desk();
        if worked < SLICE && !desk.paused {
            return !desk.ended;
        }
        let rest = Duration::from_secs_f64(worked * (1.0 / SHARE - 1.0));
        let wanted = |desk: &mut Desk<T>| !desk.ended;
        let rested = self.shared.woken.wait_timeout_while(desk, rest, wanted);
        let (desk, _) = rested.unwrap_or_else(PoisonError::into_inner);
        let waits = |desk: &mut Desk<T>| desk.paused && !desk.ended;
        let desk = self.shared.woken.wait_while(desk, waits);
        let is_wanted = !desk.unwrap_or_else(PoisonError::into_inner).ended;
        self.since = Instant::now();
        is_wanted
    }

    /// Shows what was found.
    pub(crate) fn show(&self, found: T) {
        self.shared.change(|desk| desk.report.found = Some(Arc::new(found)));
    }

    /// Tells how far it is.
    pub(super) fn tell(&self, progress: Progress) {
        self.shared.change(|desk| desk.report.progress = Some(progress));
    }

    /// A choice to be tried next; one that has nothing else to do, as it is `idle`, waits for it,
    /// until the result is not wanted any more.
    pub(crate) fn wished(&mut self, idle: bool) -> Option<Choice> {
        let mut desk = self.shared.desk();
        desk.report.idle = idle && desk.wish.is_none();
        if idle {
            let waits = |desk: &mut Desk<T>| desk.wish.is_none() && !desk.ended;
            let woken = self.shared.woken.wait_while(desk, waits);
            desk = woken.unwrap_or_else(PoisonError::into_inner);
            self.since = Instant::now();
        }
        desk.report.idle = false;
        desk.wish.take().filter(|_| !desk.ended)
    }
}

/// Runs work on a thread of its own, which is all that its steps may use: costs are of one core.
fn spawn(work: impl FnOnce() + Send + 'static) -> Result<(), String> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .thread_name(|_| "study".into())
        .start_handler(|_| lower_priority());
    // The thread outlives the pool until the work is done.
    pool.build().map(|pool| pool.spawn(work)).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait_for<T: Send + Sync + 'static>(worker: &Worker<T>, what: fn(&Report<T>) -> bool) {
        // Not a measurement: only an end for a test that fails.
        let begin = Instant::now();
        while !what(&worker.report()) {
            assert!(begin.elapsed() < Duration::from_secs(60), "nothing came");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Work of one piece.
    struct Piece<T, F>(F, std::marker::PhantomData<fn(T)>);

    impl<T: 'static, F> Task for Piece<T, F>
    where
        F: FnMut(&mut Job<T>) -> Result<(), Halt> + Send + 'static,
    {
        type Found = T;
        const NAME: &'static str = "piece";
        const IN_PIECES: bool = false;

        fn advance(&mut self, job: &mut Job<T>) -> Result<bool, Halt> {
            (self.0)(job).map(|()| false)
        }
    }

    fn start<T: Send + Sync + 'static>(
        work: impl FnMut(&mut Job<T>) -> Result<(), Halt> + Send + 'static,
    ) -> Worker<T> {
        Worker::start(Piece(work, std::marker::PhantomData))
    }

    #[test]
    fn a_paused_worker_shows_nothing_new_and_goes_on_after() {
        let worker = start(|job| {
            let mut count = 0;
            while count < 1000 && job.may_go_on() {
                count += 1;
                job.show(count);
                std::thread::sleep(Duration::from_micros(200));
            }
            Ok(())
        });
        wait_for(&worker, |report| report.found.is_some());
        worker.set_paused(true);
        // What was under way ends.
        std::thread::sleep(Duration::from_millis(50));
        let before = worker.report().found;
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(worker.report().found, before);
        assert!(!worker.report().idle);
        worker.set_paused(false);
        wait_for(&worker, |report| report.idle);
        assert_eq!(worker.report().found.as_deref(), Some(&1000));
    }

    #[test]
    fn a_worker_that_nobody_wants_ends() {
        let (ended, end) = std::sync::mpsc::channel();
        let worker: Worker<()> = start(move |job| {
            while job.may_go_on() {}
            ended.send(()).ok();
            Err(Halt::Stopped)
        });
        worker.set_paused(true);
        drop(worker);
        assert_eq!(end.recv_timeout(Duration::from_secs(60)), Ok(()));
    }

    #[test]
    fn what_the_core_refuses_is_said() {
        let worker: Worker<()> = start(|_| Err(msd_core::Error::Empty.into()));
        wait_for(&worker, |report| report.idle);
        assert_eq!(worker.report().failure, Some(msd_core::Error::Empty.to_string()));
    }
}
