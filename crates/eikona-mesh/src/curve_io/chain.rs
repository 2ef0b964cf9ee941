//! Joins loose segments into polylines.

/// A polyline of point numbers, joined from segments.
pub(super) struct Chain {
    /// Point numbers; closed if the last equals the first.
    pub points: Vec<usize>,
    /// The lowest segment in it: chains are sorted in the order of the file.
    first_segment: usize,
    /// Number of segments opposite to the chain's direction.
    pub reversed: usize,
}

/// Joins oriented segments head to tail: first those that follow each other in the list, then, at
/// each point, the one remaining segment that ends there with the one that starts there. Where
/// several do, the chains end, since the continuation is ambiguous. Zero-length segments must have
/// been removed.
pub(super) fn oriented(points: usize, segments: &[[usize; 2]]) -> Vec<Chain> {
    const NONE: usize = usize::MAX;
    let mut next = vec![NONE; segments.len()];
    let mut has_previous = vec![false; segments.len()];
    for s in 1..segments.len() {
        if segments[s - 1][1] == segments[s][0] {
            next[s - 1] = s;
            has_previous[s] = true;
        }
    }
    let (mut ending, mut starting) = (vec![(0u32, NONE); points], vec![(0u32, NONE); points]);
    for (s, &[a, b]) in segments.iter().enumerate() {
        if !has_previous[s] {
            starting[a] = (starting[a].0 + 1, s);
        }
        if next[s] == NONE {
            ending[b] = (ending[b].0 + 1, s);
        }
    }
    for (&(ends, last), &(starts, first)) in ending.iter().zip(&starting) {
        if ends == 1 && starts == 1 {
            next[last] = first;
            has_previous[first] = true;
        }
    }
    let mut used = vec![false; segments.len()];
    let mut chains = Vec::new();
    // Open chains first; the rest are loops, which may start anywhere.
    let order = (0..segments.len()).filter(|&s| !has_previous[s]).chain(0..segments.len());
    for start in order {
        if used[start] {
            continue;
        }
        let mut chain = Chain { points: vec![segments[start][0]], first_segment: start, reversed: 0 };
        let mut s = start;
        while s != NONE && !used[s] {
            used[s] = true;
            chain.points.push(segments[s][1]);
            chain.first_segment = chain.first_segment.min(s);
            s = next[s];
        }
        chains.push(chain);
    }
    chains.sort_by_key(|c| c.first_segment);
    chains
}

/// Joins segments with arbitrary directions (as modelling programs write edges). Each chain takes
/// the direction of most of its segments, or of its first one on a tie.
pub(super) fn unoriented(points: usize, segments: &[[usize; 2]]) -> Vec<Chain> {
    let mut degree = vec![0u32; points];
    let mut at: Vec<[usize; 2]> = vec![[usize::MAX; 2]; points];
    for (s, ends) in segments.iter().enumerate() {
        for &p in ends {
            if let Some(slot) = at[p].get_mut(degree[p] as usize) {
                *slot = s;
            }
            degree[p] += 1;
        }
    }
    let mut used = vec![false; segments.len()];
    let mut chains = Vec::new();
    let ending = (0..segments.len()).flat_map(|s| {
        segments[s].into_iter().filter(|&p| degree[p] != 2).map(move |p| (s, p)).take(1).collect::<Vec<_>>()
    });
    let any = (0..segments.len()).map(|s| (s, segments[s][0]));
    for (start, from) in ending.chain(any) {
        if used[start] {
            continue;
        }
        let mut chain = Chain { points: vec![from], first_segment: start, reversed: 0 };
        let mut first_reversed = false;
        let (mut s, mut p) = (start, from);
        while !used[s] {
            used[s] = true;
            let reversed = segments[s][0] != p;
            p = segments[s][usize::from(!reversed)];
            chain.reversed += usize::from(reversed);
            if s <= chain.first_segment {
                (chain.first_segment, first_reversed) = (s, reversed);
            }
            chain.points.push(p);
            if degree[p] == 2 {
                s = if at[p][0] == s { at[p][1] } else { at[p][0] };
            }
        }
        let count = chain.points.len() - 1;
        if 2 * chain.reversed > count || (2 * chain.reversed == count && first_reversed) {
            chain.points.reverse();
            chain.reversed = count - chain.reversed;
        }
        chains.push(chain);
    }
    chains.sort_by_key(|c| c.first_segment);
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oriented_segments_become_open_and_closed_chains() {
        // An open run 0-1-2 given out of order, a loop 3-4-5, and two paths that cross at 6.
        let segments = [[1, 2], [3, 4], [0, 1], [4, 5], [5, 3], [7, 6], [6, 8], [9, 6], [6, 10]];
        let points: Vec<Vec<usize>> = oriented(11, &segments).into_iter().map(|c| c.points).collect();
        assert_eq!(points, [vec![0, 1, 2], vec![3, 4, 5, 3], vec![7, 6, 8], vec![9, 6, 10]]);
    }

    #[test]
    fn a_head_to_head_pair_stays_apart_when_oriented_and_is_joined_when_not() {
        let segments = [[0, 1], [2, 1], [2, 3], [3, 4]];
        let points: Vec<Vec<usize>> = oriented(5, &segments).into_iter().map(|c| c.points).collect();
        assert_eq!(points, [vec![0, 1], vec![2, 1], vec![2, 3, 4]]);
        let joined = unoriented(5, &segments);
        assert_eq!(joined.len(), 1);
        assert_eq!((joined[0].points.clone(), joined[0].reversed), (vec![0, 1, 2, 3, 4], 1));
    }

    #[test]
    fn an_unoriented_loop_follows_the_majority() {
        let chains = unoriented(3, &[[0, 1], [0, 2], [2, 1]]);
        assert_eq!((chains[0].points.clone(), chains[0].reversed), (vec![0, 2, 1, 0], 1));
    }
}
