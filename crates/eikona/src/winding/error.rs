//! Why no winding number could be computed.

use crate::cut::EmbedError;
use eikona_mesh::{CurveError, Edge, Face, TriangleMesh, Vertex};
use eikona_numeric::FlowError;
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
    #[error("the mesh has no faces, so there is nothing to be inside of")]
    NoFaces,
    /// There is no curve.
    #[error("there is no curve, so every region is outside; give at least one oriented curve")]
    NoCurve,
    /// A curve without direction bounds nothing.
    #[error("curve {curve} has no direction, so it has no inside; give it as a signed curve")]
    Unsigned {
        /// 0-based index of the curve.
        curve: usize,
    },
    /// The mesh could not be cut along the curves.
    #[error(transparent)]
    Embed(#[from] EmbedError),
    /// An edge is walked too often.
    #[error(
        "the edge from {} is walked more than {most} times in one direction; leave repeated copies of the curve out",
        named(&[*vertices])
    )]
    Multiplicity {
        /// The edge. Of the mesh cut along the curve, if it had to be cut.
        edge: Edge,
        /// Its vertices. Those of the input keep their numbers when the mesh is cut; higher numbers
        /// are of vertices that the cut made.
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
    #[error("the nonbounding part of the curve could not be found: {0}")]
    Program(UnsolvedProgram),
}

/// Why the linear program could not be solved.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{reason}")]
#[non_exhaustive]
pub struct UnsolvedProgram {
    /// In words, and what may help. Of many edges it names a few.
    pub reason: String,
    /// The edges concerned, if it is some of them, by their vertices; numbered as in
    /// [`WindingError::Multiplicity`].
    pub edges: Vec<[Vertex; 2]>,
}

impl WindingError {
    /// Why the linear program was not solved, in words of the mesh: term `i` is that of `edges[i]`.
    pub(crate) fn of_program(fault: FlowError, mesh: &TriangleMesh, edges: &[Edge]) -> WindingError {
        const REMESH: &str = "if edges differ in length by many orders of magnitude, remesh first";
        let (terms, reason) = match fault {
            FlowError::NonFinite { term, what } => {
                let what = if what == "shift" { "jump" } else { "length" };
                (vec![term], format!("the {what} is not a number at the edge from EDGES; {REMESH}"))
            }
            FlowError::Infeasible { cycles, .. } => {
                let terms = cycles.into_iter().flat_map(|cycle| cycle.terms).collect();
                let reason = "it can not stay within the curve along the edges from EDGES, which are all that \
                              joins a ring of faces; refine the mesh around them";
                (terms, reason.into())
            }
            FlowError::NegativeWeight { term, .. } | FlowError::NonPositiveLimit { term, .. } => {
                (vec![term], format!("there is no length at the edge from EDGES; {REMESH}"))
            }
            FlowError::WorkLimit { work } => (
                vec![],
                format!(
                    "not within {work:.1e} steps on {} faces; simplify the mesh, or close gaps of the curve",
                    mesh.face_count(),
                    work = work as f64
                ),
            ),
            FlowError::Uncertified { gap, .. } => (
                vec![],
                format!("the best that was found is not certain to be the best (gap {gap:.0e}); {REMESH}"),
            ),
            FlowError::TooLarge { .. } => {
                let (faces, edges) = (mesh.face_count(), mesh.edge_count());
                (vec![], format!("{faces} faces and {edges} edges are too many; solve parts of the mesh"))
            }
            // What is asked for here has faces for nodes, and no options of the user's.
            fault => (vec![], fault.to_string()),
        };
        let edges: Vec<[Vertex; 2]> = terms.into_iter().map(|i| mesh.edge_vertices(edges[i])).collect();
        WindingError::Program(UnsolvedProgram { reason: reason.replace("EDGES", &named(&edges)), edges })
    }

    pub(crate) fn no_such_reference(face: Face) -> WindingError {
        let bound = "the reference face does not exist; faces are numbered from 0";
        WindingError::Option { name: "reference", value: face.index() as f64, bound }
    }
}

/// Edges in words; a few, if they are many.
fn named(edges: &[[Vertex; 2]]) -> String {
    const MOST: usize = 3;
    let few: Vec<String> =
        edges.iter().take(MOST).map(|[a, b]| format!("vertex {} to {}", a.index(), b.index())).collect();
    match edges.len().saturating_sub(MOST) {
        0 => few.join(", "),
        more => format!("{} and {more} more", few.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::shapes;
    use eikona_numeric::Contradiction;

    #[test]
    fn faults_of_the_program_name_edges_and_what_helps() {
        let mesh = shapes::torus(1.0, 0.4, 60, 30).unwrap();
        let edges: Vec<Edge> = mesh.edges().skip(7).collect();
        let [a, b] = mesh.edge_vertices(edges[2]).map(|v| v.index());
        let named = format!("vertex {a} to {b}");
        let many = |terms| vec![Contradiction { terms, excess: 0.5 }; 2];
        let faults = [
            (FlowError::NonFinite { term: 2, what: "weight" }, 1, vec!["length", &named, "remesh"]),
            (FlowError::NonFinite { term: 2, what: "shift" }, 1, vec!["jump", &named]),
            (FlowError::NonPositiveLimit { term: 2, limit: 0.0 }, 1, vec![&named]),
            (
                FlowError::Infeasible { cycles: many((2..2000).collect()), work: 5 },
                2 * 1998,
                vec![&named, "and 3993 more", "refine"],
            ),
            (FlowError::Infeasible { cycles: many(vec![2]), work: 5 }, 2, vec![&named, "refine"]),
            (FlowError::WorkLimit { work: 30_000_000 }, 0, vec!["3.0e7 steps", "3600 faces", "simplify"]),
            (FlowError::Uncertified { gap: 1e-3, worst: 1e-2 }, 0, vec!["1e-3", "remesh"]),
            (FlowError::TooLarge { nodes: 1, terms: 2 }, 0, vec!["3600 faces and 5400 edges"]),
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
