//! Where the vertices and faces of a derived mesh come from.

use crate::error::MeshError;
use crate::field::{FaceField, Field, VertexField};
use crate::id::{ElementId, Face, Vertex};
use crate::point::{SNAP_TOLERANCE, SurfacePoint};

/// Where each vertex and face of a derived mesh comes from in the original one, and what became of
/// those of the original.
///
/// Meshes are derived by triangulation, repairs and cuts. Each of these returns its provenance, and
/// [`then`](Provenance::then) composes several steps. "New" elements are those of the derived mesh.
///
/// * A new vertex lies at an original vertex (at the first one, if several were merged), on an
///   original edge, or in an original face: it is a mean of up to three original vertices.
/// * A new face is an original face or a part of one, its *parent*. New faces follow the order of
///   their parents, so the parts of a face have consecutive numbers.
///
/// The maps of elements that keep their numbers take no memory.
///
/// ```
/// use eikona_mesh::{Face, PolygonMesh, Vertex, VertexField, drop_unreferenced_vertices, weld};
/// // Two squares, the second with its own vertices, and an unused vertex.
/// let mut squares = PolygonMesh::new(vec![
///     [9., 9., 9.],
///     [0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.],
///     [1., 0., 0.], [2., 0., 0.], [2., 1., 0.], [1., 1., 0.],
/// ]);
/// squares.push_face(1..5);
/// squares.push_face(5..9);
/// let (mesh, triangulated) = squares.triangulate()?;
/// let welded = weld(&mesh, 0.0)?;
/// let trimmed = drop_unreferenced_vertices(&welded.mesh);
/// let provenance = triangulated.then(&welded.provenance).then(&trimmed.provenance);
///
/// assert_eq!(provenance.face_parent(Face(2)), Face(1));
/// assert_eq!(provenance.face_parts(Face(1)).collect::<Vec<_>>(), [Face(2), Face(3)]);
/// assert_eq!(provenance.dropped_vertices(), [Vertex(0)]);
/// assert_eq!(provenance.new_vertex(Vertex(5)), Some(Vertex(1)));
/// assert_eq!(provenance.vertex_place(Vertex(1)), Some(Vertex(2).into()));
///
/// let x = VertexField::from(squares.positions.iter().map(|p| p[0]).collect::<Vec<_>>());
/// assert_eq!(provenance.pull_vertices(&x)?.as_slice(), [0., 1., 1., 0., 2., 2.]);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Numbers of original and of new vertices.
    vertex_counts: [usize; 2],
    /// Numbers of original and of new faces.
    face_counts: [usize; 2],
    /// `None` if all vertices keep their numbers.
    vertices: Option<VertexMaps>,
    /// The parent of each new face; `None` if all faces keep their numbers.
    parents: Option<FaceField<Face>>,
    /// The new faces that run against their parents, in increasing order.
    flipped: Vec<Face>,
}

/// Both directions of the map of vertices.
#[derive(Clone, Debug, PartialEq)]
struct VertexMaps {
    /// The new vertex of each original one, if any.
    new: VertexField<Option<Vertex>>,
    /// The place of new vertex `v` is the mean of `terms[starts[v]..starts[v + 1]]`.
    starts: Vec<usize>,
    /// Original vertices with weights of sum 1.
    terms: Vec<(Vertex, f64)>,
}

impl Provenance {
    /// Creates the provenance of a mesh from itself.
    pub fn identity(vertices: usize, faces: usize) -> Provenance {
        Provenance {
            vertex_counts: [vertices; 2],
            face_counts: [faces; 2],
            vertices: None,
            parents: None,
            flipped: Vec::new(),
        }
    }

    /// Sets the new vertex of each original one; `None` drops it. Every new vertex must have one.
    pub fn with_new_vertices(self, new: Vec<Option<Vertex>>) -> Provenance {
        let count = new.iter().flatten().map(|v| v.index() + 1).max().unwrap_or(0);
        let mut first = vec![Vertex(u32::MAX); count];
        for (old, to) in new.iter().enumerate().rev() {
            if let Some(to) = to {
                first[to.index()] = Vertex(old as u32);
            }
        }
        let terms = first.into_iter().map(|v| (v, 1.0)).collect();
        self.with_vertices(VertexMaps { new: new.into(), starts: (0..=count).collect(), terms })
    }

    /// Sets the place of each new vertex on the original mesh. The first of several at an original
    /// vertex becomes the new vertex of that one.
    pub fn with_vertex_places(self, places: &[SurfacePoint]) -> Provenance {
        let mut maps = VertexMaps {
            new: VertexField::constant(self.vertex_counts[0], None),
            starts: vec![0],
            terms: Vec::with_capacity(places.len()),
        };
        for (v, place) in places.iter().enumerate() {
            match *place {
                SurfacePoint::Vertex { vertex } => {
                    maps.terms.push((Vertex(vertex), 1.0));
                    maps.new[Vertex(vertex)].get_or_insert(Vertex(v as u32));
                }
                SurfacePoint::Edge { vertices: [a, b], t } => {
                    maps.terms.extend([(Vertex(a), 1.0 - t), (Vertex(b), t)]);
                }
                SurfacePoint::Face { vertices, bary } => {
                    maps.terms.extend(vertices.map(Vertex).into_iter().zip(bary));
                }
            }
            maps.starts.push(maps.terms.len());
        }
        self.with_vertices(maps)
    }

    fn with_vertices(mut self, maps: VertexMaps) -> Provenance {
        self.vertex_counts[1] = maps.starts.len() - 1;
        let keeps = |(v, new): (Vertex, &Option<Vertex>)| *new == Some(v);
        let is_identity = self.vertex_counts[0] == self.vertex_counts[1] && maps.new.iter().all(keeps);
        self.vertices = (!is_identity).then_some(maps);
        self
    }

    /// Sets the parent of each new face. They must be in increasing order.
    pub fn with_face_parents(mut self, parents: Vec<Face>) -> Provenance {
        debug_assert!(parents.is_sorted(), "new faces follow the order of their parents");
        let parents = FaceField::from(parents);
        self.face_counts[1] = parents.len();
        let is_identity =
            self.face_counts[0] == self.face_counts[1] && parents.iter().all(|(f, parent)| f == *parent);
        self.parents = (!is_identity).then_some(parents);
        self
    }

    /// Sets the new faces that run against their parents, in increasing order.
    pub fn with_flipped_faces(mut self, flipped: Vec<Face>) -> Provenance {
        debug_assert!(flipped.is_sorted());
        self.flipped = flipped;
        self
    }

    /// Composes this provenance with that of a mesh derived from the new one. Associative.
    ///
    /// # Panics
    /// If `next` has other numbers of original vertices and faces than this has new ones.
    ///
    /// # Cost
    /// O(V + F); no cost for elements that keep their numbers in both steps.
    pub fn then(&self, next: &Provenance) -> Provenance {
        let ends = (self.vertex_counts[1], self.face_counts[1]);
        assert_eq!(ends, (next.vertex_counts[0], next.face_counts[0]), "the steps do not meet in one mesh");
        let composed = Provenance::identity(self.vertex_counts[0], self.face_counts[0]);
        let composed = match (&self.vertices, &next.vertices) {
            (None, None) => composed,
            (Some(maps), None) | (None, Some(maps)) => composed.with_vertices(maps.clone()),
            (Some(first), Some(second)) => composed.with_vertices(first.then(second)),
        };
        let composed = match (&self.parents, &next.parents) {
            (None, None) => composed,
            (Some(parents), None) | (None, Some(parents)) => {
                composed.with_face_parents(parents.as_slice().to_vec())
            }
            (Some(first), Some(second)) => {
                composed.with_face_parents(second.as_slice().iter().map(|&f| first[f]).collect())
            }
        };
        if self.flipped.is_empty() && next.flipped.is_empty() {
            return composed;
        }
        let is_flipped = |f: &Face| next.is_flipped(*f) != self.is_flipped(next.face_parent(*f));
        composed.with_flipped_faces((0..next.face_counts[1] as u32).map(Face).filter(is_flipped).collect())
    }

    /// Returns whether all vertices and faces keep their numbers and orientations.
    pub fn is_identity(&self) -> bool {
        self.keeps_vertices() && self.keeps_faces() && self.flipped.is_empty()
    }

    /// Returns whether each new vertex is the original one of the same number.
    pub fn keeps_vertices(&self) -> bool {
        self.vertices.is_none()
    }

    /// Returns whether each new face is the original one of the same number, flipped or not.
    pub fn keeps_faces(&self) -> bool {
        self.parents.is_none()
    }

    /// Returns the original vertices of which a new one is the mean, with their weights.
    pub fn vertex_weights(&self, new: Vertex) -> impl Iterator<Item = (Vertex, f64)> {
        let terms = self.vertices.as_ref().map(|maps| maps.terms(new));
        let itself = terms.is_none().then_some((new, 1.0));
        itself.into_iter().chain(terms.into_iter().flatten().copied())
    }

    /// Returns the weights of three original vertices in the place of a new one: its barycentric
    /// coordinates if they are the corners of a face that contains it.
    pub fn weights_in(&self, new: Vertex, corners: [Vertex; 3]) -> [f64; 3] {
        corners.map(|c| self.vertex_weights(new).find(|term| term.0 == c).map_or(0.0, |term| term.1))
    }

    /// Returns the place of a new vertex on the original mesh. The vertices that it names were
    /// joined by an edge or face when the new vertex was inserted.
    ///
    /// `None` for a vertex that is the mean of more than three original ones: it was inserted
    /// between vertices of an earlier cut that were welded or stitched together. `None` also if
    /// there is no such vertex.
    pub fn vertex_place(&self, new: Vertex) -> Option<SurfacePoint> {
        if new.index() >= self.vertex_counts[1] {
            return None;
        }
        let Some(maps) = &self.vertices else { return Some(new.into()) };
        match *maps.terms(new) {
            [(a, _)] => Some(a.into()),
            [(a, _), (b, t)] => Some(SurfacePoint::Edge { vertices: [a.0, b.0], t }),
            [(a, x), (b, y), (c, z)] => {
                Some(SurfacePoint::Face { vertices: [a.0, b.0, c.0], bary: [x, y, z] })
            }
            _ => None,
        }
    }

    /// Returns the original vertex at which a new one lies; `None` inside edges and faces.
    pub fn vertex_parent(&self, new: Vertex) -> Option<Vertex> {
        match self.vertex_place(new)? {
            SurfacePoint::Vertex { vertex } => Some(Vertex(vertex)),
            _ => None,
        }
    }

    /// Returns the new vertex of an original one; `None` if it was dropped or does not exist.
    pub fn new_vertex(&self, original: Vertex) -> Option<Vertex> {
        match &self.vertices {
            None => (original.index() < self.vertex_counts[0]).then_some(original),
            Some(maps) => maps.new.get(original).copied().flatten(),
        }
    }

    /// Returns the original vertices that were dropped, in increasing order.
    pub fn dropped_vertices(&self) -> Vec<Vertex> {
        let new = self.vertices.iter().flat_map(|maps| maps.new.iter());
        new.filter(|(_, new)| new.is_none()).map(|(v, _)| v).collect()
    }

    /// Renames the vertices of a point. An edge whose ends were merged becomes a vertex; vertices
    /// that were dropped or do not exist keep their numbers.
    ///
    /// This suits steps that keep edges and faces in one piece. See
    /// [`Stitched::point`](crate::Stitched::point) for stitching.
    pub fn rename(&self, point: SurfacePoint) -> SurfacePoint {
        let new = |v: u32| self.new_vertex(Vertex(v)).map_or(v, |v| v.0);
        match point {
            SurfacePoint::Vertex { vertex } => SurfacePoint::Vertex { vertex: new(vertex) },
            SurfacePoint::Edge { vertices, t } => match vertices.map(new) {
                [a, b] if a == b => SurfacePoint::Vertex { vertex: a },
                vertices => SurfacePoint::Edge { vertices, t },
            },
            SurfacePoint::Face { vertices, bary } => SurfacePoint::Face { vertices: vertices.map(new), bary },
        }
    }

    /// Returns the original face that contains a new one.
    #[inline]
    pub fn face_parent(&self, new: Face) -> Face {
        self.parents.as_ref().map_or(new, |parents| parents[new])
    }

    /// Returns the parents of all new faces, in order.
    pub fn face_parents(&self) -> impl ExactSizeIterator<Item = Face> {
        (0..self.face_counts[1] as u32).map(|f| self.face_parent(Face(f)))
    }

    /// Returns the new faces within an original one: none if it was dropped or does not exist,
    /// several if it was divided.
    ///
    /// # Cost
    /// O(log F).
    pub fn face_parts(&self, original: Face) -> impl ExactSizeIterator<Item = Face> + Clone + use<> {
        let (first, count) = match &self.parents {
            None => (original.index(), usize::from(original.index() < self.face_counts[0])),
            Some(parents) => {
                let first = parents.as_slice().partition_point(|parent| *parent < original);
                (first, parents.as_slice()[first..].partition_point(|parent| *parent == original))
            }
        };
        (first as u32..(first + count) as u32).map(Face)
    }

    /// Returns the original faces that were dropped, in increasing order.
    pub fn dropped_faces(&self) -> Vec<Face> {
        let Some(parents) = &self.parents else { return Vec::new() };
        let mut is_dropped = FaceField::constant(self.face_counts[0], true);
        parents.as_slice().iter().for_each(|parent| is_dropped[*parent] = false);
        is_dropped.iter().filter(|(_, dropped)| **dropped).map(|(f, _)| f).collect()
    }

    /// Returns whether a new face runs against its parent. A flipped triangle `a b c` is `a c b`.
    pub fn is_flipped(&self, new: Face) -> bool {
        self.flipped.binary_search(&new).is_ok()
    }

    /// Returns the new faces that run against their parents, in increasing order.
    pub fn flipped_faces(&self) -> &[Face] {
        &self.flipped
    }

    /// Transfers values at original vertices to the new ones, linearly on edges and faces.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn pull_vertices(&self, field: &VertexField<f64>) -> Result<VertexField<f64>, MeshError> {
        check_length("vertex values", field, self.vertex_counts[0])?;
        let Some(maps) = &self.vertices else { return Ok(field.clone()) };
        let value = |v: usize| match maps.terms(Vertex(v as u32)) {
            [(original, _)] => field[*original],
            terms => terms.iter().map(|(original, weight)| weight * field[*original]).sum(),
        };
        Ok((0..self.vertex_counts[1]).map(value).collect::<Vec<_>>().into())
    }

    /// Transfers values on original faces to the new ones.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn pull_faces<T: Clone>(&self, field: &FaceField<T>) -> Result<FaceField<T>, MeshError> {
        check_length("face values", field, self.face_counts[0])?;
        Ok(self.face_parents().map(|parent| field[parent].clone()).collect::<Vec<_>>().into())
    }

    /// Transfers values at new vertices back to the original ones: each has the value of its
    /// [new vertex](Provenance::new_vertex), if any.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn push_vertices<T: Clone>(
        &self,
        field: &VertexField<T>,
    ) -> Result<VertexField<Option<T>>, MeshError> {
        check_length("vertex values", field, self.vertex_counts[1])?;
        let value = |v: usize| self.new_vertex(Vertex(v as u32)).map(|new| field[new].clone());
        Ok((0..self.vertex_counts[0]).map(value).collect::<Vec<_>>().into())
    }

    /// Transfers values on new faces back to the original ones: `join` combines the values on the
    /// parts of each face, given the first part. Dropped faces have no parts.
    ///
    /// ```
    /// use eikona_mesh::{FaceField, PolygonMesh};
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    /// let mut square = PolygonMesh::new(corners.to_vec());
    /// square.push_face(0..4);
    /// let (_, provenance) = square.triangulate()?;
    /// let areas = FaceField::from(vec![0.5, 0.5]);
    /// let whole = provenance.push_faces(&areas, |_, parts| parts.iter().sum::<f64>())?;
    /// assert_eq!(whole.as_slice(), [1.0]);
    /// # Ok::<(), eikona_mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn push_faces<T, U>(
        &self,
        field: &FaceField<T>,
        mut join: impl FnMut(Face, &[T]) -> U,
    ) -> Result<FaceField<U>, MeshError> {
        check_length("face values", field, self.face_counts[1])?;
        let mut rest = field.as_slice();
        let mut first = 0;
        let mut joined = Vec::with_capacity(self.face_counts[0]);
        for face in (0..self.face_counts[0] as u32).map(Face) {
            let count = match &self.parents {
                None => 1,
                Some(parents) => parents.as_slice()[first..].iter().take_while(|f| **f == face).count(),
            };
            let (parts, others) = rest.split_at(count);
            joined.push(join(Face(first as u32), parts));
            rest = others;
            first += count;
        }
        Ok(joined.into())
    }
}

impl VertexMaps {
    fn terms(&self, new: Vertex) -> &[(Vertex, f64)] {
        &self.terms[self.starts[new.index()]..self.starts[new.index() + 1]]
    }

    fn then(&self, next: &VertexMaps) -> VertexMaps {
        let new: Vec<_> = self.new.as_slice().iter().map(|v| v.and_then(|v| next.new[v])).collect();
        let mut composed = VertexMaps { new: new.into(), starts: vec![0], terms: Vec::new() };
        for v in 0..next.starts.len() - 1 {
            match next.terms(Vertex(v as u32)) {
                [(middle, _)] => composed.terms.extend(self.terms(*middle)),
                terms => composed.terms.extend(self.mean(terms)),
            }
            composed.starts.push(composed.terms.len());
        }
        composed
    }

    /// Returns a mean of new vertices as one of original vertices. Weights of up to
    /// [`SNAP_TOLERANCE`] count as zero.
    fn mean(&self, terms: &[(Vertex, f64)]) -> Vec<(Vertex, f64)> {
        let mut mean: Vec<(Vertex, f64)> = Vec::new();
        for (middle, share) in terms {
            for (v, weight) in self.terms(*middle) {
                match mean.iter_mut().find(|term| term.0 == *v) {
                    Some(term) => term.1 += share * weight,
                    None => mean.push((*v, share * weight)),
                }
            }
        }
        mean.retain(|term| term.1 > SNAP_TOLERANCE);
        let sum: f64 = mean.iter().map(|term| term.1).sum();
        mean.iter_mut().for_each(|term| term.1 /= sum);
        mean
    }
}

fn check_length<I: ElementId, T>(
    what: &'static str,
    field: &Field<I, T>,
    expected: usize,
) -> Result<(), MeshError> {
    let found = field.len();
    if found == expected { Ok(()) } else { Err(MeshError::WrongLength { what, found, expected }) }
}
