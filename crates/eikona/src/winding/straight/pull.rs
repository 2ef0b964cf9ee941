//! Straightens pieces on the mesh cut open along everything that they must not cross.

use super::pieces::Piece;
use crate::curves::{path_length, straighten_around, straighten_loop};
use crate::winding::split::cut_open;
use eikona_mesh::{Located, Provenance, TriangleMesh, UnionFind, Vertex};
use eikona_numeric::{NumericError, check_step, check_stopped};

/// The mesh cut open along edges. Faces and halfedges keep their numbers.
pub(super) struct Slit {
    mesh: TriangleMesh,
    provenance: Provenance,
    is_fixed: Vec<bool>,
    unit: f64,
}

/// A straightened piece: its path on the uncut mesh, and its length before and after.
#[derive(Clone, Debug)]
pub(super) struct Pulled {
    pub path: Vec<Located>,
    pub before: f64,
    pub after: f64,
}

impl Slit {
    /// Cuts along the `closed` edges. Pieces do not pass the `fixed` vertices. Lengths are measured
    /// in `unit`s. `None` if the cut mesh is too large.
    pub fn new(
        mesh: &TriangleMesh,
        closed: &[bool],
        fixed: &[Vertex],
        unit: f64,
    ) -> Result<Option<Slit>, NumericError> {
        let mut fans = UnionFind::new(mesh.halfedge_count());
        let mut at_cut = vec![false; mesh.vertex_count()];
        for e in mesh.edges() {
            check_step(e.index())?;
            let ends = mesh.edge_vertices(e);
            let is_closed = closed[e.index()];
            if is_closed {
                ends.into_iter().for_each(|v| at_cut[v.index()] = true);
            }
            if let (&[a, b], false) = (mesh.edge_halfedges(e), is_closed) {
                for v in ends {
                    let corner = |h| (if mesh.origin(h) == v { h } else { h.next() }).index() as u32;
                    fans.join(corner(a), corner(b));
                }
            }
        }
        let (positions, triangles, provenance) = cut_open(mesh, &mut fans, |v| at_cut[v.index()]);
        check_stopped()?;
        let Ok(open) = TriangleMesh::new(positions, triangles) else { return Ok(None) };
        check_stopped()?;
        let scaled = open.positions().iter().map(|p| p.map(|x| x / unit)).collect();
        let mut is_fixed = vec![false; mesh.vertex_count()];
        fixed.iter().for_each(|v| is_fixed[v.index()] = true);
        let Ok(open) = open.with_positions(scaled) else { return Ok(None) };
        Ok(Some(Slit { mesh: open, provenance, is_fixed, unit }))
    }

    /// Straightens a piece; `None` if it is already straight, `Err` if it cannot be straightened.
    pub fn pull(&self, mesh: &TriangleMesh, piece: &Piece, keep_base: bool) -> Result<Option<Pulled>, Stays> {
        let mut path: Vec<Located> = Vec::with_capacity(piece.steps.len() + 1);
        for step in &piece.steps {
            let [a, b] = step.ends(&self.mesh);
            match path.last() {
                None => path.push(Located::Vertex(a)),
                Some(&last) if last == Located::Vertex(a) => {}
                Some(_) => return Err(Stays),
            }
            path.push(Located::Vertex(b));
        }
        // Every vertex is one of the uncut mesh or a copy of one.
        let parent = |v: Vertex| self.provenance.vertex_parent(v).unwrap_or(v);
        let is_fixed = |v: Vertex| self.is_fixed[parent(v).index()];
        let straight = if piece.is_loop && !keep_base {
            straighten_loop(&self.mesh, &path, &is_fixed)
        } else {
            straighten_around(&self.mesh, &path, &is_fixed)
        };
        let [before, after] = [&path, &straight].map(|p| path_length(&self.mesh, p));
        if after.is_nan() {
            return Err(Stays);
        }
        if after >= before * (1.0 - 1e-12) {
            return Ok(None);
        }
        let uncut = |place: Located| match place {
            Located::Vertex(v) => Located::Vertex(parent(v)),
            Located::Edge(e, t) => {
                let h = self.mesh.edge_halfedges(e)[0];
                Located::Edge(mesh.edge(h), if mesh.follows_edge(h) { t } else { 1.0 - t })
            }
            inside => inside,
        };
        let path = straight.into_iter().map(uncut).collect();
        Ok(Some(Pulled { path, before: before * self.unit, after: after * self.unit }))
    }
}

/// Error: the piece cannot be straightened and stays on edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stays;
