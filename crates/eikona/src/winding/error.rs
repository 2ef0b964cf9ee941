//! Errors of winding number solves.

use crate::cut::EmbedError;
use eikona_mesh::{CurveError, Edge, Face, TriangleMesh, Vertex};
use eikona_numeric::JumpError;
use eikona_numeric::NumericError;
use thiserror::Error;

/// Why no winding number could be computed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WindingError {
    /// The curve is not on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The mesh has no faces.
    #[error("the mesh has no faces; give a mesh with at least one face")]
    NoFaces,
    /// No curve is given.
    #[error("no curve is given; give at least one oriented curve")]
    NoCurve,
    /// A curve is unsigned, so it has no left side.
    #[error("curve {curve} is unsigned, so it has no left side; give it as a signed curve")]
    Unsigned {
        /// 0-based index of the curve.
        curve: usize,
    },
    /// The mesh could not be cut along the curves.
    #[error(transparent)]
    Embed(EmbedError),
    /// The curve runs along an edge too often.
    #[error(
        "the curve runs more than {most} times in one direction along the edge from {}; remove repeated copies of the curve",
        named(&[*vertices])
    )]
    Multiplicity {
        /// The edge, in the mesh cut along the curve if it had to be cut.
        edge: Edge,
        /// Its vertices. Vertices of the input keep their numbers when the mesh is cut; higher
        /// numbers are vertices of the cut.
        vertices: [Vertex; 2],
        /// The largest multiplicity that is accepted.
        most: i32,
    },
    /// An option is out of range.
    #[error("{name} = {value} is out of range: {bound}")]
    Option {
        /// The option.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        bound: &'static str,
    },
    /// A linear system could not be solved.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// The linear program could not be solved.
    #[error("the linear program for the nonbounding part of the curve failed: {0}")]
    Program(UnsolvedProgram),
}

impl From<EmbedError> for WindingError {
    fn from(fault: EmbedError) -> Self {
        match fault {
            EmbedError::Stopped(fault) => fault.into(),
            fault => WindingError::Embed(fault),
        }
    }
}

/// Why the linear program could not be solved.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{reason}")]
#[non_exhaustive]
pub struct UnsolvedProgram {
    /// The reason in words, with a remedy. It names at most three edges.
    pub reason: String,
    /// The affected edges, by their vertices; empty if the fault is not local. Numbered as in
    /// [`WindingError::Multiplicity`].
    pub edges: Vec<[Vertex; 2]>,
}

impl WindingError {
    /// Describes a fault of the linear program in terms of the mesh: term `i` belongs to
    /// `edges[i]`.
    pub(crate) fn of_program(fault: JumpError, mesh: &TriangleMesh, edges: &[Edge]) -> WindingError {
        const REMESH: &str = "if edges differ in length by many orders of magnitude, remesh first";
        let (terms, reason) = match fault {
            JumpError::Stopped(fault) => return fault.into(),
            JumpError::NonFinite { term, what } => {
                let what = if what == "shift" { "jump" } else { "length" };
                (vec![term], format!("the {what} is not finite at the edge from EDGES; {REMESH}"))
            }
            JumpError::Infeasible { cycles, .. } => {
                let terms = cycles.into_iter().flat_map(|cycle| cycle.terms).collect();
                let reason = "the jumps cannot stay between zero and the curve's at the edges from EDGES, the only \
                              edges connecting a ring of faces; refine the mesh around them";
                (terms, reason.into())
            }
            JumpError::NegativeWeight { term, .. } | JumpError::NonPositiveLimit { term, .. } => {
                (vec![term], format!("invalid length of the edge from EDGES; {REMESH}"))
            }
            JumpError::WorkLimit { work } => (
                vec![],
                format!(
                    "no optimum within {work:.1e} steps on {} faces; simplify the mesh or close gaps of the curve",
                    mesh.face_count(),
                    work = work as f64
                ),
            ),
            JumpError::Uncertified { gap, .. } => {
                (vec![], format!("the solution found is not certified as optimal (gap {gap:.0e}); {REMESH}"))
            }
            JumpError::TooLarge { .. } => {
                let (faces, edges) = (mesh.face_count(), mesh.edge_count());
                (
                    vec![],
                    format!(
                        "{faces} faces and {edges} edges exceed the supported size; solve parts of the mesh"
                    ),
                )
            }
            // Other faults concern node indices and options, which are set here and not by the
            // user.
            fault => (vec![], fault.to_string()),
        };
        let edges: Vec<[Vertex; 2]> = terms.into_iter().map(|i| mesh.edge_vertices(edges[i])).collect();
        WindingError::Program(UnsolvedProgram { reason: reason.replace("EDGES", &named(&edges)), edges })
    }

    pub(crate) fn no_such_reference(face: Face) -> WindingError {
        let bound = "the mesh has no such face; faces are numbered from 0";
        WindingError::Option { name: "reference", value: face.index() as f64, bound }
    }
}

/// Lists edges in words, at most three of them.
fn named(edges: &[[Vertex; 2]]) -> String {
    const MAX_NAMED: usize = 3;
    let few: Vec<String> =
        edges.iter().take(MAX_NAMED).map(|[a, b]| format!("vertex {} to {}", a.index(), b.index())).collect();
    match edges.len().saturating_sub(MAX_NAMED) {
        0 => few.join(", "),
        more => format!("{} and {more} more", few.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::shapes;
    use eikona_numeric::InfeasibleCycle;

    #[test]
    fn faults_of_the_program_name_edges_and_a_remedy() {
        let mesh = shapes::torus(1.0, 0.4, 60, 30).unwrap();
        let edges: Vec<Edge> = mesh.edges().skip(7).collect();
        let [a, b] = mesh.edge_vertices(edges[2]).map(|v| v.index());
        let named = format!("vertex {a} to {b}");
        let many = |terms| vec![InfeasibleCycle { terms, excess: 0.5 }; 2];
        let faults = [
            (JumpError::NonFinite { term: 2, what: "weight" }, 1, vec!["length", &named, "remesh"]),
            (JumpError::NonFinite { term: 2, what: "shift" }, 1, vec!["jump", &named]),
            (JumpError::NonPositiveLimit { term: 2, limit: 0.0 }, 1, vec![&named]),
            (
                JumpError::Infeasible { cycles: many((2..2000).collect()), work: 5 },
                2 * 1998,
                vec![&named, "and 3993 more", "refine"],
            ),
            (JumpError::Infeasible { cycles: many(vec![2]), work: 5 }, 2, vec![&named, "refine"]),
            (JumpError::WorkLimit { work: 30_000_000 }, 0, vec!["3.0e7 steps", "3600 faces", "simplify"]),
            (JumpError::Uncertified { gap: 1e-3, worst: 1e-2 }, 0, vec!["1e-3", "remesh"]),
            (JumpError::TooLarge { nodes: 1, terms: 2 }, 0, vec!["3600 faces and 5400 edges"]),
        ];
        for (fault, count, words) in faults {
            let error = WindingError::of_program(fault, &mesh, &edges);
            let text = error.to_string();
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
            assert!(["term", "node", "limit", "EDGES"].iter().all(|word| !text.contains(word)), "{text}");
            assert!(text.len() < 300, "{text}");
            let WindingError::Program(program) = error else { panic!("{text}") };
            assert_eq!(program.edges.len(), count);
            assert!(program.edges.first().is_none_or(|ends| *ends == mesh.edge_vertices(edges[2])));
        }
    }
}
