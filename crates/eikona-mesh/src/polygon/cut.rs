//! Triangulation of a single polygon.

use super::ears;
use super::outline::{Outline, Shape};
use crate::id::Vertex;
use std::borrow::Cow;
use std::collections::VecDeque;

/// Appends the triangles of a polygon, as described at
/// [`PolygonMesh::triangulate`](super::PolygonMesh::triangulate). All indices must be in range and
/// there must be at least three corners.
///
/// # Errors
/// A vertex at two successive corners, or a vertex repeated by a polygon without area.
pub(crate) fn cut_polygon(
    corners: &[u32],
    positions: &[[f64; 3]],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), Vertex> {
    let all = corners;
    let n = corners.len();
    if let Some(k) = (0..n).find(|&k| corners[k] == corners[(k + 1) % n]) {
        return Err(Vertex(corners[k]));
    }
    let corners = &*without_dead_ends(corners);
    let n = corners.len();
    if n < 3 {
        return Err(repeated_vertex(all).unwrap_or(Vertex(all[0])));
    }
    let fan_from = |corner: usize| {
        let at = move |k: usize| corners[(corner + k) % n];
        (1..n - 1).map(move |k| [at(0), at(k), at(k + 1)])
    };
    if n == 3 {
        triangles.extend(fan_from(0));
        return Ok(());
    }
    let Some(outline) = Outline::of(corners, positions) else {
        return match repeated_vertex(corners) {
            Some(vertex) => Err(vertex),
            None => {
                triangles.extend(fan_from(0));
                Ok(())
            }
        };
    };
    if outline.is_star_shaped_from(0) {
        triangles.extend(fan_from(0));
    } else if n == 4 && repeated_vertex(corners).is_none() {
        let worst = |corner: usize| {
            let at = |k: usize| outline.points[(corner + k) % 4];
            let shapes = [1, 2].map(|k| Shape::of([at(0), at(k), at(k + 1)]).quality());
            shapes[0].min(shapes[1])
        };
        triangles.extend(fan_from(usize::from(worst(1) > worst(0))));
    } else {
        let mut found = Vec::with_capacity(n - 2);
        ears::triangulate(&outline.points, corners, &mut found);
        triangles.extend(found.iter().map(|t| t.map(|k| corners[k])));
    }
    Ok(())
}

/// Removes dead ends: of the corners `a b a`, `b` and one `a`, repeatedly. At most two corners are
/// left if the polygon has no area. Successive corners must differ.
pub(super) fn without_dead_ends(corners: &[u32]) -> Cow<'_, [u32]> {
    let n = corners.len();
    if (0..n).all(|k| corners[k] != corners[(k + 2) % n]) {
        return Cow::Borrowed(corners);
    }
    let mut path: VecDeque<u32> = VecDeque::with_capacity(n);
    for &v in corners {
        if path.len() >= 2 && path[path.len() - 2] == v {
            path.pop_back();
        } else {
            path.push_back(v);
        }
    }
    // Dead ends across the ends of the list.
    while path.len() >= 3 {
        let last = path.len() - 1;
        if path[0] == path[last] {
            path.pop_back();
        } else if path[0] == path[last - 1] {
            path.truncate(last - 1);
        } else if path[1] == path[last] {
            path.pop_front();
            path.pop_back();
        } else {
            break;
        }
    }
    Cow::Owned(path.into())
}

/// Returns the vertex of the first corner that repeats an earlier one.
fn repeated_vertex(corners: &[u32]) -> Option<Vertex> {
    let mut sorted: Vec<(u32, usize)> = corners.iter().copied().zip(0..).collect();
    sorted.sort_unstable();
    let repeats = sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    repeats.map(|pair| pair[1].1).min().map(|k| Vertex(corners[k]))
}
