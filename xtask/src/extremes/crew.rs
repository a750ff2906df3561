//! Many runs at once, though one may panic or never end.
//!
//! A thread cannot be ended from outside. So a run that is not done in time is given up: its thread
//! is left alone and another takes its place. For that threads are not scoped, and they share their
//! data.

use crate::extremes::outcome::{Outcome, Verdict};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::{Duration, Instant};

/// Gives the verdict on a run by its number.
pub(super) type Work = Arc<dyn Fn(usize) -> Verdict + Send + Sync>;

enum News {
    Started(usize),
    Done(usize, Verdict),
}

/// Does `count` runs on so many threads, each within a deadline; calls `hear` with the number of
/// runs that are done.
///
/// The verdicts are in the order of the runs, and do not depend on the number of threads.
pub(super) fn run_all(
    (work, count): (Work, usize),
    threads: usize,
    deadline: Duration,
    hear: &mut dyn FnMut(usize),
) -> Vec<Verdict> {
    let next = Arc::new(AtomicUsize::new(0));
    let (send, receive) = channel();
    let hire = || {
        let (work, next, send) = (Arc::clone(&work), Arc::clone(&next), send.clone());
        std::thread::spawn(move || labour(&work, (&next, count), &send))
    };
    (0..threads.clamp(1, count.max(1))).for_each(|_| drop(hire()));
    let mut verdicts: Vec<Option<Verdict>> = vec![None; count];
    let mut running: Vec<(usize, Instant)> = Vec::new();
    let mut done = 0;
    while done < count {
        match receive.recv_timeout(Duration::from_millis(200)).ok() {
            Some(News::Started(run)) => running.push((run, Instant::now())),
            Some(News::Done(run, verdict)) => {
                running.retain(|&(other, _)| other != run);
                // A run that was given up stays so, even if it ends after all.
                if verdicts[run].is_none() {
                    verdicts[run] = Some(verdict);
                    done += 1;
                    hear(done);
                }
            }
            None => {}
        }
        while let Some(late) = running.iter().position(|(_, start)| deadline < start.elapsed()) {
            let (run, _) = running.swap_remove(late);
            let said = format!("after {} s", deadline.as_secs());
            verdicts[run] = Some(Verdict::ended(Outcome::Hang, said));
            done += 1;
            hear(done);
            hire();
        }
    }
    let lost = || Verdict::ended(Outcome::Panic, "no verdict".into());
    verdicts.into_iter().map(|verdict| verdict.unwrap_or_else(lost)).collect()
}

fn labour(work: &Work, (next, count): (&AtomicUsize, usize), send: &Sender<News>) {
    loop {
        let run = next.fetch_add(1, Ordering::Relaxed);
        if count <= run || send.send(News::Started(run)).is_err() {
            return;
        }
        let verdict = catch_unwind(AssertUnwindSafe(|| work(run))).unwrap_or_else(|cause| {
            let said = cause.downcast_ref::<String>().cloned();
            let said = said.or_else(|| cause.downcast_ref::<&str>().map(|&said| said.to_owned()));
            Verdict::ended(Outcome::Panic, said.unwrap_or_default())
        });
        if send.send(News::Done(run, verdict)).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_and_a_run_without_end_are_verdicts_and_the_others_go_on() {
        let work: Work = Arc::new(|run| match run {
            1 => panic!("on purpose"),
            2 => {
                std::thread::sleep(Duration::from_secs(3600));
                unreachable!()
            }
            _ => Verdict { outcome: Outcome::Bounded, error: Some(run as f64), said: None },
        });
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let verdicts = run_all((work, 6), 2, Duration::from_secs(5), &mut |_| {});
        std::panic::set_hook(hook);
        let outcomes: Vec<Outcome> = verdicts.iter().map(|verdict| verdict.outcome).collect();
        let (good, panic, hang) = (Outcome::Bounded, Outcome::Panic, Outcome::Hang);
        assert_eq!(outcomes, [good, panic, hang, good, good, good]);
        assert_eq!(verdicts[1].said.as_deref(), Some("on purpose"));
        assert_eq!(verdicts[5].error, Some(5.0));
    }
}
