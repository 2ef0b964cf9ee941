//! Sets the configuration `data_folder` where the project's data folder exists. Tests that need it
//! are ignored elsewhere.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(data_folder)");
    println!("cargo::rerun-if-changed=build.rs");
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/MANIFEST.md");
    if std::path::Path::new(manifest).is_file() {
        println!("cargo::rerun-if-changed={manifest}");
        println!("cargo::rustc-cfg=data_folder");
    }
}
