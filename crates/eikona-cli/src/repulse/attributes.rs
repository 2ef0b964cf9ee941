//! Data of the input mesh that follow the surface: colours, values and texture coordinates.

use crate::input::MeshInput;
use crate::session::Session;
use crate::warned::Warned;
use eikona::remesh::Places;
use eikona_mesh::io::MeshOut;
use eikona_mesh::{FaceField, TriangleMesh, Vertex};

/// Data on the elements of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// sRGB from 0 to 255, one triple per vertex.
    colours: Option<Vec<[f64; 3]>>,
    /// Names and values, one per vertex.
    vertex_scalars: Vec<(String, Vec<f64>)>,
    /// Names and values, one per face.
    face_scalars: Vec<(String, Vec<f64>)>,
    /// Texture coordinates, one triple of pairs per face.
    corner_uvs: Option<Vec<[[f64; 2]; 3]>>,
}

const CHANNELS: [&str; 3] = ["red", "green", "blue"];
/// Normals of the input are wrong once the surface has moved.
const NORMALS: [&str; 6] = ["nx", "ny", "nz", "Normals_0", "Normals_1", "Normals_2"];
/// The colour of vertices that have none.
const GREY: f64 = 200.0;

impl Attributes {
    /// Takes the data of a mesh file, without normals.
    pub fn of(input: &MeshInput, session: &mut Session) -> Attributes {
        let file = &input.file;
        let vertex = file.vertex_scalars.iter().filter(|(name, _)| !NORMALS.contains(&name.as_str()));
        let mut vertex_scalars: Vec<(String, Vec<f64>)> =
            vertex.map(|(name, values)| (name.clone(), input.vertex_values(values))).collect();
        let colours = take_colours(&mut vertex_scalars);
        let face_values = |values: &[f64]| {
            let pulled = input.provenance.pull_faces(&FaceField::from(values.to_vec()));
            pulled.expect("readers give one value per face").into_vec()
        };
        let face = file.face_scalars.iter().filter(|(name, _)| !NORMALS.contains(&name.as_str()));
        let face_scalars = face.map(|(name, values)| (name.clone(), face_values(values))).collect();
        let corner_uvs = corner_uvs(input);
        if file.corner_uvs.is_some() && corner_uvs.is_none() {
            let sentence =
                "texture coordinates cannot follow faces that were split by --stitch; they are left out";
            session.warn(Warned::new("texture_coordinates_lost", sentence).about(input.path.display()));
        }
        Attributes { colours, vertex_scalars, face_scalars, corner_uvs }
    }

    /// Joins those of several meshes, given with their numbers of vertices and faces. Where a mesh
    /// lacks what another one has, vertices are grey, values NaN, and texture coordinates 0.
    pub fn joined(parts: Vec<(Attributes, usize, usize)>, session: &mut Session) -> Attributes {
        let mut joined = Attributes {
            colours: parts.iter().any(|(part, ..)| part.colours.is_some()).then(Vec::new),
            corner_uvs: parts.iter().any(|(part, ..)| part.corner_uvs.is_some()).then(Vec::new),
            vertex_scalars: names_of(parts.iter().map(|(part, ..)| &part.vertex_scalars)),
            face_scalars: names_of(parts.iter().map(|(part, ..)| &part.face_scalars)),
        };
        for (number, (part, vertices, faces)) in parts.iter().enumerate() {
            let mut missing = Vec::new();
            if let Some(all) = &mut joined.colours {
                missing.extend(part.colours.is_none().then_some("colours (grey there)"));
                append(all, part.colours.as_deref(), *vertices, [GREY; 3]);
            }
            if let Some(all) = &mut joined.corner_uvs {
                missing.extend(part.corner_uvs.is_none().then_some("texture coordinates (0 there)"));
                append(all, part.corner_uvs.as_deref(), *faces, [[0.0; 2]; 3]);
            }
            let scalars = [
                (&mut joined.vertex_scalars, &part.vertex_scalars, *vertices),
                (&mut joined.face_scalars, &part.face_scalars, *faces),
            ];
            for (all, own, count) in scalars {
                for (name, all) in all {
                    let values = own.iter().find(|(other, _)| other == name).map(|(_, values)| &values[..]);
                    missing.extend(values.is_none().then_some("values (NaN there)"));
                    append(all, values, count, f64::NAN);
                }
            }
            missing.dedup();
            if !missing.is_empty() {
                session.note(&format!("mesh {} has no {}, but others have", number + 1, missing.join(", ")));
            }
        }
        joined
    }

    /// Returns the data of a surface whose vertices lie at places of the start. Values at vertices
    /// and corners are interpolated; faces take those of the face at their middle.
    pub fn pulled(&self, places: &Places, start: &TriangleMesh, faces: &[[u32; 3]]) -> Attributes {
        let vertex = |(name, values): &(String, Vec<f64>)| {
            let values: Vec<[f64; 1]> = values.iter().map(|x| [*x]).collect();
            let pulled = places.pull_vertices(start, &values);
            (name.clone(), pulled.into_iter().flatten().collect())
        };
        let parents = match self.face_scalars.is_empty() {
            true => Vec::new(),
            false => places.parents(start, faces),
        };
        let face = |(name, values): &(String, Vec<f64>)| {
            (name.clone(), parents.iter().map(|f| values[f.index()]).collect())
        };
        Attributes {
            colours: self.colours.as_ref().map(|colours| places.pull_vertices(start, colours)),
            vertex_scalars: self.vertex_scalars.iter().map(vertex).collect(),
            face_scalars: self.face_scalars.iter().map(face).collect(),
            corner_uvs: self.corner_uvs.as_ref().map(|uvs| places.pull_corners(start, faces, uvs)),
        }
    }

    /// Returns the colours in the form in which files have them.
    pub fn colours(&self) -> Option<Vec<[u8; 3]>> {
        let rounded = |x: f64| x.round().clamp(0.0, 255.0) as u8;
        self.colours.as_ref().map(|colours| colours.iter().map(|colour| colour.map(rounded)).collect())
    }

    /// Returns what is written: the mesh with these data, and its colours.
    pub fn out<'a>(&'a self, mesh: &'a TriangleMesh, colours: Option<&'a [[u8; 3]]>) -> MeshOut<'a> {
        fn borrowed(scalars: &[(String, Vec<f64>)]) -> Vec<(&str, &[f64])> {
            scalars.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect()
        }
        let mut out = MeshOut::from(mesh);
        out.vertex_colours = colours;
        out.vertex_scalars = borrowed(&self.vertex_scalars);
        out.face_scalars = borrowed(&self.face_scalars);
        out.corner_uvs = self.corner_uvs.as_ref().map(|uvs| uvs.as_flattened());
        out
    }

    /// Returns what the data are called.
    pub fn names(&self) -> Vec<&str> {
        let colours = self.colours.iter().map(|_| "colours");
        let scalars = self.vertex_scalars.iter().chain(&self.face_scalars).map(|(name, _)| name.as_str());
        let uvs = self.corner_uvs.iter().map(|_| "texture coordinates");
        colours.chain(scalars).chain(uvs).collect()
    }
}

/// Takes the colours out of the values. They are 0 to 1 in OBJ files, mostly 0 to 255 elsewhere.
fn take_colours(scalars: &mut Vec<(String, Vec<f64>)>) -> Option<Vec<[f64; 3]>> {
    let at = |name: &str| scalars.iter().position(|(other, _)| other == name);
    let [red, green, blue] = CHANNELS.map(at);
    let channels = [red?, green?, blue?].map(|k| scalars[k].1.clone());
    let most = channels.iter().flatten().copied().fold(0.0, f64::max);
    let factor = if most <= 1.0 { 255.0 } else { 1.0 };
    let value = |x: f64| if x.is_finite() { factor * x } else { GREY };
    let colours = (0..channels[0].len()).map(|v| [0, 1, 2].map(|k| value(channels[k][v])));
    let colours = colours.collect();
    scalars.retain(|(name, _)| !CHANNELS.contains(&name.as_str()));
    Some(colours)
}

/// The texture coordinates of the triangles. `None` if there are none, or a triangle has corners
/// that its polygon had not.
fn corner_uvs(input: &MeshInput) -> Option<Vec<[[f64; 2]; 3]>> {
    let uvs = input.file.corner_uvs.as_ref()?;
    let polygons = &input.file.mesh;
    let mut starts = vec![0];
    polygons.faces().for_each(|corners| starts.push(starts[starts.len() - 1] + corners.len()));
    let new = |v: &u32| input.provenance.new_vertex(Vertex(*v));
    let of_face = |f| {
        let parent = input.provenance.face_parent(f).index();
        let mut found = [[0.0; 2]; 3];
        for (uv, v) in found.iter_mut().zip(input.mesh.face_vertices(f)) {
            let corner = polygons.face(parent).iter().position(|old| new(old) == Some(v))?;
            *uv = uvs[starts[parent] + corner];
        }
        Some(found)
    };
    input.mesh.faces().map(of_face).collect()
}

/// The names of the values that any of several meshes has, without values.
fn names_of<'a>(all: impl Iterator<Item = &'a Vec<(String, Vec<f64>)>>) -> Vec<(String, Vec<f64>)> {
    let mut names: Vec<(String, Vec<f64>)> = Vec::new();
    for (name, _) in all.flatten() {
        if !names.iter().any(|(other, _)| other == name) {
            names.push((name.clone(), Vec::new()));
        }
    }
    names
}

fn append<T: Copy>(all: &mut Vec<T>, part: Option<&[T]>, count: usize, missing: T) {
    match part {
        Some(part) => all.extend_from_slice(part),
        None => all.extend(std::iter::repeat_n(missing, count)),
    }
}
