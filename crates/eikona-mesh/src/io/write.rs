//! Writes mesh files, in the format of their names.

use super::atomic::{StagedFile, publish_files, stage_file};
use super::{MeshFormat, MeshOut, gltf_write, obj, off, ply_write, stl, vtp_write};
use crate::error::FileError;
use crate::warning::FileWarning;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a mesh file atomically, in the format of its name; a final `.gz` compresses it. Returns
/// what the format can not hold, and whether 32-bit floats spoil the coordinates, one sentence
/// each.
///
/// # Errors
/// [`FileError::Unsupported`] if the name does not determine a format, or the format can not hold
/// the mesh (polygons in STL and GLB, coordinates beyond 32-bit floats there); [`FileError::Mesh`]
/// for arrays of wrong length and indices out of range; [`FileError::Io`].
pub fn write_mesh(path: impl AsRef<Path>, mesh: &MeshOut) -> Result<Vec<FileWarning>, FileError> {
    let (file, left_out) = stage_mesh(path, mesh)?;
    publish_files(vec![file])?;
    Ok(left_out)
}

/// Writes like [`write_mesh`], but the file gets its name only from [`publish_files`]: for several
/// files that must appear together.
///
/// # Errors
/// As for [`write_mesh`].
pub fn stage_mesh(
    path: impl AsRef<Path>,
    mesh: &MeshOut,
) -> Result<(StagedFile, Vec<FileWarning>), FileError> {
    let path = path.as_ref();
    let format = MeshFormat::from_path(path).ok_or_else(|| {
        let problem =
            "the file name has no known mesh extension; use .obj, .ply, .stl, .off, .glb, .gltf or .vtp";
        FileError::Unsupported(problem.into()).in_file(path)
    })?;
    let left_out = mesh.check(format).map_err(|fault| fault.in_file(path))?;
    let compressed = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let file = stage_file(path, |out| {
        if compressed {
            let mut out = BufWriter::new(flate2::write::GzEncoder::new(out, flate2::Compression::default()));
            write_format(&mut out, format, mesh)?;
            out.into_inner().map_err(io::IntoInnerError::into_error)?.finish().map(|_| ())
        } else {
            write_format(out, format, mesh)
        }
    })?;
    Ok((file, left_out))
}

/// Writes a mesh in this format. Returns the same as [`write_mesh`].
///
/// # Errors
/// As for [`write_mesh`]; all checks precede the first byte written.
pub fn write_mesh_bytes(
    out: &mut impl Write,
    format: MeshFormat,
    mesh: &MeshOut,
) -> Result<Vec<FileWarning>, FileError> {
    let left_out = mesh.check(format)?;
    let mut buffered = BufWriter::with_capacity(1 << 16, out);
    write_format(&mut buffered, format, mesh)
        .and_then(|()| buffered.flush())
        .map_err(|fault| FileError::io("output", fault))?;
    Ok(left_out)
}

fn write_format(out: &mut dyn Write, format: MeshFormat, mesh: &MeshOut) -> io::Result<()> {
    match format {
        MeshFormat::Obj => obj::write_obj(out, mesh),
        MeshFormat::Ply => ply_write::write_ply(out, mesh),
        MeshFormat::Stl => stl::write_stl(out, mesh),
        MeshFormat::Off => off::write_off(out, mesh),
        MeshFormat::Glb => gltf_write::write_glb(out, mesh),
        MeshFormat::Gltf => gltf_write::write_gltf(out, mesh),
        MeshFormat::Vtp => vtp_write::write_vtp(out, mesh),
    }
}
