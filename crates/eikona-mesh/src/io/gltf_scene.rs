//! The meshes of a glTF scene, placed by their nodes and joined into one.

use super::MeshFile;
use super::faces::Faces;
use super::gltf::{GLTF, Node, Primitive, Root};
use super::gltf_buffers::Data;
use crate::error::{FileError, MeshError};
use crate::warning::FileWarning;
use std::collections::{BTreeMap, BTreeSet};

/// Reads all meshes of the scene.
pub(super) fn read(root: &Root, data: &Data) -> Result<MeshFile, FileError> {
    let mut scene = Collected::default();
    for (node, mesh, place) in placed_meshes(root)? {
        scene.add_mesh(root, data, node, mesh, &place)?;
    }
    scene.finish()
}

/// An affine map: the columns of its linear part, then its translation.
type Place = [[f64; 3]; 4];

const IDENTITY: Place = [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0., 0., 0.]];

fn apply(m: &Place, p: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|r| m[0][r] * p[0] + m[1][r] * p[1] + m[2][r] * p[2] + m[3][r])
}

/// Composes two maps: first `b`, then `a`.
fn compose(a: &Place, b: &Place) -> Place {
    let column = |k: usize| [0, 1, 2].map(|r| a[0][r] * b[k][0] + a[1][r] * b[k][1] + a[2][r] * b[k][2]);
    [column(0), column(1), column(2), apply(a, b[3])]
}

fn mirrors(m: &Place) -> bool {
    let [a, b, c, _] = m;
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2] < 0.0
}

impl Node {
    fn place(&self) -> Place {
        if let Some(m) = &self.matrix {
            return [[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]], [m[12], m[13], m[14]]];
        }
        let [x, y, z, w] = self.rotation.unwrap_or([0., 0., 0., 1.]);
        let s = self.scale.unwrap_or([1.; 3]);
        [
            [1. - 2. * (y * y + z * z), 2. * (x * y + z * w), 2. * (x * z - y * w)].map(|r| s[0] * r),
            [2. * (x * y - z * w), 1. - 2. * (x * x + z * z), 2. * (y * z + x * w)].map(|r| s[1] * r),
            [2. * (x * z + y * w), 2. * (y * z - x * w), 1. - 2. * (x * x + y * y)].map(|r| s[2] * r),
            self.translation.unwrap_or([0.; 3]),
        ]
    }
}

fn missing(place: String, what: &str, index: usize, count: usize) -> FileError {
    FileError::syntax(
        GLTF,
        place,
        format!("{what} {index} does not exist: there are {count}, numbered from 0"),
    )
}

/// Returns node, mesh and transform of every mesh in the scene, depth first. Without nodes, returns
/// every mesh untransformed.
fn placed_meshes(root: &Root) -> Result<Vec<(usize, usize, Place)>, FileError> {
    if root.nodes.is_empty() {
        return Ok((0..root.meshes.len()).map(|mesh| (0, mesh, IDENTITY)).collect());
    }
    let starts: Vec<usize> = match root.scenes.get(root.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.clone(),
        None => {
            let mut is_child = vec![false; root.nodes.len()];
            for &child in root.nodes.iter().flat_map(|n| &n.children) {
                if let Some(flag) = is_child.get_mut(child) {
                    *flag = true;
                }
            }
            (0..root.nodes.len()).filter(|&n| !is_child[n]).collect()
        }
    };
    let mut seen = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    let mut stack: Vec<(usize, Place)> = starts.iter().rev().map(|&n| (n, IDENTITY)).collect();
    while let Some((n, parent)) = stack.pop() {
        let node = root.nodes.get(n).ok_or_else(|| missing("scene".into(), "node", n, root.nodes.len()))?;
        if std::mem::replace(&mut seen[n], true) {
            let problem = "it occurs twice in the scene; a node can have only one parent";
            return Err(FileError::syntax(GLTF, format!("node {n}"), problem));
        }
        let place = compose(&parent, &node.place());
        if let Some(mesh) = node.mesh {
            // "Only the joint transforms are applied to the skinned mesh; the transform of the
            // skinned mesh node MUST be ignored" (glTF 2.0, 3.7.3.3).
            placed.push((n, mesh, if node.skin.is_some() { IDENTITY } else { place }));
        }
        stack.extend(node.children.iter().rev().map(|&child| (child, place)));
    }
    Ok(placed)
}

/// Fails if a primitive's data exists only in compressed form.
fn refuse_compression(data: &Data, primitive: &Primitive, name: &str) -> Result<(), FileError> {
    const DRACO: &str = "KHR_draco_mesh_compression";
    let has_no_data = |&accessor: &usize| data.is_empty(accessor);
    if primitive.extensions.contains_key(DRACO)
        && primitive.attributes.values().chain(&primitive.indices).any(has_no_data)
    {
        return Err(FileError::Unsupported(format!(
            "{name} is compressed with {DRACO}, which is not supported; export the file without compression"
        )));
    }
    Ok(())
}

#[derive(Default)]
struct Collected {
    positions: Vec<[f64; 3]>,
    faces: Faces,
    lines: Vec<Vec<u32>>,
    scalars: Vec<(String, Vec<f64>)>,
    /// Names of scalars that some primitives lack.
    incomplete: BTreeSet<String>,
    stitches: usize,
    /// Nodes with skins, and nodes with instances of their mesh.
    skinned: Vec<usize>,
    instanced: Vec<usize>,
    /// Meshes with morph targets.
    morphed: BTreeSet<usize>,
}

impl Collected {
    fn add_mesh(
        &mut self,
        root: &Root,
        data: &Data,
        node: usize,
        m: usize,
        place: &Place,
    ) -> Result<(), FileError> {
        let count = root.meshes.len();
        let mesh = root.meshes.get(m).ok_or_else(|| missing(format!("node {node}"), "mesh", m, count))?;
        if let Some(n) = root.nodes.get(node) {
            self.skinned.extend(n.skin.map(|_| node));
            self.instanced.extend(n.extensions.contains_key("EXT_mesh_gpu_instancing").then_some(node));
        }
        // First vertex and number of vertices of the appended data, by the accessors it came from.
        let mut appended: BTreeMap<Vec<(&str, usize)>, (usize, usize)> = BTreeMap::new();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let name = format!("mesh {m}, primitive {p}");
            refuse_compression(data, primitive, &name)?;
            if !primitive.targets.is_empty() {
                self.morphed.insert(m);
            }
            let kept = primitive.attributes.iter().filter(|(k, _)| *k == "POSITION" || k.starts_with('_'));
            let key: Vec<(&str, usize)> = kept.map(|(k, &a)| (k.as_str(), a)).collect();
            let (first, vertices) = match appended.get(&key) {
                Some(&known) => known,
                None => {
                    let range = self.add_vertices(data, &name, &key, place)?;
                    appended.insert(key, range);
                    range
                }
            };
            let indices = match primitive.indices {
                Some(accessor) => data.indices(accessor, &name)?,
                None => (0..vertices as i64).collect(),
            };
            if let Some(index) = indices.iter().find(|&&i| i >= vertices as i64) {
                let problem = format!(
                    "index {index} is out of range: the primitive has {vertices} vertices, numbered from 0"
                );
                return Err(FileError::syntax(GLTF, name, problem));
            }
            let indices: Vec<i64> = indices.into_iter().map(|i| i + first as i64).collect();
            self.add_elements(primitive.mode.unwrap_or(4), &indices, &name, mirrors(place))?;
        }
        Ok(())
    }

    fn add_vertices(
        &mut self,
        data: &Data,
        name: &str,
        attributes: &[(&str, usize)],
        place: &Place,
    ) -> Result<(usize, usize), FileError> {
        let first = self.positions.len();
        let Some(&(_, accessor)) = attributes.iter().find(|(k, _)| *k == "POSITION") else {
            return Err(FileError::syntax(GLTF, name, "it has no attribute POSITION"));
        };
        let positions = data.floats::<3>(accessor, name)?;
        let vertices = positions.len();
        if first + vertices >= u32::MAX as usize {
            return Err(MeshError::TooLarge { vertices: first + vertices, faces: self.faces.count() }.into());
        }
        if *place == IDENTITY {
            self.positions.extend(positions);
        } else {
            self.positions.extend(positions.into_iter().map(|p| apply(place, p)));
        }
        for &(attribute, accessor) in attributes.iter().filter(|(k, _)| *k != "POSITION") {
            if !data.is_scalar(accessor) {
                continue;
            }
            let count = data.count(accessor);
            if count != vertices {
                let problem = format!("{attribute} has {count} values for {vertices} vertices");
                return Err(FileError::syntax(GLTF, name, problem));
            }
            let values = data.floats::<1>(accessor, name)?;
            let scalar = attribute.strip_prefix('_').unwrap_or(attribute);
            let known = self.scalars.iter().position(|(n, _)| n == scalar);
            let column = known.unwrap_or_else(|| {
                self.scalars.push((scalar.to_string(), Vec::new()));
                self.scalars.len() - 1
            });
            let column = &mut self.scalars[column].1;
            if column.len() < first {
                self.incomplete.insert(scalar.to_string());
            }
            column.resize(first, f64::NAN);
            column.extend(values.into_iter().flatten());
        }
        Ok((first, vertices))
    }

    fn add_elements(
        &mut self,
        mode: u32,
        indices: &[i64],
        name: &str,
        mirrored: bool,
    ) -> Result<(), FileError> {
        let triangle = |a: i64, b: i64, c: i64| if mirrored { [a, c, b] } else { [a, b, c] };
        let line = |nodes: &[i64]| nodes.iter().map(|&i| i as u32).collect::<Vec<u32>>();
        let whole = |n: usize, what: &str| {
            if indices.len().is_multiple_of(n) {
                return Ok(());
            }
            Err(FileError::syntax(GLTF, name, format!("{} indices do not make whole {what}", indices.len())))
        };
        match mode {
            0 => {}
            1 => {
                whole(2, "lines")?;
                self.lines.extend(indices.chunks_exact(2).map(line));
            }
            2 => self.lines.push(indices.iter().chain(indices.first()).map(|&i| i as u32).collect()),
            3 => self.lines.push(line(indices)),
            4 => {
                whole(3, "triangles")?;
                for t in indices.chunks_exact(3) {
                    self.faces.push(&triangle(t[0], t[1], t[2]))?;
                }
            }
            5 => {
                // Doubling the first vertex reverses every triangle of the strip and adds one
                // stitch.
                let doubled = if mirrored { indices.first() } else { None };
                let strip: Vec<i64> = doubled.into_iter().chain(indices).copied().collect();
                let stitches = self.faces.push_strip(&strip)?;
                self.stitches += stitches.saturating_sub(usize::from(mirrored));
            }
            6 => {
                let Some((&hub, rim)) = indices.split_first() else { return Ok(()) };
                for side in rim.windows(2) {
                    self.faces.push(&triangle(hub, side[0], side[1]))?;
                }
            }
            _ => {
                let problem = format!("unknown mode {mode}; expected 0 to 6");
                return Err(FileError::syntax(GLTF, name, problem));
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<MeshFile, FileError> {
        let vertices = self.positions.len();
        let mut warnings = Vec::new();
        for (name, values) in &mut self.scalars {
            if values.len() < vertices || self.incomplete.contains(name) {
                let field = format!("_{name}");
                warnings.push(FileWarning::MissingValues { field, count: None });
            }
            values.resize(vertices, f64::NAN);
        }
        if self.stitches > 0 {
            warnings.push(FileWarning::StripJoints { count: self.stitches });
        }
        if vertices == 0 {
            warnings.push(FileWarning::NoMesh);
        }
        if let Some(&first_node) = self.skinned.first() {
            warnings.push(FileWarning::SkinnedMeshes { count: self.skinned.len(), first_node });
        }
        if let Some(&first_mesh) = self.morphed.first() {
            warnings.push(FileWarning::MorphTargets { count: self.morphed.len(), first_mesh });
        }
        if let Some(&first_node) = self.instanced.first() {
            warnings.push(FileWarning::Instances { count: self.instanced.len(), first_node });
        }
        let mesh = self.faces.finish(self.positions)?;
        Ok(MeshFile {
            mesh,
            points: Vec::new(),
            lines: self.lines,
            vertex_scalars: self.scalars,
            face_scalars: Vec::new(),
            corner_uvs: None,
            warnings,
        })
    }
}
