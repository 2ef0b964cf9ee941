//! Scene files: what moves, under which constraints, around which obstacles, and for how long.
//!
//! There are two grammars. `original` reads that of the authors' program, in `.txt` files;
//! `toml` reads ours. Both fill the same [`Scene`], `check` refuses what contradicts itself, and
//! `Faults` collects all that is wrong with a file into one message. docs/scenes.md documents
//! both grammars.

mod check;
mod faults;
pub mod implicit;
pub mod model;
mod number;
mod original;
#[cfg(test)]
mod tests;
mod toml;

pub use model::Scene;

use eikona_mesh::io::MeshFormat;
use faults::Faults;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use thiserror::Error;

/// Returns whether a file is a scene rather than a mesh: by its extension `.txt` or `.toml`, or, if
/// the name says nothing, by its first word.
pub fn is_scene(path: &Path) -> bool {
    let has = |name: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(name));
    if has("txt") || has("toml") {
        return true;
    }
    if MeshFormat::from_path(path).is_some() || !path.is_file() {
        return false;
    }
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(4096).read_to_end(&mut start));
    read.is_ok() && original::starts_like_a_scene(&String::from_utf8_lossy(without_mark(&start)))
}

/// Reads a scene file.
///
/// # Errors
/// [`SceneError::Faults`] with up to ten faults of the file, each with its line;
/// [`SceneError::Io`].
pub fn read_scene(path: &Path) -> Result<Scene, SceneError> {
    let io = |fault| SceneError::Io { path: path.display().to_string(), fault };
    read_scene_bytes(&std::fs::read(path).map_err(io)?, path)
}

/// Reads the content of a scene file, as if it lay at a path: its extension tells the grammar, and
/// meshes are looked for beside it.
///
/// # Errors
/// As for [`read_scene`].
///
/// ```
/// use eikona_scene::read_scene_bytes;
/// let text = b"mesh = { shape = \"torus\", minor = 0.3 }\nstop.steps = 5";
/// let scene = read_scene_bytes(text, "scene.toml".as_ref())?;
/// assert_eq!(scene.stop.steps.unwrap().value, 5);
/// let fault = read_scene_bytes(b"repel_mesh\nconstrian area", "scene.txt".as_ref()).unwrap_err();
/// assert!(fault.to_string().contains("line 2: there is no word `constrian`"));
/// # Ok::<(), eikona_scene::SceneError>(())
/// ```
pub fn read_scene_bytes(bytes: &[u8], path: &Path) -> Result<Scene, SceneError> {
    let (scene, faults) = parse(bytes, path);
    faults.into_result(path)?;
    Ok(scene)
}

/// Why a scene was not read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{path}: {fault}; check the name and the folder")]
    Io {
        /// The file.
        path: String,
        /// What went wrong.
        fault: std::io::Error,
    },
    /// What is wrong with the file, by line.
    #[error("{0}")]
    Faults(String),
}

/// Reads the content of a scene file. Meshes are looked for beside `path`.
fn parse(bytes: &[u8], path: &Path) -> (Scene, Faults) {
    let bytes = without_mark(bytes);
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(fault) => {
            let before = &bytes[..fault.valid_up_to()];
            let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
            let problem = "this is not UTF-8 text; save the scene as UTF-8";
            return (Scene::new(path), Faults::one(Some(line), problem.into()));
        }
    };
    let is_toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let (scene, mut faults) = if is_toml { toml::read(text, path) } else { original::read(text, path) };
    check::contradictions(&scene, &mut faults);
    (scene, faults)
}

/// Editors on Windows put a byte order mark before the text.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}
