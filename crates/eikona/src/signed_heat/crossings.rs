//! Crossings of curves with each other, or with themselves, between their nodes.

use eikona_mesh::{Edge, Face, Located, Segment, SegmentHost};
use std::collections::{BTreeMap, HashMap};

/// Returns the pairs of segments that meet inside a face or on an edge, by index. Segments that
/// meet in a common node are not listed. Where several segments meet at one place along an edge,
/// not all pairs are listed: each node there is paired with the segments that cover it.
///
/// # Cost
/// Sorts and sweeps the segments of each face: `k log k` for `k` segments unless many overlap.
pub(super) fn crossing_segments(segments: &[Segment]) -> Vec<[usize; 2]> {
    let mut of_face: BTreeMap<Face, Vec<FaceSegment>> = BTreeMap::new();
    let mut of_edge: HashMap<Edge, Vec<(f64, f64, usize)>> = HashMap::new();
    for (index, segment) in segments.iter().enumerate() {
        match segment.host {
            SegmentHost::Face(face, ends) => {
                let ends = ends.map(|weights| [weights[1], weights[2]]);
                of_face.entry(face).or_default().push(FaceSegment { ends, index });
            }
            SegmentHost::Edge(edge, [s, t]) => {
                of_edge.entry(edge).or_default().push((s.min(t), s.max(t), index));
            }
        }
    }
    let mut crossings = Vec::new();
    for in_face in of_face.values_mut() {
        in_face.sort_by(|a, b| a.range().0.total_cmp(&b.range().0));
        for (k, a) in in_face.iter().enumerate() {
            let reached = in_face[k + 1..].iter().take_while(|b| b.range().0 <= a.range().1);
            crossings.extend(reached.filter(|b| a.meets(b)).map(|b| [a.index, b.index]));
        }
    }
    for (index, segment) in segments.iter().enumerate() {
        for end in segment.ends {
            if let Located::Edge(edge, t) = end
                && let Some(along) = of_edge.get(&edge)
            {
                let covering = along.iter().filter(|(from, to, _)| (*from..=*to).contains(&t));
                crossings.extend(covering.map(|(_, _, other)| [index, *other]));
            }
        }
    }
    crossings.retain(|[a, b]| !share_an_end(&segments[*a], &segments[*b]));
    crossings
}

fn share_an_end(a: &Segment, b: &Segment) -> bool {
    a.ends.iter().any(|end| b.ends.iter().any(|other| end.key() == other.key()))
}

/// Segment through a face, in the affine plane of two of its barycentric coordinates.
struct FaceSegment {
    ends: [[f64; 2]; 2],
    index: usize,
}

impl FaceSegment {
    /// Range of the first coordinate.
    fn range(&self) -> (f64, f64) {
        let [a, b] = self.ends.map(|end| end[0]);
        (a.min(b), a.max(b))
    }

    /// Returns whether the two segments have a point in common. Touching counts, up to rounding.
    fn meets(&self, other: &FaceSegment) -> bool {
        let apart = |a: &FaceSegment, b: &FaceSegment| {
            let [p, q] = a.ends;
            let [s, t] = b.ends.map(|r| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]));
            s * t > 0.0
        };
        let interval = |a: &FaceSegment| {
            let [p, q] = a.ends;
            (p[1].min(q[1]), p[1].max(q[1]))
        };
        let ([(from, to), (other_from, other_to)], [a, b]) =
            ([interval(self), interval(other)], [self.range(), other.range()]);
        let overlap = from <= other_to && other_from <= to && a.0 <= b.1 && b.0 <= a.1;
        overlap && !apart(self, other) && !apart(other, self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_face(face: u32, ends: [[f64; 2]; 2]) -> Segment {
        let weights = ends.map(|[x, y]| [1.0 - x - y, x, y]);
        Segment {
            curve: 0,
            node: 0,
            ends: weights.map(|w| Located::Face(Face(face), w)),
            host: SegmentHost::Face(Face(face), weights),
        }
    }

    #[test]
    fn segments_cross_in_a_common_face_only() {
        let rising = [[0.1, 0.1], [0.4, 0.4]];
        let falling = [[0.1, 0.4], [0.4, 0.1]];
        let beside = [[0.3, 0.1], [0.5, 0.3]];
        let crossings = |list: &[Segment]| crossing_segments(list);
        assert_eq!(crossings(&[in_face(0, rising), in_face(0, falling)]), [[0, 1]]);
        assert!(crossings(&[in_face(0, rising), in_face(1, falling)]).is_empty());
        assert!(crossings(&[in_face(0, rising), in_face(0, beside)]).is_empty());
    }

    #[test]
    fn a_segment_that_ends_on_another_meets_it() {
        let floor = [[0.1, 0.25], [0.5, 0.25]];
        let post = [[0.25, 0.25], [0.25, 0.5]];
        assert_eq!(crossing_segments(&[in_face(3, floor), in_face(3, post)]), [[0, 1]]);
        let above = [[0.25, 0.3], [0.25, 0.5]];
        assert!(crossing_segments(&[in_face(3, floor), in_face(3, above)]).is_empty());
    }

    #[test]
    fn a_node_within_an_edge_meets_the_segment_along_it() {
        let along = Segment {
            curve: 0,
            node: 0,
            ends: [Located::Edge(Edge(5), 0.25), Located::Edge(Edge(5), 0.75)],
            host: SegmentHost::Edge(Edge(5), [0.25, 0.75]),
        };
        let across = |t: f64| Segment {
            ends: [Located::Edge(Edge(5), t), Located::Face(Face(0), [0.3, 0.3, 0.4])],
            ..in_face(0, [[0.0, 0.0], [0.3, 0.4]])
        };
        assert!(crossing_segments(&[along, across(0.5)]).contains(&[1, 0]));
        assert!(!crossing_segments(&[along, across(0.8)]).contains(&[1, 0]));
    }
}
