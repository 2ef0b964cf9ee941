//! Pieces of the completion with their freedom to move and their straightened paths.

use super::pieces::Piece;
use super::pull::{Pulled, Slit, Stays};
use eikona_mesh::{Face, TriangleMesh, Vertex};
use eikona_numeric::{NumericError, check_stopped};

/// How far a piece may move.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Freedom {
    /// To the shortest path in its homotopy class.
    Free,
    /// To the shortest such path that does not enter faces whose label is certain.
    Banded,
    /// Not at all.
    OnEdges,
}

/// A piece of the completion and its straightened path.
pub(super) struct Strand {
    pub piece: Piece,
    pub freedom: Freedom,
    /// `None` if it does not move.
    pub pulled: Option<Pulled>,
}

impl Strand {
    pub fn stay(&mut self) {
        (self.freedom, self.pulled) = (Freedom::OnEdges, None);
    }
}

/// Pieces of one kind: boundaries of regions, or nonbounding loops.
pub(super) struct Layer {
    pub strands: Vec<Strand>,
    /// Vertices off the curve at which pieces end.
    junctions: Vec<Vertex>,
}

impl Layer {
    pub fn of((pieces, junctions): (Vec<Piece>, Vec<Vertex>)) -> Layer {
        let strand = |piece| Strand { piece, freedom: Freedom::Free, pulled: None };
        Layer { strands: pieces.into_iter().map(strand).collect(), junctions }
    }

    /// Straightens all pieces that may move. Their paths do not cross `closed` edges or pieces that
    /// stay; banded ones do not enter `certain` faces either.
    pub fn pull(
        &mut self,
        mesh: &TriangleMesh,
        closed: &[bool],
        certain: impl Fn(Face) -> bool,
        consistent: bool,
        unit: f64,
    ) -> Result<(), NumericError> {
        let mut closed = closed.to_vec();
        for strand in self.strands.iter().filter(|s| s.freedom == Freedom::OnEdges) {
            strand.piece.steps.iter().for_each(|s| closed[mesh.edge(s.high).index()] = true);
        }
        for freedom in [Freedom::Free, Freedom::Banded] {
            if self.strands.iter().all(|s| s.freedom != freedom) {
                continue;
            }
            if freedom == Freedom::Banded {
                self.close_faces(mesh, &certain, &mut closed);
            }
            let slit = Slit::new(mesh, &closed, &self.junctions, unit)?;
            for strand in self.strands.iter_mut().filter(|s| s.freedom == freedom) {
                check_stopped()?;
                let pulled = slit.as_ref().ok_or(Stays);
                match pulled.and_then(|slit| slit.pull(mesh, &strand.piece, !consistent)) {
                    Ok(pulled) => strand.pulled = pulled,
                    Err(Stays) => strand.stay(),
                }
            }
        }
        Ok(())
    }

    /// Closes the sides of certain faces that no piece touches.
    fn close_faces(&self, mesh: &TriangleMesh, certain: impl Fn(Face) -> bool, closed: &mut [bool]) {
        let mut at_piece = vec![false; mesh.vertex_count()];
        for step in self.strands.iter().flat_map(|s| &s.piece.steps) {
            step.ends(mesh).into_iter().for_each(|v| at_piece[v.index()] = true);
        }
        let is_near = |f: Face| mesh.face_vertices(f).iter().any(|v| at_piece[v.index()]);
        for f in mesh.faces().filter(|&f| certain(f) && !is_near(f)) {
            mesh.face_edges(f).into_iter().for_each(|e| closed[e.index()] = true);
        }
    }

    /// Iterates over the pieces that moved.
    pub fn moved(&self) -> impl Iterator<Item = (usize, &Piece, &Pulled)> {
        let all = self.strands.iter().enumerate();
        all.filter_map(|(i, s)| s.pulled.as_ref().map(|pulled| (i, &s.piece, pulled)))
    }

    pub fn stay_all(&mut self) {
        self.strands.iter_mut().for_each(Strand::stay);
    }

    /// Subtracts the pieces that moved from jumps at edges.
    pub fn subtract_moved(&self, mesh: &TriangleMesh, jump: &mut [f64]) {
        for step_of in self.moved().map(|(_, piece, _)| piece) {
            for step in &step_of.steps {
                let e = mesh.edge(step.high);
                let is_first = mesh.edge_halfedges(e)[0] == step.high;
                jump[e.index()] -= if is_first { step_of.height } else { -step_of.height };
            }
        }
    }
}
