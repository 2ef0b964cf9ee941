//! The data to be written, checked against what the format can hold.

use super::{MeshFile, MeshFormat, rounding};
use crate::error::{Fault, FileError, MeshError};
use crate::id::Face;
use crate::mesh::TriangleMesh;
use crate::polygon::PolygonMesh;
use crate::warning::FileWarning;
use std::collections::BTreeSet;

/// How numbers are stored where a format (PLY, STL) allows both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Little-endian bytes.
    #[default]
    Binary,
    /// Text; every float reads back bit for bit.
    Ascii,
}

#[derive(Clone, Copy, Debug)]
enum Surface<'a> {
    Triangles(&'a TriangleMesh),
    Polygons(&'a PolygonMesh),
}

/// A mesh to write with its associated data, all borrowed. Start from a mesh and set fields as
/// needed.
///
/// ```
/// use eikona_mesh::{TriangleMesh, io::{MeshFormat, MeshOut, read_mesh_bytes, write_mesh_bytes}};
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]])?;
/// let distance = [0.0, 0.5, -0.5];
/// let mut out = MeshOut::from(&mesh);
/// out.vertex_scalars = vec![("distance", &distance)];
/// let mut bytes = Vec::new();
/// write_mesh_bytes(&mut bytes, MeshFormat::Ply, &out)?;
/// let file = read_mesh_bytes(&bytes, MeshFormat::Ply)?;
/// assert_eq!(file.vertex_scalars[1], ("distance".to_string(), distance.to_vec()));
/// # Ok::<(), eikona_mesh::FileError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MeshOut<'a> {
    surface: Surface<'a>,
    /// Names and values, one per vertex.
    pub vertex_scalars: Vec<(&'a str, &'a [f64])>,
    /// Names and values, one per face.
    pub face_scalars: Vec<(&'a str, &'a [f64])>,
    /// Names and vectors, one per face. VTP stores an array of three components, PLY the scalars
    /// `name_0`, `name_1` and `name_2`.
    pub face_vectors: Vec<(&'a str, &'a [[f64; 3]])>,
    /// sRGB red, green, blue, one triple per vertex.
    pub vertex_colours: Option<&'a [[u8; 3]]>,
    /// Texture coordinates u, v, one pair per corner, in the order of the faces and their corners.
    pub corner_uvs: Option<&'a [[f64; 2]]>,
    /// Polylines, as 0-based vertices.
    pub lines: &'a [Vec<u32>],
    /// Binary by default.
    pub encoding: Encoding,
    /// Whether OBJ gets the first vertex scalar as texture coordinate u (v = 0) if there are no
    /// `corner_uvs`; true by default.
    pub obj_scalar_as_texture: bool,
}

impl<'a> From<&'a TriangleMesh> for MeshOut<'a> {
    fn from(mesh: &'a TriangleMesh) -> Self {
        MeshOut::new(Surface::Triangles(mesh))
    }
}

impl<'a> From<&'a PolygonMesh> for MeshOut<'a> {
    fn from(mesh: &'a PolygonMesh) -> Self {
        MeshOut::new(Surface::Polygons(mesh))
    }
}

/// Takes mesh, lines and scalars of the file, but not texture coordinates.
impl<'a> From<&'a MeshFile> for MeshOut<'a> {
    fn from(file: &'a MeshFile) -> Self {
        fn borrowed(scalars: &[(String, Vec<f64>)]) -> Vec<(&str, &[f64])> {
            scalars.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect()
        }
        MeshOut {
            vertex_scalars: borrowed(&file.vertex_scalars),
            face_scalars: borrowed(&file.face_scalars),
            lines: &file.lines,
            ..MeshOut::from(&file.mesh)
        }
    }
}

impl<'a> MeshOut<'a> {
    fn new(surface: Surface<'a>) -> Self {
        MeshOut {
            surface,
            vertex_scalars: Vec::new(),
            face_scalars: Vec::new(),
            face_vectors: Vec::new(),
            vertex_colours: None,
            corner_uvs: None,
            lines: &[],
            encoding: Encoding::default(),
            obj_scalar_as_texture: true,
        }
    }

    pub(super) fn positions(&self) -> &'a [[f64; 3]] {
        match self.surface {
            Surface::Triangles(mesh) => mesh.positions(),
            Surface::Polygons(mesh) => &mesh.positions,
        }
    }
    pub(super) fn face_count(&self) -> usize {
        match self.surface {
            Surface::Triangles(mesh) => mesh.face_count(),
            Surface::Polygons(mesh) => mesh.face_count(),
        }
    }
    pub(super) fn faces(&self) -> impl Iterator<Item = &'a [u32]> {
        let (triangles, polygons) = match self.surface {
            Surface::Triangles(mesh) => (mesh.triangles(), None),
            Surface::Polygons(mesh) => (&[][..], Some(mesh)),
        };
        triangles.iter().map(|t| t.as_slice()).chain(polygons.into_iter().flat_map(PolygonMesh::faces))
    }
    /// Returns the scalar that OBJ stores as texture coordinates.
    pub(super) fn scalar_as_texture(&self) -> Option<(&'a str, &'a [f64])> {
        if self.obj_scalar_as_texture && self.corner_uvs.is_none() {
            self.vertex_scalars.first().copied()
        } else {
            None
        }
    }

    /// Fails if the file would be wrong; returns what the format can not hold, or not precisely.
    pub(super) fn check(&self, format: MeshFormat) -> Result<Vec<FileWarning>, FileError> {
        self.check_lengths()?;
        self.check_indices()?;
        check_names("vertex", self.vertex_scalars.iter().map(|s| s.0.to_string()))?;
        let of_vectors = self.face_vectors.iter().flat_map(|(name, _)| component_names(name));
        check_names("face", self.face_scalars.iter().map(|s| s.0.to_string()).chain(of_vectors))?;
        let glb = matches!(format, MeshFormat::Glb | MeshFormat::Gltf);
        if (format == MeshFormat::Stl || glb)
            && let Some((f, face)) = self.faces().enumerate().find(|(_, face)| face.len() != 3)
        {
            return Err(FileError::Unsupported(format!(
                "face {f} has {} corners, but {format:?} can hold only triangles; triangulate the mesh first",
                face.len()
            )));
        }
        if glb || (format == MeshFormat::Stl && self.encoding == Encoding::Binary) {
            self.check_fits_f32(format)?;
        }
        let mut left_out = Vec::new();
        let mut lost = |there: bool, what: &str| {
            if there {
                left_out.push(FileWarning::NotStored { format, what: what.to_string() });
            }
        };
        use MeshFormat::{Obj, Off, Ply, Stl, Vtp};
        let kept = match format {
            Obj => usize::from(self.scalar_as_texture().is_some()),
            Stl | Off => 0,
            _ => usize::MAX,
        };
        for (name, _) in self.vertex_scalars.iter().skip(kept) {
            lost(true, &format!("the vertex scalar \"{name}\""));
        }
        for (name, _) in self.face_scalars.iter().filter(|_| !matches!(format, Ply | Vtp)) {
            lost(true, &format!("the face scalar \"{name}\""));
        }
        for (name, _) in self.face_vectors.iter().filter(|_| !matches!(format, Ply | Vtp)) {
            lost(true, &format!("the face vectors \"{name}\""));
        }
        lost(format == Stl && self.vertex_colours.is_some(), "colours");
        lost(
            !(glb || matches!(format, Obj | Ply)) && self.corner_uvs.is_some(),
            "texture coordinates of corners",
        );
        lost(matches!(format, Stl | Off) && !self.lines.is_empty(), "lines");
        if glb {
            left_out.extend(rounding::warning(self, rounding::offset(self.positions()), format));
        } else if format == Stl && self.encoding == Encoding::Binary {
            left_out.extend(rounding::warning(self, [0.0; 3], format));
        }
        Ok(left_out)
    }

    fn check_lengths(&self) -> Result<(), MeshError> {
        let (vertices, faces) = (self.positions().len(), self.face_count());
        let check = |what, found, expected| {
            if found == expected { Ok(()) } else { Err(MeshError::WrongLength { what, found, expected }) }
        };
        for (_, values) in &self.vertex_scalars {
            check("values of a vertex scalar", values.len(), vertices)?;
        }
        for (_, values) in &self.face_scalars {
            check("values of a face scalar", values.len(), faces)?;
        }
        for (_, values) in &self.face_vectors {
            check("face vectors", values.len(), faces)?;
        }
        if let Some(colours) = self.vertex_colours {
            check("vertex colours", colours.len(), vertices)?;
        }
        if let Some(uvs) = self.corner_uvs {
            check("texture coordinates of corners", uvs.len(), self.faces().map(<[u32]>::len).sum())?;
        }
        Ok(())
    }

    fn check_indices(&self) -> Result<(), FileError> {
        let vertices = self.positions().len();
        let mut faults = Vec::new();
        for (f, face) in self.faces().enumerate() {
            for &v in face.iter().filter(|&&v| v as usize >= vertices) {
                faults.push(Fault::IndexOutOfRange { face: Face(f as u32), index: i64::from(v), vertices });
            }
        }
        if !faults.is_empty() {
            return Err(MeshError::Invalid(faults).into());
        }
        for (i, line) in self.lines.iter().enumerate() {
            if let Some(v) = line.iter().find(|v| **v as usize >= vertices) {
                return Err(FileError::Unsupported(format!(
                    "line {i} refers to vertex {v}, but there are {vertices} vertices, numbered from 0; correct the index"
                )));
            }
        }
        Ok(())
    }

    fn check_fits_f32(&self, format: MeshFormat) -> Result<(), FileError> {
        let fits = |x: f64| (x as f32).is_finite() || (format == MeshFormat::Stl && !x.is_finite());
        for (v, p) in self.positions().iter().enumerate() {
            if !p.iter().all(|&x| fits(x)) {
                return Err(FileError::Unsupported(format!(
                    "vertex {v} is at {p:?}, which the 32-bit floats of {format:?} can not hold; scale the mesh or write PLY"
                )));
            }
        }
        for (name, values) in self.vertex_scalars.iter().filter(|_| format != MeshFormat::Stl) {
            if let Some(v) = values.iter().position(|x| x.is_finite() && !(*x as f32).is_finite()) {
                return Err(FileError::Unsupported(format!(
                    "scalar \"{name}\" is {} at vertex {v}, which the 32-bit floats of {format:?} can not hold; scale it or write PLY",
                    values[v]
                )));
            }
        }
        Ok(())
    }
}

/// Names of the components of a vector where a format stores only scalars.
pub(super) fn component_names(name: &str) -> [String; 3] {
    [0, 1, 2].map(|k| format!("{name}_{k}"))
}

fn check_names(element: &str, names: impl Iterator<Item = String>) -> Result<(), FileError> {
    let mut seen = BTreeSet::new();
    for name in names {
        if name.is_empty() || !seen.insert(one_word(&name)) {
            return Err(FileError::Unsupported(format!(
                "two {element} scalars are named \"{name}\", or one has no name; give each its own"
            )));
        }
    }
    Ok(())
}

/// Converts a scalar's name for formats that need a single word of plain letters: everything else
/// becomes `_`.
pub(super) fn one_word(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect()
}
