//! Output files of isolines: polylines for other programs, or curves that `--curve` reads.

use crate::exit::Failure;
use crate::number::{above_zero, brief, finite};
use crate::session::Session;
use crate::warned::Warned;
use clap::Args;
use eikona::contour::{
    FLATNESS_TOLERANCE, isolines, obj_lines, ply_edges, polylines, round_levels, spaced_levels, svg_paths,
};
use eikona_mesh::{CurveFile, CurveFormat, Quality, SurfaceCurves, TriangleMesh, VertexField, format_curves};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Isoline levels and output.
#[derive(Args, Clone, Debug, Default)]
pub struct IsolineArguments {
    /// Write isolines of the distance: .obj, .ply, .svg (flat meshes), or .json (curves that
    /// `--curve` reads)
    #[arg(long, value_name = "OUT2")]
    pub isolines: Option<PathBuf>,
    /// Isolines at all multiples of D (also in the picture) [default: about 18 round values]
    #[arg(long, value_name = "D", conflicts_with = "levels", allow_hyphen_values = true, value_parser = above_zero)]
    pub spacing: Option<f64>,
    /// Isolines at these values (also in the picture)
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    pub levels: Vec<f64>,
}

impl IsolineArguments {
    /// The option that sets the levels, if given.
    pub fn given(&self) -> Option<&'static str> {
        let levels = (!self.levels.is_empty()).then_some("--levels");
        self.spacing.map(|_| "--spacing").or(levels)
    }
}

/// Same number as in a picture.
const ABOUT: usize = 18;

/// Formats of isolines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum IsolineFormat {
    Obj,
    Ply,
    Svg,
    Json,
}

impl IsolineFormat {
    fn of(path: &Path) -> Result<IsolineFormat, Failure> {
        match path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase().as_str() {
            "obj" => Ok(IsolineFormat::Obj),
            "ply" => Ok(IsolineFormat::Ply),
            "svg" => Ok(IsolineFormat::Svg),
            "json" => Ok(IsolineFormat::Json),
            _ => Err(Failure::Usage(format!(
                "{}: unsupported format for isolines; use .obj, .ply, .svg or .json",
                path.display()
            ))),
        }
    }
}

/// Fails if the file name has no known format.
pub fn check_isoline_path(arguments: &IsolineArguments) -> Result<(), Failure> {
    arguments.isolines.as_deref().map_or(Ok(()), |path| IsolineFormat::of(path).map(|_| ()))
}

/// Fails early for SVG isolines of a mesh that is not flat.
pub fn check_flat_for_svg(arguments: &IsolineArguments, mesh: &TriangleMesh) -> Result<(), Failure> {
    let Some(path) = arguments.isolines.as_deref() else { return Ok(()) };
    if IsolineFormat::of(path)? != IsolineFormat::Svg {
        return Ok(());
    }
    let Some([low, high]) = Quality::of(mesh).bounding_box else { return Ok(()) };
    let size = (high[0] - low[0]).max(high[1] - low[1]);
    if high[2] - low[2] <= FLATNESS_TOLERANCE * size {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{}: SVG stores lines in the xy-plane only, but z of the mesh ranges from {} to {}; write .obj, \
         .ply or .json",
        path.display(),
        brief(low[2]),
        brief(high[2])
    )))
}

/// Stages the isoline file, if requested. Returns the requested levels for the picture.
pub fn output_isolines(
    arguments: &IsolineArguments,
    mesh: &TriangleMesh,
    field: &VertexField<f64>,
    session: &mut Session,
) -> Result<Option<Vec<f64>>, Failure> {
    let asked = match arguments.spacing {
        Some(spacing) => Some(spaced_levels(field.as_slice(), spacing)?),
        None if !arguments.levels.is_empty() => Some(arguments.levels.clone()),
        None => None,
    };
    let Some(path) = &arguments.isolines else { return Ok(asked) };
    let levels = match &asked {
        Some(levels) => levels.clone(),
        None => round_levels(field.as_slice(), ABOUT)?,
    };
    let sets = session.phase("isolines", || isolines(mesh, field, &levels))?;
    let curves: SurfaceCurves =
        SurfaceCurves { curves: sets.into_iter().flat_map(|s| s.curves).collect(), points: Vec::new() };
    if curves.is_empty() {
        let sentence =
            format!("the file has no isolines: the distance reaches none of the {} levels", levels.len());
        session.warn(Warned::new("no_isolines", sentence).about(path.display()));
    }
    let count = curves.curves.len();
    let lines = polylines(mesh, &curves.curves).map_err(|e| Failure::Failed(e.to_string()))?;
    let text = match IsolineFormat::of(path)? {
        IsolineFormat::Json => {
            format_curves(&CurveFile { curves, ..CurveFile::default() }, CurveFormat::Json, mesh)
        }
        IsolineFormat::Ply => ply_edges(&lines),
        IsolineFormat::Svg => svg_paths(&lines),
        IsolineFormat::Obj => obj_lines(&lines),
    };
    let text = text.map_err(|e| Failure::Usage(format!("{}: {e}", path.display())))?;
    session.report.result.insert("isoline_levels".into(), json!(levels));
    session.report.result.insert("isolines".into(), json!(count));
    session.output("isolines", path, text.into_bytes())?;
    Ok(asked)
}
