//! Nearest neighbours among a set of points.

use crate::geometry::vector::distance;

/// Returns for each point the index of the nearest other point and its distance; `None` if there is
/// no other. Ties go to the lower index.
///
/// O(n log n) for points in general position: a k-d tree, stored as a permutation whose middle
/// entries are the splitting points.
pub(crate) fn nearest_others(points: &[[f64; 3]]) -> Vec<Option<(usize, f64)>> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    split(points, &mut order, 0);
    (0..points.len())
        .map(|i| {
            let mut best = None;
            search(points, &order, 0, i, &mut best);
            best
        })
        .collect()
}

fn split(points: &[[f64; 3]], order: &mut [usize], axis: usize) {
    if order.len() < 2 {
        return;
    }
    let middle = order.len() / 2;
    order
        .select_nth_unstable_by(middle, |&a, &b| points[a][axis].total_cmp(&points[b][axis]).then(a.cmp(&b)));
    let (low, high) = order.split_at_mut(middle);
    split(points, low, (axis + 1) % 3);
    split(points, &mut high[1..], (axis + 1) % 3);
}

fn search(points: &[[f64; 3]], order: &[usize], axis: usize, i: usize, best: &mut Option<(usize, f64)>) {
    if order.is_empty() {
        return;
    }
    let middle = order.len() / 2;
    let candidate = order[middle];
    if candidate != i {
        let d = distance(points[i], points[candidate]);
        if best.is_none_or(|(j, e)| d < e || (d == e && candidate < j)) {
            *best = Some((candidate, d));
        }
    }
    let offset = points[i][axis] - points[candidate][axis];
    let (near, far) = if offset < 0.0 {
        (&order[..middle], &order[middle + 1..])
    } else {
        (&order[middle + 1..], &order[..middle])
    };
    search(points, near, (axis + 1) % 3, i, best);
    // Coinciding points need no further search: nothing is nearer than distance 0.
    if best.is_none_or(|(_, d)| offset.abs() <= d && d > 0.0) {
        search(points, far, (axis + 1) % 3, i, best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_agrees_with_brute_force() {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64
        };
        let points: Vec<[f64; 3]> = (0..300).map(|_| [next(), next(), next() % 7.0]).collect();
        for (i, found) in nearest_others(&points).into_iter().enumerate() {
            let all = (0..points.len()).filter(|&j| j != i).map(|j| distance(points[i], points[j]));
            assert_eq!(found.unwrap().1, all.fold(f64::INFINITY, f64::min));
        }
        assert_eq!(nearest_others(&[[0.0; 3]]), [None]);
        assert_eq!(nearest_others(&[[0.0; 3], [3.0, 4.0, 0.0]])[0], Some((1, 5.0)));
        assert_eq!(nearest_others(&vec![[0.0; 3]; 20_000])[7].map(|n| n.1), Some(0.0));
    }
}
