//! One GLB file with all frames of a run whose faces keep their numbers.

use super::attributes::Attributes;
use super::folder::{RunFolder, unwritten};
use crate::exit::Failure;
use eikona_mesh::io::{Animation, publish_files, read_mesh, stage_animation};
use eikona_mesh::{FileError, TriangleMesh};
use std::path::PathBuf;

/// Frames per second.
pub const DEFAULT_RATE: &str = "24";

/// Parses a number of frames per second.
pub fn parse_rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok().filter(|x| (1e-3..=1e3).contains(x));
    rate.ok_or_else(|| "expected frames per second, from 0.001 to 1000".into())
}

/// Writes `animation.glb` from the frames in the folder, so a resumed run writes the same file. The
/// first frame is the surface at the start, `mesh`. Returns the path.
pub fn write_animation(
    folder: &RunFolder,
    mesh: &TriangleMesh,
    attributes: &Attributes,
    frame_rate: f64,
) -> Result<PathBuf, Failure> {
    let path = folder.path().join("animation.glb");
    let steps = folder.frames();
    let colours = attributes.colours();
    let first = attributes.out(mesh, colours.as_deref());
    let animation = Animation { first, frame_count: steps.len(), frame_rate };
    let mut frame = |k: usize| positions_of(folder.frame_path(steps[k]), mesh);
    let (file, _) = stage_animation(&path, &animation, &mut frame).map_err(unwritten)?;
    publish_files(vec![file]).map_err(unwritten)?;
    Ok(path)
}

/// The vertices of a frame. Copies that GLB makes of vertices on seams follow them.
fn positions_of(path: PathBuf, mesh: &TriangleMesh) -> Result<Vec<[f64; 3]>, FileError> {
    let mut file = read_mesh(&path)?.mesh;
    let [vertices, faces] = [mesh.vertex_count(), mesh.face_count()];
    if file.vertex_count() < vertices || file.face_count() != faces {
        let problem = format!(
            "this frame has {} vertices and {} faces instead of {vertices} and {faces}; the folder is not as \
             the run left it",
            file.vertex_count(),
            file.face_count()
        );
        return Err(FileError::Unsupported(problem).in_file(path));
    }
    file.positions.truncate(vertices);
    Ok(file.positions)
}
