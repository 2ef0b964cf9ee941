//! Files that appear whole or not at all.

use crate::error::FileError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes a file through a temporary one in the same folder, which takes the name `path` only once everything is written
/// and handed to the disk. On failure nothing is left and an older file of that name stays as it was. A symbolic link keeps
/// pointing to the new content; a pipe or device is written to directly.
///
/// ```
/// use eikona_mesh::io::write_atomically;
/// let path = std::env::temp_dir().join("eikona-doc-write-atomically.txt");
/// write_atomically(&path, |out| out.write_all(b"whole"))?;
/// assert_eq!(std::fs::read(&path).unwrap(), b"whole");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), eikona_mesh::FileError>(())
/// ```
///
/// # Errors
/// [`FileError::Io`] with the path: the folder does not exist or may not be written to, the disk is full, or what `write`
/// itself returned.
pub fn write_atomically<T>(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> Result<T, FileError> {
    let path = path.as_ref();
    write_through_temporary(path, write).map_err(|fault| FileError::io(path, fault))
}

fn write_through_temporary<T>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> io::Result<T> {
    let existing = fs::metadata(path).ok();
    if existing.as_ref().is_some_and(|m| m.is_dir()) {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder; name a file"));
    }
    if existing.as_ref().is_some_and(|m| !m.is_file()) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        let value = write(&mut out)?;
        out.flush()?;
        return Ok(value);
    }
    let target = if existing.is_some() { fs::canonicalize(path)? } else { path.to_path_buf() };
    let (file, temporary) = create_beside(&target)?;
    let mut out = BufWriter::with_capacity(1 << 16, file);
    let value = write(&mut out)?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    if let Some(existing) = existing {
        file.set_permissions(existing.permissions())?;
    }
    file.sync_all()?;
    drop(file); // some systems do not rename an open file
    temporary.become_file(&target)?;
    Ok(value)
}

/// A file that is removed when dropped, unless it has been renamed: on errors and on panics alike.
struct Temporary {
    path: Option<PathBuf>,
}

impl Temporary {
    fn become_file(mut self, target: &Path) -> io::Result<()> {
        if let Some(path) = &self.path {
            fs::rename(path, target)?;
        }
        self.path = None;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = &self.path {
            // There is nobody left to tell.
            let _ = fs::remove_file(path);
        }
    }
}

fn create_beside(target: &Path) -> io::Result<(File, Temporary)> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    /// Only a leftover of a killed process with the same id is in the way.
    const ATTEMPTS: usize = 100;
    let mut last = None;
    for _ in 0..ATTEMPTS {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = target.with_file_name(format!(".eikona-{}-{number}.tmp", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, Temporary { path: Some(path) })),
            Err(fault) if fault.kind() == io::ErrorKind::AlreadyExists => last = Some(fault),
            Err(fault) => return Err(fault),
        }
    }
    Err(last.unwrap_or_else(|| io::Error::other("no temporary file could be made")))
}
