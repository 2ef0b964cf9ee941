//! glTF 2.0 animations: one mesh with a morph target per frame.

use super::atomic::{StagedFile, stage_file};
use super::gltf_write::{Parts, bounds, write_glb_head};
use super::{MeshFormat, MeshOut};
use crate::error::{FileError, MeshError};
use crate::warning::FileWarning;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::Path;

type Vec3 = [f64; 3];

/// A surface that deforms, for [`stage_animation`].
pub struct Animation<'a> {
    /// The first frame, with data that stay as they are. Lines are not written.
    pub first: MeshOut<'a>,
    /// The number of frames, the first included.
    pub frame_count: usize,
    /// Frames per second.
    pub frame_rate: f64,
}

/// Writes a `.glb` with the first frame as a mesh, and the displacement of positions and normals
/// towards each later frame as a morph target. Its animation shows a frame every `1 / frame_rate`
/// seconds, and interpolates positions linearly in between. The file gets its name from
/// [`publish_files`](super::publish_files). Also returns what it cannot hold.
///
/// `frame` returns the positions of a later frame, from 1, one per vertex of the first. It is
/// called twice per frame, since the file begins with the bounds of all, and memory holds one frame
/// at a time.
///
/// # Errors
/// Those of [`stage_mesh`](super::stage_mesh) for GLB and those of `frame`;
/// [`FileError::Unsupported`] if there are no vertices, the rate is not positive, or the file would
/// exceed 4 GiB (it takes 24 bytes per vertex and frame); [`FileError::Mesh`] if a frame has
/// another number of vertices.
///
/// ```
/// use eikona_mesh::io::{Animation, MeshOut, publish_files, stage_animation};
/// use eikona_mesh::shapes;
/// let sphere = shapes::icosphere(1)?;
/// let animation = Animation { first: MeshOut::from(&sphere), frame_count: 3, frame_rate: 2.0 };
/// let path = std::env::temp_dir().join("eikona-doc-stage-animation.glb");
/// let grown = |k: usize| {
///     sphere.positions().iter().map(|p| p.map(|x| x * (1.0 + k as f64))).collect()
/// };
/// let (file, _) = stage_animation(&path, &animation, &mut |k| Ok(grown(k)))?;
/// publish_files(vec![file])?;
/// let bytes = std::fs::read(&path).unwrap();
/// assert!(bytes.len() > 2 * 24 * sphere.vertex_count() && bytes.starts_with(b"glTF"));
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), eikona_mesh::FileError>(())
/// ```
pub fn stage_animation(
    path: impl AsRef<Path>,
    animation: &Animation,
    frame: &mut dyn FnMut(usize) -> Result<Vec<Vec3>, FileError>,
) -> Result<(StagedFile, Vec<FileWarning>), FileError> {
    let path = path.as_ref();
    let named = |fault: FileError| fault.in_file(path);
    let mut first = animation.first.clone();
    first.lines = &[];
    let left_out = first.check(MeshFormat::Glb).map_err(named)?;
    let unsupported = |problem: &str| named(FileError::Unsupported(problem.into()));
    if !(animation.frame_rate > 0.0 && animation.frame_rate.is_finite()) {
        return Err(unsupported("the frame rate is not a positive number; give frames per second"));
    }
    if first.positions().is_empty() || animation.frame_count == 0 {
        return Err(unsupported("there is nothing to animate; give a mesh with vertices"));
    }
    let base = Base::of(&first);
    let mut targets = Vec::new();
    for k in 1..animation.frame_count {
        targets.push(bounds(base.displacements(&frame(k)?).map_err(named)?.positions.into_iter()));
    }
    let layout = Layout::new(base, &targets, animation.frame_rate);
    if layout.binary > MOST_BYTES {
        return Err(unsupported("the animation would exceed the 4 GiB of a .glb; write fewer frames"));
    }
    let file = stage_file(path, |out| layout.write(out, frame))?;
    Ok((file, left_out))
}

/// With room for the description.
const MOST_BYTES: usize = 0xf000_0000;

/// The first frame.
struct Base {
    parts: Parts,
    corners: Vec<u32>,
    vertex_count: usize,
    normals: Vec<[f32; 3]>,
}

/// From the first frame to another one.
struct Displacements {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Base {
    fn of(first: &MeshOut) -> Base {
        let mut parts = Parts::of(first);
        let corners: Vec<u32> = first.faces().flatten().copied().collect();
        let of_vertices = vertex_normals(&corners, first.positions());
        let normals: Vec<[f32; 3]> =
            parts.origins.iter().map(|v| of_vertices[*v as usize].map(|x| x as f32)).collect();
        let accessor = parts.add_points(normals.iter().copied());
        parts.primitives[0]["attributes"]["NORMAL"] = accessor.into();
        Base { parts, corners, vertex_count: first.positions().len(), normals }
    }

    /// Fails if a frame has another number of vertices, or is too far away for 32-bit floats.
    fn displacements(&self, frame: &[Vec3]) -> Result<Displacements, FileError> {
        if frame.len() != self.vertex_count {
            return Err(MeshError::WrongLength {
                what: "vertices of a frame",
                found: frame.len(),
                expected: self.vertex_count,
            }
            .into());
        }
        let of_vertices = vertex_normals(&self.corners, frame);
        let Parts { origins, positions, offset, .. } = &self.parts;
        let way = |(v, from): (&u32, &[f32; 3])| {
            let p = frame[*v as usize];
            [0, 1, 2].map(|k| (p[k] - offset[k] - f64::from(from[k])) as f32)
        };
        let positions: Vec<[f32; 3]> = origins.iter().zip(positions).map(way).collect();
        if let Some(v) = positions.iter().position(|d| d.iter().any(|x| !x.is_finite())) {
            return Err(FileError::Unsupported(format!(
                "vertex {} of a frame is at {:?}, which 32-bit floats can not hold; scale the mesh",
                origins[v], frame[origins[v] as usize]
            )));
        }
        let turn = |(v, from): (&u32, &[f32; 3])| {
            let n = of_vertices[*v as usize];
            [0, 1, 2].map(|k| (n[k] - f64::from(from[k])) as f32)
        };
        let normals = origins.iter().zip(&self.normals).map(turn).collect();
        Ok(Displacements { positions, normals })
    }
}

/// Unit normals, weighted by area; along z where there are no faces.
fn vertex_normals(corners: &[u32], positions: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![[0.0; 3]; positions.len()];
    for face in corners.as_chunks::<3>().0 {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        let (s, t) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let normal = [0, 1, 2].map(|k| s[(k + 1) % 3] * t[(k + 2) % 3] - s[(k + 2) % 3] * t[(k + 1) % 3]);
        face.iter().for_each(|v| (0..3).for_each(|k| sums[*v as usize][k] += normal[k]));
    }
    let unit = |sum: Vec3| {
        let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 && length.is_finite() { sum.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
    };
    sums.into_iter().map(unit).collect()
}

/// The file: first frame, times, weights, then the morph targets.
struct Layout {
    base: Base,
    root: Value,
    /// The number of bytes after the description.
    binary: usize,
    frame_count: usize,
    frame_rate: f64,
}

impl Layout {
    /// Describes the file, given the bounds of the targets.
    fn new(mut base: Base, targets: &[([f32; 3], [f32; 3])], frame_rate: f64) -> Layout {
        let frame_count = targets.len() + 1;
        let Base { parts, normals, .. } = &mut base;
        let mut binary = parts.bytes.len();
        if targets.is_empty() {
            let root = parts.root(None);
            return Layout { base, root, binary, frame_count, frame_rate };
        }
        let mut described = Vec::new();
        let last = time_of(frame_count - 1, frame_rate);
        let bounds = Some((json!([0.0]), json!([last])));
        let (input, end) = parts.declare_floats(binary, frame_count, SCALAR, bounds);
        let (output, end) = parts.declare_floats(end, frame_count * targets.len(), SCALAR, None);
        binary = end;
        for (least, most) in targets {
            let bounds = Some((json!(least), json!(most)));
            let (position, end) = parts.declare_floats(binary, normals.len(), VECTOR, bounds);
            let (normal, end) = parts.declare_floats(end, normals.len(), VECTOR, None);
            binary = end;
            described.push(json!({ "POSITION": position, "NORMAL": normal }));
        }
        parts.primitives[0]["targets"] = described.into();
        let mut root = parts.root(None);
        let names: Vec<String> = (1..frame_count).map(|k| format!("frame {k}")).collect();
        root["meshes"][0]["weights"] = json!(vec![0.0; targets.len()]);
        root["meshes"][0]["extras"] = json!({ "targetNames": names });
        root["animations"] = json!([{
            "name": "frames",
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        }]);
        root["buffers"][0]["byteLength"] = binary.into();
        Layout { base, root, binary, frame_count, frame_rate }
    }

    fn write(
        &self,
        out: &mut dyn Write,
        frame: &mut dyn FnMut(usize) -> Result<Vec<Vec3>, FileError>,
    ) -> io::Result<()> {
        write_glb_head(out, &self.root, self.binary)?;
        out.write_all(&self.base.parts.bytes)?;
        if self.frame_count == 1 {
            return Ok(());
        }
        for k in 0..self.frame_count {
            out.write_all(&time_of(k, self.frame_rate).to_le_bytes())?;
        }
        // At each time, the target of its frame has weight 1.
        for k in 0..self.frame_count {
            for target in 1..self.frame_count {
                let weight: f32 = if target == k { 1.0 } else { 0.0 };
                out.write_all(&weight.to_le_bytes())?;
            }
        }
        for k in 1..self.frame_count {
            let done = frame(k).and_then(|frame| self.base.displacements(&frame));
            let Displacements { positions, normals } = done.map_err(io::Error::other)?;
            for x in positions.iter().chain(&normals).flatten() {
                out.write_all(&x.to_le_bytes())?;
            }
        }
        Ok(())
    }
}

const SCALAR: (&str, usize) = ("SCALAR", 1);
const VECTOR: (&str, usize) = ("VEC3", 3);

/// Seconds.
fn time_of(frame: usize, rate: f64) -> f32 {
    (frame as f64 / rate) as f32
}
