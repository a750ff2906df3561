//! A thread of low priority that takes a bounded share of one core.

use super::{BROKEN, Report, Task};
use crate::background::lower_priority;
use msd_study::choice::Choice;
use msd_study::monitor::{Halt, Monitor, Progress};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Use of the machine by a worker, in words.
pub const MANNERS: &str = "At most half a core, at low priority; nothing while paused";
/// Largest share of one core for a worker.
const SHARE: f64 = 0.5;
/// Length of a slice of work, seconds: less than a frame, so that no frame waits long.
const SLICE: f64 = 4e-3;

/// State shared by both threads.
#[derive(Debug)]
struct Desk<T> {
    report: Report<T>,
    paused: bool,
    /// Whether the result is no longer wanted.
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
        // A panicking thread leaves no partial values.
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Desk<T>)) {
        change(&mut self.desk());
        self.woken.notify_all();
    }
}

/// The window's handle: reads the results. Its drop cancels the work.
#[derive(Debug)]
pub(crate) struct Worker<T>(Arc<Shared<T>>);

impl<T: Send + Sync + 'static> Worker<T> {
    /// Starts the work.
    pub(crate) fn start(mut work: impl Task<Found = T>) -> Self {
        let report = Report::default();
        let desk = Mutex::new(Desk { report, paused: false, ended: false, wish: None });
        let shared = Arc::new(Shared { desk, woken: Condvar::new() });
        let mut monitor = ThreadMonitor { shared: shared.clone(), since: Instant::now() };
        let spawned = spawn(move || {
            // A panic would end the whole program.
            let failure = match catch_unwind(AssertUnwindSafe(|| drive(&mut work, &mut monitor))) {
                Ok(Ok(()) | Err(Halt::Cancelled)) => None,
                Ok(Err(halt)) => Some(halt.to_string()),
                Err(_) => Some(BROKEN.to_owned()),
            };
            monitor.shared.change(|desk| (desk.report.idle, desk.report.failure) = (true, failure));
        });
        if let Err(error) = spawned {
            shared.change(|desk| (desk.report.idle, desk.report.failure) = (true, Some(error)));
        }
        Worker(shared)
    }

    /// Returns the current report.
    pub(crate) fn report(&self) -> Report<T> {
        self.0.desk().report.clone()
    }

    /// Pauses or resumes the work.
    pub(crate) fn set_paused(&self, paused: bool) {
        self.0.change(|desk| desk.paused = paused);
    }

    /// Requests a trial of a choice as the next one.
    pub(crate) fn wish(&self, choice: Choice) {
        self.0.change(|desk| desk.wish = Some(choice));
    }
}

impl<T> Drop for Worker<T> {
    fn drop(&mut self) {
        self.0.change(|desk| desk.ended = true);
    }
}

/// Drives a task to its end, or until it is cancelled.
fn drive<W: Task>(task: &mut W, monitor: &mut ThreadMonitor<W::Found>) -> Result<(), Halt> {
    let mut is_idle = false;
    loop {
        monitor.proceed()?;
        let found = task.advance(monitor.wish(is_idle)?, monitor)?;
        is_idle = found.is_none();
        if let Some(found) = found {
            monitor.shared.change(|desk| desk.report.found = Some(Arc::new(found)));
        }
        if !W::IN_PIECES {
            return Ok(());
        }
    }
}

/// The thread's handle.
struct ThreadMonitor<T> {
    shared: Arc<Shared<T>>,
    /// Start of the current slice of work.
    since: Instant,
}

impl<T> ThreadMonitor<T> {
    /// Takes the next requested choice; an idle task waits for one.
    fn wish(&mut self, is_idle: bool) -> Result<Option<Choice>, Halt> {
        let mut desk = self.shared.desk();
        if is_idle {
            desk.report.idle = desk.wish.is_none();
            let waits = |desk: &mut Desk<T>| desk.wish.is_none() && !desk.ended;
            let woken = self.shared.woken.wait_while(desk, waits);
            desk = woken.unwrap_or_else(PoisonError::into_inner);
            self.since = Instant::now();
        }
        desk.report.idle = false;
        if desk.ended { Err(Halt::Cancelled) } else { Ok(desk.wish.take()) }
    }
}

impl<T> Monitor for ThreadMonitor<T> {
    fn report(&mut self, progress: Progress) {
        self.shared.change(|desk| desk.report.progress = Some(progress));
    }

    /// Rests after each slice, and waits while paused.
    fn proceed(&mut self) -> Result<(), Halt> {
        let result = |ended| if ended { Err(Halt::Cancelled) } else { Ok(()) };
        let worked = self.since.elapsed().as_secs_f64();
        let desk = self.shared.desk();
        if worked < SLICE && !desk.paused {
            return result(desk.ended);
        }
        let rest = Duration::from_secs_f64(worked * (1.0 / SHARE - 1.0));
        let wanted = |desk: &mut Desk<T>| !desk.ended;
        let rested = self.shared.woken.wait_timeout_while(desk, rest, wanted);
        let (desk, _) = rested.unwrap_or_else(PoisonError::into_inner);
        let waits = |desk: &mut Desk<T>| desk.paused && !desk.ended;
        let desk = self.shared.woken.wait_while(desk, waits);
        let ended = desk.unwrap_or_else(PoisonError::into_inner).ended;
        self.since = Instant::now();
        result(ended)
    }
}

/// Runs work on a thread pool of one thread, which its steps share: costs are of one core.
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
        // Not a measurement, only a time limit for a failing test.
        let begin = Instant::now();
        while !what(&worker.report()) {
            assert!(begin.elapsed() < Duration::from_secs(60), "nothing came");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Work in pieces that report their results.
    struct Pieces<T, F>(F, std::marker::PhantomData<fn(T)>);

    impl<T: 'static, F> Task for Pieces<T, F>
    where
        F: FnMut(&mut dyn Monitor) -> Result<Option<T>, Halt> + Send + 'static,
    {
        type Found = T;
        const NAME: &'static str = "pieces";
        const IN_PIECES: bool = true;

        fn advance(
            &mut self,
            _: Option<Choice>,
            monitor: &mut dyn Monitor,
        ) -> Result<Option<T>, Halt> {
            (self.0)(monitor)
        }
    }

    fn start<T: Send + Sync + 'static>(
        work: impl FnMut(&mut dyn Monitor) -> Result<Option<T>, Halt> + Send + 'static,
    ) -> Worker<T> {
        Worker::start(Pieces(work, std::marker::PhantomData))
    }

    #[test]
    fn a_paused_worker_shows_nothing_new_and_goes_on_after() {
        let mut count = 0;
        let worker = start(move |_| {
            count += 1;
            std::thread::sleep(Duration::from_micros(200));
            Ok((count <= 1000).then_some(count))
        });
        wait_for(&worker, |report| report.found.is_some());
        worker.set_paused(true);
        // The piece in progress ends.
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
        let (held, end) = std::sync::mpsc::channel::<()>();
        let worker: Worker<()> = start(move |monitor| {
            let _held = &held;
            while monitor.proceed().is_ok() {}
            Err(Halt::Cancelled)
        });
        worker.set_paused(true);
        drop(worker);
        // The thread drops the work, started or not, and with it this end of the channel.
        let ended = Err(std::sync::mpsc::RecvTimeoutError::Disconnected);
        assert_eq!(end.recv_timeout(Duration::from_secs(60)), ended);
    }

    #[test]
    fn what_the_core_refuses_is_said() {
        let worker: Worker<()> = start(|_| Err(msd_core::Error::Empty.into()));
        wait_for(&worker, |report| report.idle);
        assert_eq!(worker.report().failure, Some(msd_core::Error::Empty.to_string()));
    }
}
