//! Exit codes and failures. A message says what is wrong, where, and what to do.

use eikona::contour::ContourError;
use eikona::curves::TraceError;
use eikona::polar_field::PolarFieldError;
use eikona::repulsive::RepulsiveError;
use eikona::signed_heat::SignedHeatError;
use eikona::winding::WindingError;
use eikona_mesh::{CurveError, FileError, MeshError};
use eikona_render::RenderError;
use std::io::ErrorKind;
use std::path::Path;
use thiserror::Error;

/// The computation or a write failed; neither the command line nor an input file is at fault.
pub const FAILED: u8 = 1;
/// The command line is invalid.
pub const USAGE: u8 = 2;
/// An input file is missing or invalid.
pub const INPUT: u8 = 3;
/// The command finished with warnings under `--strict`.
pub const WARNINGS: u8 = 4;
/// Ctrl-C interrupted the command.
pub const INTERRUPTED: u8 = 130;

/// Why the command failed.
#[derive(Debug, Error)]
pub enum Failure {
    /// Exits with [`USAGE`].
    #[error("{0}")]
    Usage(String),
    /// Exits with [`INPUT`].
    #[error("{0}")]
    Input(String),
    /// Exits with [`FAILED`].
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

    /// Failure to read a file.
    pub fn reading(path: &Path, fault: FileError) -> Failure {
        // Only for the named file, not for another one that it refers to.
        let kind = match &fault {
            FileError::Io { path: of, fault } if Path::new(of) == path => Some(fault.kind()),
            _ => None,
        };
        let (missing, folder) = (kind == Some(ErrorKind::NotFound), kind == Some(ErrorKind::IsADirectory));
        if missing {
            Failure::Input(format!("{}: no such file; check the name and the folder", path.display()))
        } else if folder {
            Failure::Input(format!("{}: this is a folder; give a file", path.display()))
        } else {
            Failure::Input(fault.in_file(path).to_string())
        }
    }

    /// Invalid curve in a file.
    pub fn curve(path: &Path, fault: impl std::fmt::Display) -> Failure {
        Failure::Input(format!("{}: {fault}", path.display()))
    }

    /// Failure to convert a result to the bytes of a file.
    pub fn encoding(fault: std::io::Error) -> Failure {
        Failure::Failed(fault.to_string())
    }

    /// Failure to write a file.
    pub fn writing(fault: FileError) -> Failure {
        match fault {
            FileError::Io { path, fault } => Failure::Failed(format!(
                "{path}: cannot write this file ({fault}), no output file was written; choose an existing \
                 folder with write permission"
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
                "no curves or points to measure distance to; give --curve FILE or --points 12,40, or add \
                 `l` lines to the mesh's OBJ file"
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

impl From<PolarFieldError> for Failure {
    fn from(fault: PolarFieldError) -> Failure {
        use PolarFieldError as E;
        match fault {
            E::Degree { .. } => Failure::Usage(fault.to_string()),
            E::Numeric(_) => Failure::Failed(fault.to_string()),
            _ => Failure::Input(fault.to_string()),
        }
    }
}

impl From<RepulsiveError> for Failure {
    fn from(fault: RepulsiveError) -> Failure {
        use RepulsiveError as E;
        match fault {
            E::Exponents { .. } => Failure::Usage(fault.to_string()),
            E::Numeric(_) => Failure::Failed(fault.to_string()),
            _ => Failure::Input(fault.to_string()),
        }
    }
}

/// Only parameters come from the command line; all else comes from files.
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

/// Raised by shapes and damage, whose parameters come from the command line.
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
