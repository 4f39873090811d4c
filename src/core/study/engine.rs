//! Work spread over threads, and what is already known left out.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::journal::Journal;
use super::{StudyError, StudyOptions, StudyProgress};

/// A list of tasks whose outcomes do not depend on each other.
pub(super) trait Tasks: Sync {
    type Outcome: Serialize + DeserializeOwned + Clone + Send;

    /// A number for each task that differs where its outcome may.
    fn keys(&self) -> Vec<u64>;

    /// A number for each task that grows with its cost: the dearest come first, so that no thread ends long after the
    /// others.
    fn cost(&self, task: usize) -> f64;

    /// Makes what the tasks `open` share.
    fn prepare(&self, open: &[usize], stop: &AtomicBool) -> Result<(), StudyError>;

    /// Does a task; `None` where it was interrupted.
    fn work(&self, task: usize, stop: &AtomicBool) -> Result<Option<Self::Outcome>, StudyError>;
}

/// Does what a list of tasks still lacks. Outcomes are in the order of the tasks, whatever thread did them; `None` those
/// that an interruption left undone.
pub(super) fn complete<W: Tasks>(
    tasks: &W,
    folder: &Path,
    options: &StudyOptions,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(StudyProgress),
) -> Result<Vec<Option<W::Outcome>>, StudyError> {
    let (mut journal, mut known) = Journal::open::<W::Outcome>(folder, options.fresh)?;
    let keys = tasks.keys();
    let mut outcomes: Vec<Option<W::Outcome>> = keys.iter().map(|key| known.remove(key)).collect();
    let mut open: Vec<usize> = (0..keys.len()).filter(|&task| outcomes[task].is_none()).collect();
    open.sort_by(|&a, &b| tasks.cost(b).total_cmp(&tasks.cost(a)));
    let total = keys.len();
    let mut done = total - open.len();
    tell(StudyProgress { done, known: done, total });
    let start = done;
    tasks.prepare(&open, stop)?;
    spread(options.threads, &open, stop, &|task, stop| tasks.work(task, stop), &mut |task, outcome| {
        journal.add(keys[task], &outcome)?;
        outcomes[task] = Some(outcome);
        done += 1;
        tell(StudyProgress { done, known: start, total });
        Ok(())
    })?;
    Ok(outcomes)
}

/// Does a task; `None` where it was interrupted.
pub(super) type Work<'a, R> = dyn Fn(usize, &AtomicBool) -> Result<Option<R>, StudyError> + Sync + 'a;

/// Calls `work` for the tasks from `threads` threads, in their order, and `take` from this one with what each returned,
/// as it comes. The first error, or `stop`, ends it after the tasks under way.
pub(super) fn spread<R: Send>(
    threads: usize,
    tasks: &[usize],
    stop: &AtomicBool,
    work: &Work<R>,
    take: &mut dyn FnMut(usize, R) -> Result<(), StudyError>,
) -> Result<(), StudyError> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads.max(1).min(tasks.len()) {
            let (sender, next, failed) = (sender.clone(), &next, &failed);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
                    let Some(&task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    // The receiver is gone where it failed.
                    if sender.send((task, work(task, stop))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut first = Ok(());
        for (task, outcome) in receiver {
            let taken = match outcome {
                Ok(Some(outcome)) if first.is_ok() => take(task, outcome),
                Ok(_) => Ok(()),
                Err(error) => Err(error),
            };
            if let (Err(error), Ok(())) = (taken, &first) {
                failed.store(true, Ordering::Relaxed);
                first = Err(error);
            }
        }
        first
    })
}
