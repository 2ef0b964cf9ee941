//! A mesh and the data that do not depend on the curve.

use crate::geometry::{Triangle, lay_out_in, unit_of};
use crate::winding::operators::Operators;
use eikona_mesh::{Components, TriangleMesh, Vertex, VertexFan};
use eikona_numeric::{Cholesky, NumericError, Resources, check_step, check_stopped};
use std::ops::Deref;
use std::sync::OnceLock;

/// A mesh, consistently oriented where orientable, with its operators. These are analysed and
/// factored on first use.
#[derive(Debug)]
pub(super) struct Surface {
    pub mesh: TriangleMesh,
    /// Whether the faces are consistently oriented.
    pub consistent: bool,
    /// Whether every closed curve bounds, so that there is no nonbounding part.
    pub simply_connected: bool,
    /// The unit of length of `triangles`. Labels do not depend on the size of the mesh, and squares
    /// of very large or small lengths overflow or underflow.
    pub unit: f64,
    pub triangles: Vec<Triangle>,
    pub resources: Resources,
    pub on_faces: Operators,
    on_delaunay: OnceLock<Operators>,
}

impl Surface {
    pub fn new(mesh: TriangleMesh, resources: Resources) -> Result<Surface, NumericError> {
        let unit = unit_of(&mesh);
        let triangles = lay_out_in(&mesh, unit)?;
        let simply_connected = is_simply_connected(&mesh)?;
        check_stopped()?;
        let on_faces = Operators::on_faces(&mesh, &triangles, resources);
        check_stopped()?;
        Ok(Surface {
            consistent: mesh.is_consistently_oriented(),
            simply_connected,
            on_faces,
            on_delaunay: OnceLock::new(),
            resources,
            mesh,
            unit,
            triangles,
        })
    }

    /// Returns the operators without the excluded vertices, on the faces or on Delaunay triangles.
    pub fn prepared(&self, excluded: &[bool], delaunay: bool) -> Result<Prepared<'_>, NumericError> {
        let mesh = &self.mesh;
        let whole = !excluded.contains(&true);
        let make = || Operators::on_delaunay(mesh, &self.triangles, excluded, self.resources);
        let on = match (delaunay, whole) {
            (false, _) => &self.on_faces,
            (true, true) => self.on_delaunay.get_or_init(make),
            (true, false) => {
                let on = make();
                let factor = Kept::Own(on.factor(mesh, excluded)?.into());
                return Ok(Prepared { on: Kept::Own(on.into()), factor });
            }
        };
        let factor = if whole {
            Kept::Lent(on.whole_factor(mesh)?)
        } else {
            Kept::Own(on.factor(mesh, excluded)?.into())
        };
        Ok(Prepared { on: Kept::Lent(on), factor })
    }
}

/// Operators and the factor of the Laplacian, borrowed from the surface or temporary.
pub(super) struct Prepared<'a> {
    pub on: Kept<'a, Operators>,
    pub factor: Kept<'a, Cholesky<f64>>,
}

pub(super) enum Kept<'a, T> {
    Lent(&'a T),
    Own(Box<T>),
}

impl<T> Deref for Kept<'_, T> {
    type Target = T;
    fn deref(&self) -> &T {
        match self {
            Kept::Lent(kept) => kept,
            Kept::Own(own) => own,
        }
    }
}

/// Returns whether every component is a sphere or a disk: manifold, and of Euler characteristic 2,
/// or 1 with a boundary (a closed surface of characteristic 1 is a projective plane).
fn is_simply_connected(mesh: &TriangleMesh) -> Result<bool, NumericError> {
    let components = Components::of(mesh);
    check_stopped()?;
    let mut characteristic = vec![0i64; components.count];
    let mut has_boundary = vec![false; components.count];
    let of = |v: Vertex| components.of_vertex[v].expect("a vertex of a face has a component") as usize;
    for e in mesh.edges() {
        let component = of(mesh.edge_vertices(e)[0]);
        characteristic[component] -= 1;
        match mesh.edge_halfedges(e).len() {
            1 => has_boundary[component] = true,
            2 => {}
            _ => return Ok(false),
        }
    }
    check_stopped()?;
    for &[v, ..] in mesh.triangles() {
        characteristic[of(Vertex(v))] += 1;
    }
    for v in mesh.vertices() {
        check_step(v.index())?;
        let Some(&corner) = mesh.vertex_corners(v).first() else { continue };
        if VertexFan::through(mesh, corner).corners.len() < mesh.vertex_corners(v).len() {
            return Ok(false);
        }
        characteristic[of(v)] += 1;
    }
    Ok(characteristic.iter().zip(has_boundary).all(|(&chi, boundary)| chi == 2 || chi == 1 && boundary))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::{Topology, shapes};

    /// Joins meshes; `shared` vertices of the second are the first vertices of the first.
    fn joined(a: &TriangleMesh, b: &TriangleMesh, shared: u32) -> TriangleMesh {
        let count = a.vertex_count() as u32;
        let number = |v: u32| if v < shared { v } else { count + v - shared };
        let positions = [a.positions(), &b.positions()[shared as usize..]].concat();
        let moved = b.triangles().iter().map(|face| face.map(number));
        TriangleMesh::new(positions, a.triangles().iter().copied().chain(moved).collect()).unwrap()
    }

    #[test]
    fn simply_connected_surfaces_are_recognised() {
        let sphere = shapes::icosphere(1).unwrap();
        let torus = shapes::torus(1.0, 0.4, 12, 6).unwrap();
        let disk = shapes::disk(3, 8, 1.0).unwrap();
        let annulus = shapes::annulus(1.0, 2.0, 2, 9).unwrap();
        let band = shapes::moebius_band(1.0, 0.6, 12, 2).unwrap();
        // Six vertices, ten faces.
        let plane = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]];
        let rest = [[1, 2, 4], [2, 3, 5], [3, 4, 1], [4, 5, 2], [5, 1, 3]];
        let projective = TriangleMesh::new(vec![[0.0; 3]; 6], [plane, rest].concat()).unwrap();
        let cases = [
            (sphere.clone(), true),
            (disk.clone(), true),
            (joined(&sphere, &disk, 0), true),
            (torus.clone(), false),
            (annulus.clone(), false),
            (band, false),
            (projective, false),
            (joined(&sphere, &torus, 0), false),
            (joined(&disk, &annulus, 0), false),
            // At a vertex, and along an edge.
            (joined(&sphere, &sphere, 1), false),
            (joined(&sphere, &disk, 2), false),
        ];
        for (i, (mesh, expected)) in cases.iter().enumerate() {
            assert_eq!(is_simply_connected(mesh).unwrap(), *expected, "case {i}");
            let topology = Topology::of(mesh);
            let simple = |c: &eikona_mesh::Component| c.genus == Some(0) && c.boundary_loop_count <= 1;
            let by_topology = topology.is_manifold() && topology.components.iter().all(simple);
            assert_eq!(by_topology, *expected, "case {i}");
        }
    }
}
