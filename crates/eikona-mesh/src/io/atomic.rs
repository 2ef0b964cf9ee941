//! Atomic file writes: a file appears complete or not at all.

use crate::error::FileError;
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Writes a file under a temporary name in the same folder and renames it to `path` once everything
/// is written and synced to disk. On failure nothing is left behind, and an older file of that name
/// is unchanged. A symbolic link keeps pointing to the new content; pipes and devices are written
/// directly.
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
/// [`FileError::Io`] with the path: the folder does not exist or is not writable, the disk is full,
/// or `write` itself failed.
pub fn write_atomically<T>(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<T>,
) -> Result<T, FileError> {
    let path = path.as_ref();
    let (staged, value) = stage(path, write).map_err(|fault| FileError::io(path, fault))?;
    publish_files(vec![staged])?;
    Ok(value)
}

/// A complete file under a temporary name next to its own. [`publish_files`] renames it; dropping
/// it removes it.
#[derive(Debug)]
pub struct StagedFile {
    path: PathBuf,
    content: Content,
}

#[derive(Debug)]
enum Content {
    /// A temporary file, and its final name (the target of a symbolic link).
    Temporary(Temporary, PathBuf),
    /// The content for a pipe or device.
    Bytes(Vec<u8>),
}

/// Writes a file under a temporary name, for several files that must appear together or not at all.
///
/// ```
/// use eikona_mesh::io::{publish_files, stage_file};
/// let path = std::env::temp_dir().join("eikona-doc-stage-file.txt");
/// let staged = stage_file(&path, |out| out.write_all(b"whole"))?;
/// assert!(!path.exists());
/// publish_files(vec![staged])?;
/// assert_eq!(std::fs::read(&path).unwrap(), b"whole");
/// # std::fs::remove_file(&path).unwrap();
/// # Ok::<(), eikona_mesh::FileError>(())
/// ```
///
/// # Errors
/// As for [`write_atomically`].
pub fn stage_file(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<StagedFile, FileError> {
    let path = path.as_ref();
    stage(path, write).map(|(staged, ())| staged).map_err(|fault| FileError::io(path, fault))
}

/// Renames the files to their own names, in order. If one fails, the files published before it that
/// did not replace anything are removed again.
///
/// # Errors
/// [`FileError::Io`] with the first file that could not be renamed or written.
pub fn publish_files(files: Vec<StagedFile>) -> Result<(), FileError> {
    // Locked to the end, so that `discard_temporary_files` finds all of them published or none.
    let mut unfinished = unfinished();
    let mut created: Vec<PathBuf> = Vec::new();
    for StagedFile { path, content } in files {
        let done = match content {
            Content::Temporary(temporary, target) => {
                let new = !target.exists();
                let renamed = temporary.become_file(&target, &mut unfinished);
                if renamed.is_ok() && new {
                    created.push(target);
                }
                renamed
            }
            Content::Bytes(bytes) => OpenOptions::new().write(true).open(&path).and_then(|mut out| {
                out.write_all(&bytes)?;
                out.flush()
            }),
        };
        if let Err(fault) = done {
            for file in created {
                // Report the first error.
                let _ = fs::remove_file(file);
            }
            drop(unfinished); // the remaining files lock it to remove themselves
            return Err(FileError::io(path, fault));
        }
    }
    Ok(())
}

/// Removes the temporary files of this process, for a program that is about to exit because it was
/// interrupted. Waits for a [`publish_files`] in progress. Afterwards no file can be staged or
/// published any more: those calls block forever.
pub fn discard_temporary_files() {
    let unfinished = unfinished();
    for path in unfinished.iter() {
        // No one is left to report to.
        let _ = fs::remove_file(path);
    }
    std::mem::forget(unfinished);
}

/// Returns the temporary files that exist now.
fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

fn stage<T>(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<T>) -> io::Result<(StagedFile, T)> {
    let existing = fs::metadata(path).ok();
    if existing.as_ref().is_some_and(|m| m.is_dir()) {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder; give a file name"));
    }
    if existing.as_ref().is_some_and(|m| !m.is_file()) {
        let mut bytes = Vec::new();
        let value = write(&mut bytes)?;
        return Ok((StagedFile { path: path.to_path_buf(), content: Content::Bytes(bytes) }, value));
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
    drop(file); // some systems can not rename an open file
    Ok((StagedFile { path: path.to_path_buf(), content: Content::Temporary(temporary, target) }, value))
}

/// A file that is removed when dropped, unless it has been renamed: on errors and panics alike.
#[derive(Debug)]
struct Temporary {
    path: Option<PathBuf>,
}

impl Temporary {
    fn become_file(mut self, target: &Path, unfinished: &mut BTreeSet<PathBuf>) -> io::Result<()> {
        // Taken first: dropping a path that is still present would lock `unfinished`, which the
        // caller holds.
        let Some(path) = self.path.take() else { return Ok(()) };
        let renamed = fs::rename(&path, target);
        if renamed.is_err() {
            let _ = fs::remove_file(&path);
        }
        unfinished.remove(&path);
        renamed
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = &self.path {
            // No one is left to report to.
            let _ = fs::remove_file(path);
            unfinished().remove(path);
        }
    }
}

fn create_beside(target: &Path) -> io::Result<(File, Temporary)> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    /// Only a leftover of a killed process with the same id can collide.
    const ATTEMPTS: usize = 100;
    let mut last = None;
    for _ in 0..ATTEMPTS {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = target.with_file_name(format!(".eikona-{}-{number}.tmp", std::process::id()));
        let mut unfinished = unfinished();
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => {
                unfinished.insert(path.clone());
                return Ok((file, Temporary { path: Some(path) }));
            }
            Err(fault) if fault.kind() == io::ErrorKind::AlreadyExists => last = Some(fault),
            Err(fault) => return Err(fault),
        }
    }
    Err(last.unwrap_or_else(|| io::Error::other("no temporary file could be created")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_not_all_published_leave_nothing_behind() {
        let folder = std::env::temp_dir().join(format!("eikona-atomic-test-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let stage = |name: &str| stage_file(folder.join(name), |out| out.write_all(b"new")).unwrap();
        let names = || fs::read_dir(&folder).unwrap().count();

        drop(stage("dropped"));
        assert_eq!(names(), 0);

        fs::write(folder.join("old"), "old").unwrap();
        let files = vec![stage("old"), stage("first"), stage("blocked"), stage("last")];
        fs::create_dir(folder.join("blocked")).unwrap(); // a file can not replace a folder
        assert!(publish_files(files).is_err());
        assert!(!folder.join("first").exists() && !folder.join("last").exists());
        assert_eq!(names(), 2, "the old file and the folder");

        fs::remove_dir(folder.join("blocked")).unwrap();
        publish_files(vec![stage("old"), stage("blocked")]).unwrap();
        assert_eq!(fs::read(folder.join("old")).unwrap(), b"new");
        assert!(!unfinished().iter().any(|path| path.starts_with(&folder)));
        fs::remove_dir_all(&folder).unwrap();
    }
}
