//! Loops over long columns, shared among the threads of the current rayon pool.
//!
//! A column is halved until its parts are short, at places that depend on its length alone. The
//! results of the parts are merged in the order of the halves. So a sum has the same bits on any
//! number of threads, and without the feature `parallel`.

use super::RECORD;
use core::ops::Range;

/// Numbers of a column of vectors that one thread takes at a time, at most: those of 16384
/// particles. Sharing fewer costs more than it saves, as the other thread has to be woken.
const SHARE: usize = 1024 * RECORD;

/// Data that can be cut between two records.
pub(crate) trait Split: Send + Sized {
    /// Its length, as that of a column of vectors.
    fn numbers(&self) -> usize;
    /// Cuts after so many numbers.
    fn split(self, numbers: usize) -> (Self, Self);
}

impl<R: Sync> Split for &[R] {
    fn numbers(&self) -> usize {
        self.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        self.split_at(numbers)
    }
}

impl<R: Send> Split for &mut [R] {
    fn numbers(&self) -> usize {
        self.len()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        self.split_at_mut(numbers)
    }
}

/// Splits a column of a number for each slot where one of vectors is split, which has three; it may
/// be empty.
pub(crate) fn split_singles<R>(column: &[R], numbers: usize) -> (&[R], &[R]) {
    column.split_at(column.len().min(numbers / 3))
}

/// Two columns of one length.
impl<A: Split, B: Split> Split for (A, B) {
    fn numbers(&self) -> usize {
        self.0.numbers()
    }
    fn split(self, numbers: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.split(numbers), self.1.split(numbers));
        ((a, b), (c, d))
    }
}

/// Works on every part of a column.
pub(crate) fn for_each_share<W: Split>(work: W, run: impl Fn(W) + Sync) {
    merge_shares(work, &run, &|(), ()| ());
}

/// Works on every part of a column and merges their results.
pub(crate) fn merge_shares<W: Split, O: Send>(
    work: W,
    run: &(impl Fn(W) -> O + Sync),
    merge: &(impl Fn(O, O) -> O + Sync),
) -> O {
    let numbers = work.numbers();
    if numbers <= SHARE {
        return run(work);
    }
    let (low, high) = work.split(numbers / RECORD / 2 * RECORD);
    let (low, high) = join(|| merge_shares(low, run, merge), || merge_shares(high, run, merge));
    merge(low, high)
}

/// Works on every part of a column, each with an item of its own; part k starts at `cut(k)`.
pub(crate) fn for_each_part<W: Split, T: Send>(
    work: W,
    (first, items): (usize, &mut [T]),
    cut: &(impl Fn(usize) -> usize + Sync),
    run: &(impl Fn(usize, W, &mut T) + Sync),
) {
    if let [item] = items {
        return run(first, work, item);
    }
    let half = items.len() / 2;
    let (low, high) = work.split(cut(first + half) - cut(first));
    let (low_items, items) = items.split_at_mut(half);
    join(
        || for_each_part(low, (first, low_items), cut, run),
        || for_each_part(high, (first + half, items), cut, run),
    );
}

/// The merge of [`merge_shares`] in turn: `run` gets the numbers of each part.
pub(crate) fn merge_in_turn<O>(
    numbers: Range<usize>,
    run: &mut impl FnMut(Range<usize>) -> O,
    merge: &impl Fn(O, O) -> O,
) -> O {
    if numbers.len() <= SHARE {
        return run(numbers);
    }
    let middle = numbers.start + numbers.len() / RECORD / 2 * RECORD;
    let low = merge_in_turn(numbers.start..middle, run, merge);
    let high = merge_in_turn(middle..numbers.end, run, merge);
    merge(low, high)
}

/// Does two things, at the same time where there are threads for both.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "parallel")]
    if are_several() {
        return rayon::join(a, b);
    }
    (a(), b())
}

/// Does something, on a thread of the pool where it is to be shared and there are several: from
/// there, sharing costs little.
pub(crate) fn enter<A: Send>(is_shared: bool, run: impl FnOnce() -> A + Send) -> A {
    if is_shared { join(run, || ()).0 } else { run() }
}

/// Whether there are threads to share work with.
pub(crate) fn are_several() -> bool {
    1 < count()
}

/// The number of threads that share work.
pub(crate) fn count() -> usize {
    #[cfg(feature = "parallel")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    1
}
