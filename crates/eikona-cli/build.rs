//! Sets the configurations under which tests run that need more than the project itself:
//! `data_folder` where its data folder exists, `python_libigl` where the variable `EIKONA_PYTHON`
//! names a Python that has libigl and numpy. Elsewhere they are ignored.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(data_folder)");
    println!("cargo::rustc-check-cfg=cfg(python_libigl)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EIKONA_PYTHON");
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/MANIFEST.md");
    if std::path::Path::new(manifest).is_file() {
        println!("cargo::rerun-if-changed={manifest}");
        println!("cargo::rustc-cfg=data_folder");
    }
    let imports = |python| std::process::Command::new(python).args(["-c", "import igl, numpy"]).output().ok();
    if std::env::var_os("EIKONA_PYTHON").and_then(imports).is_some_and(|out| out.status.success()) {
        println!("cargo::rustc-cfg=python_libigl");
    }
}
