//! Streamlines of the field itself: curves whose tangent is one of its directions.
//!
//! In a face the N-th power is a power of a linear field, so a streamline turns inside of faces and
//! meets each edge at any point (`tracer.rs`). Evenly spaced lines (`spacing.rs`) keep a distance
//! to others of about the same direction; lines of other directions cross them.

#[cfg(test)]
mod forms;
mod spacing;
mod tracer;

use crate::geometry::unit_of;
use crate::geometry::vector::distance;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::solution::PolarField;
use crate::setters::setters;
use eikona_mesh::{Located, SurfacePoint, TriangleMesh};
use spacing::Spacing;
use tracer::Tracer;

/// Positions closer than this are one, relative to the mean distance of nodes.
const SAME: f64 = 1e-4;

/// Why a streamline ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StreamlineEnd {
    /// It has the length that was asked for.
    Length,
    /// It has reached the boundary.
    Boundary,
    /// It has reached a singular point.
    Singularity,
    /// It has come close to another line of the same direction, or to itself.
    Neighbor,
    /// It is closed.
    Closed,
    /// The directions on both sides of an edge lead to it, or lead around a spot.
    Trapped,
    /// It has as many steps as a line may have, about a million.
    Steps,
}

/// A streamline.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Streamline {
    /// Its nodes, at least two. A closed line repeats its first node.
    pub nodes: Vec<Located>,
    /// Why it ends where it begins, and where it ends.
    pub ends: [StreamlineEnd; 2],
}

impl Streamline {
    /// Returns the positions of the nodes on the mesh of the field. Those next to the one before,
    /// where a line crosses several edges beside a vertex, are left out.
    pub fn positions(&self, mesh: &TriangleMesh) -> Vec<[f64; 3]> {
        let all: Vec<[f64; 3]> = self.nodes.iter().map(|node| node.position(mesh)).collect();
        let length: f64 = all.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
        let same = SAME * length / all.len() as f64;
        let mut positions: Vec<[f64; 3]> = Vec::with_capacity(all.len());
        for &position in &all {
            if positions.last().is_none_or(|&before| distance(before, position) > same) {
                positions.push(position);
            }
        }
        // The end stays: that of a closed line is its beginning.
        if let ([_, .., last], Some(&end)) = (positions.as_mut_slice(), all.last()) {
            *last = end;
        }
        positions
    }

    /// Returns whether the line is closed.
    pub fn is_closed(&self) -> bool {
        self.ends[1] == StreamlineEnd::Closed
    }
}

/// Options of evenly spaced streamlines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StreamlineOptions {
    /// Distance between lines of about the same direction, in the unit of the mesh. Default: a 50th
    /// of the square root of the area.
    pub separation: Option<f64>,
}

setters!(StreamlineOptions { with_separation: separation = Option<f64> });

impl PolarField {
    /// Returns evenly spaced streamlines (after Jobard and Lefer 1997, on a surface).
    ///
    /// Lines of about the same direction are `separation` apart where they start, and end where
    /// they come closer than half of it. The result is the same every time.
    ///
    /// # Errors
    /// [`PolarFieldError::Separation`] unless it is positive, finite, and large enough for less
    /// than about a million lines; [`PolarFieldError::Numeric`] if an observer stops the work.
    ///
    /// # Cost
    /// O(A / s^2) nodes for the area A and the separation s, plus one per crossed edge.
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::polar_field::{FieldOptions, Guide, Solver, Streamline, StreamlineOptions};
    /// // Lines along both boundaries of a ring.
    /// let ring = shapes::annulus(0.5, 1.0, 10, 60)?;
    /// let options = FieldOptions::default().with_degree(2).with_guides(vec![Guide::Boundary]);
    /// let field = Solver::new(&ring, &Default::default())?.solve(&[], &options)?;
    /// let lines = field.streamlines(&StreamlineOptions::default().with_separation(Some(0.08)))?;
    /// assert!(lines.iter().any(Streamline::is_closed));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn streamlines(&self, options: &StreamlineOptions) -> Result<Vec<Streamline>, PolarFieldError> {
        let size = self.size() * unit_of(self.mesh());
        let (separation, least) = (options.separation.unwrap_or(0.02 * size), 1e-4 * size);
        if !(separation.is_finite() && separation > least) {
            return Err(PolarFieldError::Separation { separation, least });
        }
        Spacing::new(self, separation).lines()
    }

    /// Returns the streamline through a point in both directions, of at most this length to each
    /// side. `direction` counts the N directions at the point from 0, as
    /// [`vectors_at`](Self::vectors_at) does.
    ///
    /// # Errors
    /// [`PolarFieldError::Start`] if the point is not on the mesh, [`PolarFieldError::Vanishes`].
    pub fn streamline_from(
        &self,
        point: SurfacePoint,
        direction: u32,
        length: f64,
    ) -> Result<Streamline, PolarFieldError> {
        let place = point.locate(self.mesh()).map_err(PolarFieldError::Start)?;
        let tracer = Tracer::new(self, 0.1 * self.size());
        let vanishes = PolarFieldError::Vanishes {
            element: match place {
                Located::Vertex(v) => v.to_string(),
                Located::Edge(e, _) => e.to_string(),
                Located::Face(f, _) => f.to_string(),
            },
        };
        let start = tracer.start(place, direction).ok_or(vanishes)?;
        let reach = if length.is_finite() { length.max(0.0) / tracer.unit } else { 100.0 * self.size() };
        let [ahead, behind] = [start, start.reversed()].map(|start| {
            let mut walked = 0.0;
            let mut nodes = Vec::new();
            let mut walk = tracer.walk(start);
            let end = loop {
                match walk.step(reach - walked) {
                    Ok((node, by)) => {
                        nodes.push(node);
                        walked += by;
                        if nodes.len() > 10 && tracer.is_back(&start, walk.state(), by) {
                            break StreamlineEnd::Closed;
                        }
                        if walked >= reach {
                            break StreamlineEnd::Length;
                        }
                    }
                    Err(end) => {
                        nodes.extend((end == StreamlineEnd::Boundary).then(|| tracer.located(walk.state())));
                        break end;
                    }
                }
            };
            (nodes, end)
        });
        Ok(joined(tracer.located(&start), ahead, behind))
    }

    /// The root of the area, in the unit of the layouts.
    fn size(&self) -> f64 {
        self.domain.bevel.triangles.iter().map(|t| t.area).sum::<f64>().sqrt()
    }
}

/// Joins the two halves of a line. Where the first half closes, the second is not needed.
fn joined(
    start: Located,
    (ahead, end): (Vec<Located>, StreamlineEnd),
    (behind, begin): (Vec<Located>, StreamlineEnd),
) -> Streamline {
    if end == StreamlineEnd::Closed {
        let nodes = std::iter::once(start).chain(ahead).chain([start]).collect();
        return Streamline { nodes, ends: [end, end] };
    }
    let nodes = behind.into_iter().rev().chain([start]).chain(ahead).collect();
    Streamline { nodes, ends: [begin, end] }
}
