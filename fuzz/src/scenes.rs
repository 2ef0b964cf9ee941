//! Scene files: the first byte chooses the grammar, the others are the text.

use eikona_scene::{model::Source, read_scene_bytes};
use std::path::Path;

/// Reads the scene in one of the grammars.
///
/// # Panics
/// If a fault has no words or very many lines, or an accepted scene has nothing that moves or a
/// shape that cannot be made.
pub fn check(bytes: &[u8]) {
    let Some((first, text)) = bytes.split_first() else { return };
    let path = if first % 2 == 0 { "scene.txt" } else { "scene.toml" };
    match read_scene_bytes(text, Path::new(path)) {
        Ok(scene) => {
            assert!(!scene.surfaces.is_empty());
            for surface in &scene.surfaces {
                let source: &Source = &surface.value.source;
                assert!(source.shape().is_none_or(|shape| shape.is_ok()), "{source:?}");
            }
        }
        Err(fault) => {
            let message = fault.to_string();
            assert!(!message.is_empty() && message.lines().count() <= 13, "{message}");
        }
    }
}
