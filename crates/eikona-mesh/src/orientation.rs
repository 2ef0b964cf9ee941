//! Orientability of a mesh, and the faces to flip to orient it consistently.

use crate::field::FaceField;
use crate::id::{Edge, Face, Halfedge};
use crate::mesh::TriangleMesh;
use crate::quality::TriangleShape;
use std::convert::Infallible;

/// The areas of the two orientations of a patch count as equal if they differ by less than this
/// share: sums over millions of faces carry rounding errors of this order at most.
const EQUAL_AREA: f64 = 1e-9;

/// A consistent orientation of the faces, patch by patch.
///
/// A **patch** is a set of faces connected through edges with exactly two faces. Edges with three
/// or more faces are not crossed, since it is ambiguous which of their faces continue each other.
/// So an edge with two faces always lies inside one patch. Patches are numbered by their first
/// face.
///
/// ```
/// use eikona_mesh::{Face, Orientation, TriangleMesh};
/// let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
/// // The second face is clockwise.
/// let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 3, 2]])?;
/// let orientation = Orientation::of(&mesh);
/// assert_eq!(orientation.inconsistent_edges.len(), 1);
/// assert_eq!(orientation.sign_of_face[Face(1)], -1);
/// assert!(orientation.is_orientable());
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Orientation {
    /// +1 where a face keeps its orientation, -1 where it is to be flipped.
    ///
    /// Each orientable patch keeps the orientation that covers the larger area (on a tie, that of
    /// the first face). So the result does not change if faces of less than half the area are
    /// flipped in the input. A nonorientable patch has no consistent choice; all its faces keep
    /// their orientation.
    pub sign_of_face: FaceField<i8>,
    /// The patch of each face.
    pub patch_of_face: FaceField<u32>,
    /// The patches.
    pub patches: Vec<Patch>,
    /// Edges whose two faces run along them in the same direction in the input, in increasing
    /// order.
    pub inconsistent_edges: Vec<Edge>,
}

/// Faces connected through edges with exactly two faces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Its first face.
    pub first_face: Face,
    /// Number of faces.
    pub face_count: usize,
    /// Number of faces with sign -1.
    pub flipped_face_count: usize,
    /// In a nonorientable patch, an edge that closes an orientation-reversing path of faces from
    /// one of its sides to the other; `None` in an orientable one.
    pub witness: Option<Edge>,
}

impl Patch {
    /// Returns whether its faces can be oriented consistently.
    pub fn is_orientable(&self) -> bool {
        self.witness.is_none()
    }
}

impl Orientation {
    /// Computes the orientation.
    ///
    /// # Cost
    /// O(F); about 0.25 s per million faces.
    pub fn of(mesh: &TriangleMesh) -> Orientation {
        let Ok(flood) = Flood::in_steps(mesh, || Ok::<(), Infallible>(()));
        let flip = patches_to_flip(mesh, &flood);
        let mut orientation = Orientation {
            sign_of_face: flood.sign,
            patch_of_face: flood.patch_of_face,
            patches: flood.patches,
            inconsistent_edges: inconsistent_edges(mesh),
        };
        for f in mesh.faces() {
            let p = orientation.patch_of_face[f] as usize;
            let patch = &mut orientation.patches[p];
            let sign = &mut orientation.sign_of_face[f];
            if !patch.is_orientable() {
                *sign = 1;
            } else if flip[p] {
                *sign = -*sign;
            }
            patch.flipped_face_count += usize::from(*sign < 0);
        }
        orientation
    }

    /// Returns the mesh with the faces of negative sign flipped. Vertices and faces keep their
    /// numbers.
    pub fn oriented(&self, mesh: &TriangleMesh) -> TriangleMesh {
        mesh.with_flipped_faces(|f| self.sign_of_face[f] < 0)
    }

    /// Returns whether every patch is orientable. This can hold even if edges have three or more
    /// faces.
    pub fn is_orientable(&self) -> bool {
        self.patches.iter().all(Patch::is_orientable)
    }
    /// Returns whether no edge of the input has two faces that run along it in the same direction.
    pub fn is_consistent(&self) -> bool {
        self.inconsistent_edges.is_empty()
    }
    /// Returns the faces to flip, in increasing order.
    pub fn flipped_faces(&self) -> Vec<Face> {
        self.sign_of_face.iter().filter(|(_, sign)| **sign < 0).map(|(f, _)| f).collect()
    }
}

/// Signs relative to the first face of each patch, transported along one path of faces to each
/// face.
pub(crate) struct Flood {
    sign: FaceField<i8>,
    patch_of_face: FaceField<u32>,
    pub(crate) patches: Vec<Patch>,
}

/// Iterates over the edges with two faces, each with its halfedges.
fn manifold_edges(mesh: &TriangleMesh) -> impl Iterator<Item = (Edge, [Halfedge; 2])> {
    mesh.edges().filter_map(|e| Some((e, two_faces(mesh, e)?)))
}

fn two_faces(mesh: &TriangleMesh, e: Edge) -> Option<[Halfedge; 2]> {
    mesh.edge_halfedges(e).try_into().ok()
}

/// Returns whether the faces of two halfedges of one edge are consistently oriented.
fn consistent(mesh: &TriangleMesh, [g, h]: [Halfedge; 2]) -> bool {
    mesh.follows_edge(g) != mesh.follows_edge(h)
}

/// Returns the edges whose two faces are inconsistently oriented, in increasing order.
pub(crate) fn inconsistent_edges(mesh: &TriangleMesh) -> Vec<Edge> {
    manifold_edges(mesh).filter(|&(_, pair)| !consistent(mesh, pair)).map(|(e, _)| e).collect()
}

impl Flood {
    /// Calls `between` every few milliseconds, which may stop it.
    pub(crate) fn in_steps<E>(
        mesh: &TriangleMesh,
        mut between: impl FnMut() -> Result<(), E>,
    ) -> Result<Flood, E> {
        const UNSEEN: i8 = 0;
        const STEP: usize = 1 << 16;
        let mut sign = FaceField::constant(mesh.face_count(), UNSEEN);
        let mut patch_of_face = FaceField::constant(mesh.face_count(), 0);
        let mut patches = Vec::new();
        let mut waiting = Vec::new();
        for first_face in mesh.faces() {
            if sign[first_face] != UNSEEN {
                continue;
            }
            let patch = patches.len() as u32;
            let mut face_count = 0;
            sign[first_face] = 1;
            waiting.push(first_face);
            while let Some(f) = waiting.pop() {
                patch_of_face[f] = patch;
                face_count += 1;
                if face_count % STEP == 0 {
                    between()?;
                }
                for pair in mesh.face_edges(f).into_iter().filter_map(|e| two_faces(mesh, e)) {
                    let other = if pair[0].face() == f { pair[1].face() } else { pair[0].face() };
                    if sign[other] == UNSEEN {
                        sign[other] = if consistent(mesh, pair) { sign[f] } else { -sign[f] };
                        waiting.push(other);
                    }
                }
            }
            patches.push(Patch { first_face, face_count, flipped_face_count: 0, witness: None });
        }
        let mut flood = Flood { sign, patch_of_face, patches };
        between()?;
        for (e, pair) in manifold_edges(mesh) {
            let [f, g] = pair.map(Halfedge::face);
            if (flood.sign[f] == flood.sign[g]) != consistent(mesh, pair) {
                flood.patches[flood.patch_of_face[f] as usize].witness.get_or_insert(e);
            }
        }
        Ok(flood)
    }
}

/// Returns, per patch, whether the faces opposite to the first one cover the larger area.
fn patches_to_flip(mesh: &TriangleMesh, flood: &Flood) -> Vec<bool> {
    // Most meshes are consistent, and then no areas are needed.
    let mut mixed = vec![false; flood.patches.len()];
    for (f, _) in flood.sign.iter().filter(|(_, sign)| **sign < 0) {
        mixed[flood.patch_of_face[f] as usize] = true;
    }
    let shapes = || {
        let faces = flood.sign.iter().filter(|(f, _)| mixed[flood.patch_of_face[*f] as usize]);
        faces.map(|(f, sign)| (f, *sign, TriangleShape::of(mesh.face_positions(f))))
    };
    // Relative to the largest face, so that squares neither overflow nor all underflow.
    let unit = shapes().map(|(_, _, shape)| shape.unit).fold(0.0, f64::max);
    let mut with_first = vec![0.0; flood.patches.len()];
    let mut against_first = vec![0.0; flood.patches.len()];
    for (f, sign, shape) in shapes() {
        let side = if sign > 0 { &mut with_first } else { &mut against_first };
        side[flood.patch_of_face[f] as usize] += shape.area_in(unit);
    }
    with_first.iter().zip(&against_first).map(|(a, b)| b - a > EQUAL_AREA * (a + b)).collect()
}
