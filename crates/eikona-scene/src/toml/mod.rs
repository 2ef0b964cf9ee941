//! Our own grammar, in TOML.
//!
//! `tree` parses the text and hands it to serde: an entry at fault is reported and taken out, and
//! the rest is read again, so that one pass finds all faults. `document` has the keys, `values` the
//! ranges of numbers, and `convert` turns what was read into the scene.

mod convert;
mod document;
mod tree;
mod values;

use super::faults::Faults;
use super::model::Scene;
use document::Document;
use std::path::Path;

/// Reads a scene, with all its faults.
pub fn read(text: &str, path: &Path) -> (Scene, Faults) {
    let mut faults = Faults::default();
    let mut scene = Scene::new(path);
    if let Some(read) = tree::read::<Document>(text, &mut faults) {
        let mesh_named = read.document.mesh.is_some() || read.taken_out.iter().any(|key| key == "mesh");
        convert::fill(&mut scene, read.document, &read.lines, &mut faults);
        if !mesh_named {
            let example = "mesh = \"FILE\" or mesh = { shape = \"torus\" }";
            faults.add(None, format!("nothing says what to move; add {example} at the top"));
        }
    }
    (scene, faults)
}
