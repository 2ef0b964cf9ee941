//! Other programs to compare with: Python packages, fed through a temporary folder.

use crate::exit::Failure;
use eikona_mesh::TriangleMesh;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};

/// Checks that a Python interpreter can import a module, which a package of this name has.
pub fn find_module(python: &Path, module: &str, package: &str) -> Result<(), Failure> {
    let found = Command::new(python)
        .args(["-c", &format!("import numpy, {module}")])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|s| s.success());
    if found {
        return Ok(());
    }
    let python = python.display();
    Err(Failure::Failed(format!(
        "{python} cannot import numpy and {module}; install them with\n  {python} -m pip install {package} numpy\nor \
         choose another Python with --python PATH"
    )))
}

/// The temporary folder that passes data to the other program.
static FOLDER: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Removes the temporary folder, if there is one.
pub fn remove_temporary_folder() {
    if let Some(folder) = FOLDER.lock().unwrap_or_else(PoisonError::into_inner).take() {
        // A leftover folder is harmless.
        let _ = std::fs::remove_dir_all(folder);
    }
}

/// Creates the temporary folder for a measurement and removes it afterwards.
pub fn with_folder<R>(measure: impl FnOnce(&Path) -> Result<R, Failure>) -> Result<R, Failure> {
    let folder = std::env::temp_dir().join(format!("eikona-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder)
        .map_err(|e| Failure::Failed(format!("{}: cannot create this folder: {e}", folder.display())))?;
    *FOLDER.lock().unwrap_or_else(PoisonError::into_inner) = Some(folder.clone());
    let measured = measure(&folder);
    remove_temporary_folder();
    measured
}

/// Writes a file of the folder.
pub fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Failure> {
    let path = folder.join(name);
    std::fs::write(&path, bytes)
        .map_err(|e| Failure::Failed(format!("{}: cannot write this file: {e}", path.display())))
}

/// Writes raw doubles.
pub fn write_doubles(folder: &Path, name: &str, values: impl Iterator<Item = f64>) -> Result<(), Failure> {
    write(folder, name, &values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
}

/// Writes V.f64 and F.i32: positions and triangles as raw arrays.
pub fn write_mesh(folder: &Path, mesh: &TriangleMesh) -> Result<(), Failure> {
    write_doubles(folder, "V.f64", mesh.positions().iter().flatten().copied())?;
    let corners = mesh.triangles().iter().flatten();
    write(folder, "F.i32", &corners.flat_map(|&v| (v as i32).to_le_bytes()).collect::<Vec<u8>>())
}
