//! How the command ends: the exit codes, and failures as one paragraph that says what, where and
//! what to do.

use eikona::contour::ContourError;
use eikona::curves::TraceError;
use eikona::signed_heat::SignedHeatError;
use eikona::winding::WindingError;
use eikona_mesh::{CurveError, FileError, MeshError};
use eikona_render::RenderError;
use std::io::ErrorKind;
use std::path::Path;
use thiserror::Error;

/// Something went wrong that is neither the user's input nor the way of asking.
pub const FAILED: u8 = 1;
/// The command line can not be understood or asks for what does not exist.
pub const USAGE: u8 = 2;
/// A file that was read is missing or wrong.
pub const INPUT: u8 = 3;
/// All is done, but there were warnings and `--strict` was given.
pub const WARNINGS: u8 = 4;
/// Stopped by Ctrl-C.
pub const INTERRUPTED: u8 = 130;

/// Why the command did not do what it was asked for.
#[derive(Debug, Error)]
pub enum Failure {
    /// Exit code [`USAGE`].
    #[error("{0}")]
    Usage(String),
    /// Exit code [`INPUT`].
    #[error("{0}")]
    Input(String),
    /// Exit code [`FAILED`].
    #[error("{0}")]
    Failed(String),
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Usage(_) => USAGE,
            Failure::Input(_) => INPUT,
            Failure::Failed(_) => FAILED,
        }
    }

    /// A file could not be read.
    pub fn reading(path: &Path, fault: FileError) -> Failure {
        // Of the named file, not of another one that it needs.
        let kind = match &fault {
            FileError::Io { path: of, fault } if Path::new(of) == path => Some(fault.kind()),
            _ => None,
        };
        let (missing, folder) = (kind == Some(ErrorKind::NotFound), kind == Some(ErrorKind::IsADirectory));
        if missing {
            Failure::Input(format!(
                "{}: there is no such file; check the name and the folder",
                path.display()
            ))
        } else if folder {
            Failure::Input(format!("{}: this is a folder; name a file", path.display()))
        } else {
            Failure::Input(fault.in_file(path).to_string())
        }
    }

    /// A curve of a file is not valid.
    pub fn curve(path: &Path, fault: impl std::fmt::Display) -> Failure {
        Failure::Input(format!("{}: {fault}", path.display()))
    }

    /// A file could not be written.
    pub fn writing(fault: FileError) -> Failure {
        match fault {
            FileError::Io { path, fault } => Failure::Failed(format!(
                "{path}: this file can not be written ({fault}); no output was left behind. Name a folder that exists and that \
                 you may write to"
            )),
            fault @ FileError::InFile { .. } => Failure::Usage(fault.to_string()),
            other => Failure::Failed(other.to_string()),
        }
    }
}

impl From<SignedHeatError> for Failure {
    fn from(fault: SignedHeatError) -> Failure {
        use SignedHeatError as E;
        match fault {
            E::Curve(CurveError::Empty) => Failure::Usage(
                "there is no curve and no point to measure distance to; give --curve FILE or --points 12,40 (or `l` lines in \
                 the OBJ file of the mesh)"
                    .into(),
            ),
            E::Curve(_) | E::NoFaces | E::NoArea | E::Scale { .. } => Failure::Input(fault.to_string()),
            E::Option { .. } => Failure::Usage(fault.to_string()),
            _ => Failure::Failed(fault.to_string()),
        }
    }
}

impl From<WindingError> for Failure {
    fn from(fault: WindingError) -> Failure {
        use WindingError as E;
        match fault {
            E::Option { .. } => Failure::Usage(fault.to_string()),
            E::Numeric(_) | E::Program(_) => Failure::Failed(fault.to_string()),
            _ => Failure::Input(fault.to_string()),
        }
    }
}

/// A parameter on the command line is out of range.
impl From<ContourError> for Failure {
    fn from(fault: ContourError) -> Failure {
        match fault {
            ContourError::Parameter { .. } | ContourError::BadPlane { .. } => {
                Failure::Usage(fault.to_string())
            }
            _ => Failure::Input(fault.to_string()),
        }
    }
}

impl From<TraceError> for Failure {
    fn from(fault: TraceError) -> Failure {
        match fault {
            TraceError::Parameter { .. } => Failure::Usage(fault.to_string()),
            _ => Failure::Input(fault.to_string()),
        }
    }
}

/// A shape or a damage was asked for that can not be made.
impl From<MeshError> for Failure {
    fn from(fault: MeshError) -> Failure {
        Failure::Usage(fault.to_string())
    }
}

impl From<RenderError> for Failure {
    fn from(fault: RenderError) -> Failure {
        use RenderError as E;
        match fault {
            E::ImageSize { .. } | E::TooManySamples { .. } | E::Option { .. } | E::Range { .. } => {
                Failure::Usage(fault.to_string())
            }
            E::UnknownColorMap { .. } => Failure::Usage(fault.to_string()),
            E::NonFinite { .. } => Failure::Input(fault.to_string()),
            _ => Failure::Failed(fault.to_string()),
        }
    }
}
