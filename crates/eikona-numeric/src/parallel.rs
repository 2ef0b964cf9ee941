//! The numeric factorisation on several threads.
//!
//! Subtrees of the elimination tree are independent: threads take them from a queue, largest first.
//! The fronts above them follow in order, and share the products inside each front. A front adds
//! the update matrices of its children in the same order on any number of threads, so the digits of
//! the factor are the same.

use crate::error::NumericError;
use crate::kernels::{Vectorized, dispatch};
use crate::memory::Zeroed;
use crate::multifrontal::{Child, Problem, Stop, Workspace};
use crate::scalar::Scalar;
use crate::supernodes::Supernodes;
use crate::symbolic::Symbolic;
use crate::threads::together;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Mutex;

/// Subtrees are split until none has more than this share of a thread's part of the work.
const SHARE: f64 = 0.125;

/// Factorisations with fewer multiplications run on one thread.
const WORTH_THREADS: f64 = 1e7;

/// Factors the permuted lower triangle `entries` into `values`, in the layout of the symbolic
/// analysis.
pub(crate) fn factor<T: Scalar>(
    symbolic: &Symbolic,
    entries: &[T],
    values: &mut [T],
    threads: usize,
) -> Result<(), NumericError> {
    let problem = Problem::new(symbolic, entries);
    let plan = Plan::of(symbolic.supernodes(), threads);
    let no_memory = || symbolic.out_of_memory::<T>(threads);
    let failed = |stop: Stop| match stop {
        Stop::NotPositive(place) => symbolic.not_positive(place),
        Stop::NoMemory => no_memory(),
        Stop::Observer => NumericError::Stopped,
    };
    if plan.subtrees.len() < 2 {
        let mut workspace = Workspace::new(symbolic).ok_or_else(no_memory)?;
        let range = 0..symbolic.supernodes().count();
        return dispatch(Subtree { problem: &problem, range, values, workspace: &mut workspace })
            .map_err(failed);
    }
    let (mut subtrees, top) = plan.split(symbolic.supernodes(), values);
    // The queue is taken from its end.
    subtrees.sort_by(|a, b| plan.work[a.range.end - 1].total_cmp(&plan.work[b.range.end - 1]));
    let workers = threads.min(subtrees.len());
    let queue = Mutex::new(subtrees);
    let work = || -> Option<Vec<Done<T>>> {
        let mut workspace = Workspace::new(symbolic)?;
        let mut done = Vec::new();
        while let Some(Part { range, values }) = queue.lock().ok().and_then(|mut queue| queue.pop()) {
            let root = range.end - 1;
            let work = Subtree { problem: &problem, range, values, workspace: &mut workspace };
            let update = match dispatch(work) {
                Ok(()) => Ok(copied(workspace.last_update(symbolic.supernodes(), root))?),
                Err(stop) => Err(stop),
            };
            let stopped = matches!(update, Err(Stop::Observer));
            done.push(Done { root, update });
            if stopped {
                break;
            }
        }
        Some(done)
    };
    let done: Option<Vec<Vec<Done<T>>>> = together((0..workers).map(|_| work)).into_iter().collect();
    let mut updates = BTreeMap::new();
    // The first failure in the order of elimination, as on one thread.
    let mut failure: Option<usize> = None;
    for Done { root, update } in done.ok_or_else(no_memory)?.into_iter().flatten() {
        match update {
            Ok(update) => _ = updates.insert(root, update),
            Err(Stop::NotPositive(place)) => {
                failure = Some(failure.map_or(place, |first| first.min(place)));
            }
            Err(stop) => return Err(failed(stop)),
        }
    }
    if let Some(place) = failure {
        return Err(symbolic.not_positive(place));
    }
    dispatch(Top { problem: &problem, fronts: top, updates, threads }).map_err(failed)
}

/// The part of the work that a thread does on its own: a subtree of the elimination tree.
struct Subtree<'a, 'p, T> {
    problem: &'a Problem<'p, T>,
    range: Range<usize>,
    values: &'a mut [T],
    workspace: &'a mut Workspace<T>,
}

impl<T: Scalar> Vectorized for Subtree<'_, '_, T> {
    type Output = Result<(), Stop>;
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) -> Self::Output {
        self.problem.factor_range(simd, self.range, self.values, self.workspace)
    }
}

/// A factored subtree with its update matrix.
struct Done<T> {
    root: usize,
    update: Result<Zeroed<T>, Stop>,
}

/// The fronts above all subtrees.
struct Top<'a, 'p, T> {
    problem: &'a Problem<'p, T>,
    /// In elimination order.
    fronts: Vec<Part<'a, T>>,
    /// Update matrices that wait, by supernode.
    updates: BTreeMap<usize, Zeroed<T>>,
    threads: usize,
}

impl<T: Scalar> Vectorized for Top<'_, '_, T> {
    type Output = Result<(), Stop>;
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let Top { problem, fronts, mut updates, threads } = self;
        let supernodes = problem.symbolic.supernodes();
        let mut local = vec![0; problem.symbolic.unknowns()];
        for Part { range, values } in fronts {
            let s = range.start;
            // The last child first, as on a stack.
            let of_children: Vec<(usize, Zeroed<T>)> =
                supernodes.children(s).filter_map(|c| updates.remove_entry(&c)).collect();
            let children: Vec<Child<T>> = of_children
                .iter()
                .map(|(child, update)| Child { rows: supernodes.rows(*child), update })
                .collect();
            let size = supernodes.rows(s).len();
            let mut update = Zeroed::new(size * size).ok_or(Stop::NoMemory)?;
            problem.front(simd, s, values, &children, &mut update, &mut local, threads)?;
            updates.insert(s, update);
        }
        Ok(())
    }
}

/// Consecutive supernodes with their panels.
struct Part<'a, T> {
    range: Range<usize>,
    values: &'a mut [T],
}

/// How the elimination tree is shared.
struct Plan {
    /// Disjoint subtrees, in order; the supernodes between them are the top.
    subtrees: Vec<Range<usize>>,
    /// Multiplications in the subtree of each supernode.
    work: Vec<f64>,
}

impl Plan {
    fn of(supernodes: &Supernodes, threads: usize) -> Plan {
        let count = supernodes.count();
        let mut work: Vec<f64> = (0..count).map(|s| supernodes.work(s)).collect();
        for s in 0..count {
            if let Some(parent) = supernodes.parent(s) {
                work[parent] += work[s];
            }
        }
        let roots = (0..count).filter(|&s| supernodes.parent(s).is_none());
        let total: f64 = roots.clone().map(|s| work[s]).sum();
        if threads < 2 || total < WORTH_THREADS {
            return Plan { subtrees: Vec::new(), work };
        }
        let most = SHARE * total / threads as f64;
        let mut large: Vec<usize> = roots.collect();
        let mut subtrees = Vec::new();
        while let Some(s) = large.pop() {
            if work[s] <= most {
                subtrees.push(supernodes.first_descendant(s)..s + 1);
            } else {
                large.extend(supernodes.children(s));
            }
        }
        subtrees.sort_by_key(|range| range.start);
        Plan { subtrees, work }
    }

    /// Splits the values of the factor into those of the subtrees and those of the fronts above.
    fn split<'a, T>(
        &self,
        supernodes: &Supernodes,
        values: &'a mut [T],
    ) -> (Vec<Part<'a, T>>, Vec<Part<'a, T>>) {
        let (mut subtrees, mut top) = (Vec::new(), Vec::new());
        let mut rest = values;
        let mut take = |range: Range<usize>| {
            let entries = supernodes.panel(range.end - 1).end - supernodes.panel(range.start).start;
            let (values, others) = std::mem::take(&mut rest).split_at_mut(entries);
            rest = others;
            Part { range, values }
        };
        let mut s = 0;
        for range in self.subtrees.iter().cloned() {
            top.extend((s..range.start).map(|s| take(s..s + 1)));
            s = range.end;
            subtrees.push(take(range));
        }
        top.extend((s..supernodes.count()).map(|s| take(s..s + 1)));
        (subtrees, top)
    }
}

fn copied<T: Scalar>(values: &[T]) -> Option<Zeroed<T>> {
    let mut copy = Zeroed::new(values.len())?;
    copy.copy_from_slice(values);
    Some(copy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, Ordering, nested_dissection_order};

    #[test]
    fn subtrees_and_the_fronts_above_them_are_all_fronts() {
        let n = 200u32;
        let id = |i: u32, j: u32| i * n + j;
        let right = (0..n).flat_map(|i| (1..n).map(move |j| [id(i, j - 1), id(i, j)]));
        let down = (1..n).flat_map(|i| (0..n).map(move |j| [id(i - 1, j), id(i, j)]));
        let graph = Graph { unknowns: (n * n) as usize, pairs: right.chain(down).collect() };
        let positions: Vec<[f64; 3]> =
            (0..n * n).map(|v| [f64::from(v / n), f64::from(v % n), 0.0]).collect();
        let order = nested_dissection_order(&graph, &positions, 1).unwrap();
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order)).unwrap();
        let supernodes = symbolic.supernodes();
        assert!(Plan::of(supernodes, 1).subtrees.is_empty());
        for threads in [2, 4, 7] {
            let plan = Plan::of(supernodes, threads);
            assert!(plan.subtrees.len() >= 2 * threads, "{}", plan.subtrees.len());
            let mut values = vec![0.0; symbolic.factor_entries()];
            let (subtrees, top) = plan.split(supernodes, &mut values);
            let mut all: Vec<usize> = subtrees.iter().chain(&top).flat_map(|p| p.range.clone()).collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..supernodes.count()));
            for part in subtrees.iter().chain(&top) {
                let entries: usize = part.range.clone().map(|s| supernodes.panel(s).len()).sum();
                assert_eq!(part.values.len(), entries);
            }
            for s in top.iter().map(|part| part.range.start) {
                let children: Vec<usize> = supernodes.children(s).collect();
                let expected = (0..s).rev().filter(|&c| supernodes.parent(c) == Some(s));
                assert!(children.iter().copied().eq(expected));
            }
        }
    }
}
