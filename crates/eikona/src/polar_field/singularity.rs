//! Prescribed indices: where the field turns, and how often.

use crate::polar_field::bevel::{BeveledMesh, Cycle, PerCycle};
use crate::polar_field::error::{MOST_TURNS, PolarFieldError};
use eikona_mesh::{Located, SurfacePoint};

/// An element around which the field turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// A point: a vertex inside the surface, a point inside an edge of two faces, or one inside a
    /// face.
    Point(SurfacePoint),
    /// A boundary loop, by its index in
    /// [`Topology::boundary_loops`](eikona_mesh::Topology::boundary_loops).
    Boundary(usize),
}

/// A prescribed index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// The element.
    pub place: Place,
    /// How often the field turns around it, counter-clockwise: a whole multiple of 1/N. Around a
    /// boundary loop, the turns relative to its tangent, walked with the surface on the right.
    pub index: f64,
}

/// A prescribed index in units of 1/N, at a place on the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Prescribed {
    pub cycle: Cycle,
    pub point: Option<Located>,
    /// The index times N.
    pub turns: i64,
}

/// Largest accepted deviation of an index times N from a whole number, so that 0.333 is a third.
const ROUNDED: f64 = 0.01;

/// Returns an index times N, if it is whole up to decimals that were left out.
pub(crate) fn whole_turns(
    index: f64,
    degree: u32,
    what: impl Fn() -> String,
) -> Result<i64, PolarFieldError> {
    let exact = index * f64::from(degree);
    let turns = exact.round();
    if exact.abs() <= MOST_TURNS && (exact - turns).abs() <= ROUNDED {
        Ok(turns as i64)
    } else {
        Err(PolarFieldError::Index { what: what(), index, degree })
    }
}

/// Locates the singularities and checks their indices.
pub(crate) fn located(
    bevel: &BeveledMesh,
    singularities: &[Singularity],
    degree: u32,
) -> Result<Vec<Prescribed>, PolarFieldError> {
    let mut seen = bevel.constant(false);
    let mut result = Vec::with_capacity(singularities.len());
    for (i, s) in singularities.iter().enumerate() {
        let what = || format!("singularity {i}");
        let turns = whole_turns(s.index, degree, what)?;
        let (cycle, point) = match s.place {
            Place::Boundary(b) if b < bevel.topology.boundary_loops.len() => {
                (Cycle::Boundary(b as u32), None)
            }
            Place::Boundary(b) => {
                let loops = bevel.topology.boundary_loops.len();
                return Err(PolarFieldError::NoSuchLoop { singularity: i, boundary: b, loops });
            }
            Place::Point(point) => {
                let place = point.locate(&bevel.mesh);
                let place = place.map_err(|fault| PolarFieldError::Point { singularity: i, fault })?;
                let boundary = |element: String| PolarFieldError::OnBoundary { singularity: i, element };
                let cycle = match place {
                    Located::Vertex(v) if bevel.mesh.vertex_corners(v).is_empty() => {
                        return Err(PolarFieldError::UnusedVertex { singularity: i, vertex: v });
                    }
                    Located::Vertex(v) if bevel.loop_of_vertex(v).is_some() => {
                        return Err(boundary(v.to_string()));
                    }
                    Located::Vertex(v) => Cycle::Vertex(v),
                    Located::Edge(e, _) if bevel.mesh.is_boundary_edge(e) => {
                        return Err(boundary(e.to_string()));
                    }
                    Located::Edge(e, _) => Cycle::Edge(e),
                    Located::Face(f, _) => Cycle::Face(f),
                };
                (cycle, Some(place))
            }
        };
        if std::mem::replace(&mut seen[cycle], true) {
            return Err(PolarFieldError::Repeated { singularity: i, element: name(cycle) });
        }
        result.push(Prescribed { cycle, point, turns });
    }
    Ok(result)
}

/// Names the element of a cycle.
pub(crate) fn name(cycle: Cycle) -> String {
    match cycle {
        Cycle::Face(f) => f.to_string(),
        Cycle::Edge(e) => e.to_string(),
        Cycle::Vertex(v) => v.to_string(),
        Cycle::Boundary(b) => format!("boundary loop {b}"),
    }
}

/// Returns the index times N of each cycle, after checking that they add up to N times the Euler
/// characteristic on each component (Poincaré-Hopf).
pub(crate) fn turns_of_cycles(
    bevel: &BeveledMesh,
    singularities: &[Prescribed],
    degree: u32,
) -> Result<PerCycle<i64>, PolarFieldError> {
    let components = &bevel.topology.components;
    let mut turns = bevel.constant(0i64);
    let mut sums = vec![0i64; components.len()];
    for s in singularities {
        turns[s.cycle] = s.turns;
        sums[bevel.component_of(s.cycle)] += s.turns;
    }
    for (c, component) in components.iter().enumerate() {
        // A hole counts as a cycle, and the characteristic is that of the surface with holes.
        let needed = i64::from(degree) * component.euler_characteristic;
        if sums[c] != needed {
            return Err(PolarFieldError::IndexSum {
                component: c,
                first_face: component.first_face,
                sum: sums[c] as f64 / f64::from(degree),
                needed: component.euler_characteristic,
                missing: (needed - sums[c]) as f64 / f64::from(degree),
                has_boundary: component.boundary_loop_count > 0,
            });
        }
    }
    Ok(turns)
}
