//! Sets the configurations under which tests run that need more than the project itself:
//! `data_folder` where its data folder exists, `python_libigl` and `python_ipctk` where the
//! variable `EIKONA_PYTHON` names a Python that has the package and numpy. Elsewhere they are
//! ignored.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(data_folder)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EIKONA_PYTHON");
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/MANIFEST.md");
    if std::path::Path::new(manifest).is_file() {
        println!("cargo::rerun-if-changed={manifest}");
        println!("cargo::rustc-cfg=data_folder");
    }
    let python = std::env::var_os("EIKONA_PYTHON");
    for (name, module) in [("python_libigl", "igl"), ("python_ipctk", "ipctk")] {
        println!("cargo::rustc-check-cfg=cfg({name})");
        let import = format!("import {module}, numpy");
        let run = |python| std::process::Command::new(python).args(["-c", &import]).output().ok();
        if python.as_ref().and_then(run).is_some_and(|out| out.status.success()) {
            println!("cargo::rustc-cfg={name}");
        }
    }
}
