//! No two source files of a crate use each other, except for those listed here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Circles that are left: each tells one story in a few files. The list may only shrink.
const KNOWN: [&[&str]; 8] = [
    &["eikona-mesh/src/io/gltf.rs", "eikona-mesh/src/io/gltf_buffers.rs", "eikona-mesh/src/io/gltf_scene.rs"],
    &[
        "eikona-mesh/src/mesh.rs",
        "eikona-mesh/src/point.rs",
        "eikona-mesh/src/polygon.rs",
        "eikona-mesh/src/provenance.rs",
    ],
    &["eikona-render/src/albedo.rs", "eikona-render/src/isolines.rs"],
    &["eikona-render/src/canvas/path.rs", "eikona-render/src/canvas/stroke.rs"],
    &["eikona-render/src/occlusion.rs", "eikona-render/src/shade.rs", "eikona-render/src/shadow.rs"],
    &["eikona/src/curves/funnel.rs", "eikona/src/curves/straighten.rs"],
    &["eikona/src/curves/meeting.rs", "eikona/src/curves/report.rs"],
    &[
        "eikona/src/signed_heat/automatic.rs",
        "eikona/src/signed_heat/integration.rs",
        "eikona/src/signed_heat/level_sets.rs",
    ],
];

/// All source files below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The module path of a file below `src`.
fn module_of(file: &Path, src: &Path) -> Vec<String> {
    let relative = file.strip_prefix(src).unwrap().with_extension("");
    let mut names: Vec<String> = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if matches!(names.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        names.pop();
    }
    names
}

/// The paths named by a `use` declaration, with groups expanded to their common prefix and first
/// names.
fn used(declaration: &str) -> Vec<String> {
    match declaration.split_once('{') {
        None => vec![declaration.to_string()],
        Some((prefix, group)) => {
            let group = group.trim_end_matches(['}', ';']);
            group.split(',').map(|name| format!("{prefix}{}", name.trim())).collect()
        }
    }
}

#[test]
fn files_use_each_other_in_one_direction() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let mut arrows: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut files = 0;
    for folder in ["eikona", "eikona-cli", "eikona-mesh", "eikona-numeric", "eikona-render"] {
        let src = crates.join(folder).join("src");
        let mut found = Vec::new();
        sources(&src, &mut found);
        files += found.len();
        let by_module: BTreeMap<Vec<String>, &PathBuf> =
            found.iter().map(|file| (module_of(file, &src), file)).collect();
        let name = |file: &Path| file.strip_prefix(&crates).unwrap().to_string_lossy().into_owned();
        // Module files only collect what lies below them.
        for file in found.iter().filter(|f| !f.ends_with("mod.rs") && !f.ends_with("lib.rs")) {
            let text = std::fs::read_to_string(file).unwrap();
            let text = text.split("#[cfg(test)]").next().unwrap_or_default().replace('\n', " ");
            let module = module_of(file, &src);
            for declaration in text.split("use ").skip(1).filter_map(|rest| rest.split(';').next()) {
                for path in used(declaration) {
                    let names: Vec<&str> = path.split("::").map(str::trim).collect();
                    let mut target: Vec<String> = match names[0] {
                        "crate" => Vec::new(),
                        "super" => module[..module.len() - 1].to_vec(),
                        _ => continue,
                    };
                    target.extend(names[1..].iter().map(|name| name.to_string()));
                    // The longest prefix that is a module.
                    while !target.is_empty() && !by_module.contains_key(&target) {
                        target.pop();
                    }
                    if let Some(other) = by_module.get(&target)
                        && *other != file
                        && !other.ends_with("mod.rs")
                        && !other.ends_with("lib.rs")
                        && !other.ends_with("main.rs")
                    {
                        arrows.entry(name(file)).or_default().insert(name(other));
                    }
                }
            }
        }
    }
    assert!(files > 200 && arrows.len() > 100, "{files} files, {} with arrows", arrows.len());
    let reached = |from: &str| {
        let mut seen = BTreeSet::new();
        let mut stack = vec![from.to_string()];
        while let Some(file) = stack.pop() {
            for next in arrows.get(&file).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    stack.push(next.clone());
                }
            }
        }
        seen
    };
    let circles: BTreeSet<Vec<String>> = arrows
        .keys()
        .filter_map(|file| {
            let around: Vec<String> =
                reached(file).into_iter().filter(|other| reached(other).contains(file)).collect();
            (around.len() > 1).then_some(around)
        })
        .collect();
    let new: Vec<&Vec<String>> = circles
        .iter()
        .filter(|circle| !KNOWN.iter().any(|known| circle.iter().all(|f| known.contains(&f.as_str()))))
        .collect();
    assert!(new.is_empty(), "files that use each other: {new:#?}");
    let gone: Vec<_> = KNOWN
        .iter()
        .filter(|known| !circles.iter().any(|circle| known.iter().all(|f| circle.iter().any(|g| g == f))))
        .collect();
    assert!(gone.is_empty(), "no longer circles, to be taken off the list: {gone:#?}");
}
