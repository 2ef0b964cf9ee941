//! Cuts the mesh open where labels change.

use crate::winding::corner_values::tip_corner;
use crate::winding::solution::Winding;
use eikona_mesh::{
    Edge, FaceField, Halfedge, MeshError, Provenance, SurfacePoint, TriangleMesh, UnionFind, Vertex,
};

/// A mesh in which regions of different labels share no vertex: see [`Winding::split`].
#[derive(Clone, Debug)]
pub struct Split {
    /// The faces of [`Winding::mesh`] in their order, so that [`Winding::labels`] apply. Vertices
    /// keep their numbers; copies follow.
    pub mesh: TriangleMesh,
    /// The vertex of [`Winding::mesh`] that each vertex copies.
    pub provenance: Provenance,
}

impl Winding {
    /// Cuts the mesh open along the completed boundary of the regions: at every edge whose two
    /// faces have different labels.
    ///
    /// A vertex whose faces have more than one label gets a copy per fan of equally labelled faces
    /// (faces connected across edges at it), so that every vertex of the result has one label. At
    /// an edge of three or more faces those of equal label stay together. All other vertices are
    /// unchanged, also those at which the surface only touches itself.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] if the copies do not fit into 32-bit indices; coarsen the mesh.
    ///
    /// # Cost
    /// Nearly linear: O(V + F log d) for d faces at an edge.
    ///
    /// ```
    /// use eikona::mesh::{Curve, SurfaceCurves, Vertex, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// let disk = shapes::disk(20, 6, 20.0)?;
    /// let ring = Curve::signed([1, 2, 3, 4, 5, 6, 1].map(Vertex));
    /// let curve = SurfaceCurves::from_curve(ring);
    /// let winding = surface_winding_number(&disk, &curve, &WindingOptions::default())?;
    /// let split = winding.split()?;
    /// assert_eq!(split.mesh.vertex_count(), disk.vertex_count() + 6); // the ring, on both sides
    /// let copy = Vertex(disk.vertex_count() as u32);
    /// assert_eq!(split.provenance.vertex_place(copy), Some(Vertex(1).into()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn split(&self) -> Result<Split, MeshError> {
        let (mesh, labels) = (&self.mesh, &self.labels);
        let mut fans = UnionFind::new(mesh.halfedge_count());
        mesh.edges().for_each(|e| join_across(&mut fans, mesh, e, labels));

        let is_split = |v: Vertex| {
            let corners = mesh.vertex_corners(v);
            corners.iter().any(|c| labels[c.face()] != labels[corners[0].face()])
        };
        let (positions, triangles, provenance) = cut_open(mesh, &mut fans, is_split);
        Ok(Split { mesh: TriangleMesh::new(positions, triangles)?, provenance })
    }
}

/// Gives each of some vertices a copy for every set of its corners except the first. Returns
/// positions, triangles, which keep the order of faces and corners, and the provenance.
pub(super) fn cut_open(
    mesh: &TriangleMesh,
    corners_of: &mut UnionFind,
    is_split: impl Fn(Vertex) -> bool,
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>, Provenance) {
    let mut positions = mesh.positions().to_vec();
    let mut places: Vec<SurfacePoint> = mesh.vertices().map(SurfacePoint::from).collect();
    let mut triangles = mesh.triangles().to_vec();
    // The sets at a vertex, each with its copy.
    let mut copies: Vec<(u32, u32)> = Vec::new();
    for v in mesh.vertices().filter(|&v| is_split(v)) {
        copies.clear();
        for corner in mesh.vertex_corners(v) {
            let set = corners_of.find(corner.index() as u32);
            let copy = match copies.binary_search_by_key(&set, |c| c.0) {
                Ok(place) => copies[place].1,
                Err(place) => {
                    let mut copy = v.0;
                    if !copies.is_empty() {
                        copy = positions.len() as u32;
                        positions.push(mesh.position(v));
                        places.push(v.into());
                    }
                    copies.insert(place, (set, copy));
                    copy
                }
            };
            triangles[corner.face().index()][corner.index() % 3] = copy;
        }
    }
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count()).with_vertex_places(&places);
    (positions, triangles, provenance)
}

/// Joins the corners at both ends of an edge, for those of its faces that have the same label.
fn join_across(fans: &mut UnionFind, mesh: &TriangleMesh, e: Edge, labels: &FaceField<i32>) {
    let mut join_all = |halfedges: &[Halfedge]| {
        for pair in halfedges.windows(2).filter(|p| labels[p[0].face()] == labels[p[1].face()]) {
            for v in mesh.edge_vertices(e) {
                let at = |h: Halfedge| if mesh.origin(h) == v { h.index() } else { tip_corner(h) };
                fans.join(at(pair[0]) as u32, at(pair[1]) as u32);
            }
        }
    };
    match mesh.edge_halfedges(e) {
        two @ [_, _] => join_all(two),
        more => {
            let mut by_label = more.to_vec();
            by_label.sort_by_key(|h| labels[h.face()]);
            join_all(&by_label);
        }
    }
}
