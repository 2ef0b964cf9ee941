//! `eikona render`: draws a mesh with a field of its file and curves.

use crate::direction_files::read_directions;
use crate::directions::{marks, points_of, polylines, singular_points, streamlines};
use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::number::above_zero;
use crate::picture::{PictureArguments, check_picture_path, curves, draw, isolines};
use crate::session::{General, Session, check_outputs};
use crate::source::{SourceArguments, files_read, read_source_if_any};
use crate::stored_field::{is_stored_field, read_stored_field, restored_field};
use crate::warned::Warned;
use clap::Args;
use eikona::polar_field::{StreamlineOptions, inspect_field};
use eikona_mesh::io::read_mesh;
use eikona_mesh::{SurfaceCurves, TriangleMesh};
use eikona_render::{ColorMap, Coloring, Drawing, Levels, ScalarField, Scene, Values};
use std::path::{Path, PathBuf};

/// Arguments of `eikona render`.
#[derive(Args, Clone, Debug)]
// These options are always refused, so the help hides them.
#[command(mut_arg("flip", |arg| arg.hide(true)), mut_arg("unsigned", |arg| arg.hide(true)))]
#[command(after_help = "Example (the first two lines make the files):
  eikona make torus -o torus.ply
  eikona sdf torus.ply --points 0 -o distance.ply
  eikona render distance.ply -o distance.png --field distance --isolines 30 --up z --size 800x600")]
pub struct RenderArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    /// Output picture; - for standard output
    #[arg(short, long, value_name = "PNG")]
    pub output: PathBuf,
    /// Field of the file to show, or none [default: distance, else quality, else the first field];
    /// uv-quotient divides the texture coordinates u / v of an OBJ file per pixel (as written by
    /// `eikona winding -o OUT.obj`)
    #[arg(long, value_name = "NAME")]
    pub field: Option<String>,
    /// Approximate number of isolines; 0 for none [default: 18; 0 for uv-quotient]
    #[arg(long, value_name = "N", conflicts_with = "spacing", allow_negative_numbers = true)]
    pub isolines: Option<u32>,
    /// Draw isolines at all multiples of D
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = above_zero)]
    pub spacing: Option<f64>,
    /// Draw directions and their singular points: N vectors per face (.rawfield, .rosy, .csv, .npy)
    /// as marks, or a field that `eikona field -o` wrote (.npz, .json) as streamlines
    #[arg(long, value_name = "FIELD")]
    pub directions: Option<PathBuf>,
    /// Draw the polylines of a file, such as streamlines
    #[arg(long, value_name = "L.obj")]
    pub lines: Option<PathBuf>,
    #[command(flatten)]
    pub source: SourceArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &RenderArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("render", general);
    check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    let shown = choose_field(&input, arguments.field.as_deref())?;
    warn_of_idle(arguments, &shown, &mut session);
    let source = read_curves(arguments, &input, &mut session)?;
    // Rounding would cover regions of constant value with isolines.
    let default = if matches!(shown, Shown::Quotient(_)) { 0 } else { 18 };
    let levels = match (arguments.spacing, arguments.isolines.or(Some(default))) {
        (Some(spacing), _) => Some(Levels::Spacing(spacing)),
        (None, Some(0)) => None,
        (None, Some(count)) => Some(Levels::About(count)),
        (None, None) => None,
    };
    let mut scene = Scene::new(&input.mesh, shown.coloring());
    if matches!(shown, Shown::Vertex(..) | Shown::Quotient(_)) {
        scene.drawings.extend(levels.map(isolines));
    }
    if let Some(path) = &arguments.directions {
        scene.drawings.extend(directions(path, &input.mesh, &mut session)?);
    }
    if let Some(path) = &arguments.lines {
        scene.drawings.extend(lines(path)?);
    }
    if let Some(source) = &source {
        scene.drawings.extend(curves(&input.mesh, source)?);
    }
    let png = session.phase("render", || draw(scene, &arguments.picture))?;
    session.output("picture", &arguments.output, png)?;
    session.finish()
}

/// Checks the arguments before any work.
fn check_arguments(arguments: &RenderArguments, general: &General) -> Result<(), Failure> {
    let outputs: Vec<&Path> =
        [Some(arguments.output.as_path()), general.report.as_deref()].into_iter().flatten().collect();
    let mut inputs = files_read(&arguments.mesh, &arguments.source);
    inputs.extend([&arguments.directions, &arguments.lines].into_iter().flatten().map(PathBuf::as_path));
    check_outputs(&outputs, &inputs)?;
    check_picture_path(&arguments.output)?;
    if let Some(flag) = arguments.source.about_sides().first() {
        return Err(Failure::Usage(format!(
            "{flag}: pictures do not show the sides of curves; leave it out, or pass it to eikona sdf"
        )));
    }
    if arguments.field.as_deref() == Some("none")
        && let Some(flag) = arguments.isoline_flag().or(arguments.picture.about_values())
    {
        return Err(Failure::Usage(format!(
            "{flag} needs a field, but --field none shows none; leave one of them out"
        )));
    }
    Ok(())
}

impl RenderArguments {
    /// The option that requests isolines, if given.
    fn isoline_flag(&self) -> Option<&'static str> {
        let counted = self.isolines.filter(|count| *count > 0).map(|_| "--isolines");
        self.spacing.map(|_| "--spacing").or(counted)
    }
}

/// Warns of options that have no effect on this file.
fn warn_of_idle(arguments: &RenderArguments, shown: &Shown, session: &mut Session) {
    let isolines = arguments.isoline_flag();
    match shown {
        Shown::Nothing if arguments.field.is_none() => {
            for flag in isolines.into_iter().chain(arguments.picture.about_values()) {
                let sentence = format!("{flag} has no effect: the file has no field to show");
                session.warn(Warned::new("idle_option", sentence));
            }
        }
        Shown::Face(name, _) => {
            if let Some(flag) = isolines {
                let sentence = format!(
                    "{flag} has no effect: the field {name} has one value per face, but isolines need one per vertex"
                );
                session.warn(Warned::new("idle_option", sentence));
            }
        }
        _ => {}
    }
}

fn read_curves(
    arguments: &RenderArguments,
    input: &MeshInput,
    session: &mut Session,
) -> Result<Option<SurfaceCurves>, Failure> {
    Ok(read_source_if_any(&arguments.source, input, session)?.map(|(curves, _)| curves))
}

/// Angle in radians between a vector and its face that is warned of. Other programs may take means
/// over several faces.
const FLAT: f64 = 0.5;

/// Reads and draws directions.
fn directions(
    path: &Path,
    mesh: &TriangleMesh,
    session: &mut Session,
) -> Result<Vec<Drawing<'static>>, Failure> {
    if is_stored_field(path) {
        let data = read_stored_field(path)?;
        let field = session.solver("restore", || restored_field(path, mesh, &data))?;
        let lines = session.solver("streamlines", || field.streamlines(&StreamlineOptions::default()))?;
        let mut drawings = streamlines(&field, &lines);
        drawings.extend(singular_points(&points_of(&field), field.degree()));
        return Ok(drawings);
    }
    let field = read_directions(path, None, mesh)?;
    let seen = session.solver("inspection", || inspect_field(mesh, &field))?;
    let (angle, face) = seen.out_of_plane;
    if let Some(face) = face.filter(|_| angle > FLAT) {
        let sentence = format!(
            "{}: a vector is {:.0} degrees out of the plane of its face ({face}); check that the field belongs to \
             this mesh",
            path.display(),
            angle.to_degrees()
        );
        session.warn(Warned::new("vectors_out_of_plane", sentence));
    }
    let points: Vec<([f64; 3], f64)> =
        seen.vertices.iter().map(|&(v, index)| (mesh.position(v), index)).collect();
    let mut drawings = vec![marks(mesh, &field)];
    drawings.extend(singular_points(&points, field.degree));
    Ok(drawings)
}

/// Reads and draws polylines.
fn lines(path: &Path) -> Result<Vec<Drawing<'static>>, Failure> {
    let file = read_mesh(path).map_err(|fault| Failure::reading(path, fault))?;
    if file.lines.is_empty() {
        return Err(Failure::Input(format!(
            "{}: this file has no polylines; give the L.obj of eikona field --streamlines, say",
            path.display()
        )));
    }
    let positions = |line: &Vec<u32>| line.iter().map(|&v| file.mesh.positions[v as usize]).collect();
    Ok(polylines(file.lines.iter().map(positions), None))
}

enum Shown<'a> {
    Vertex(&'a str, Vec<f64>),
    Face(&'a str, &'a [f64]),
    /// Numerators and denominators per corner.
    Quotient([Vec<f64>; 2]),
    Nothing,
}

impl Shown<'_> {
    fn coloring(&self) -> Coloring<'_> {
        let field = match self {
            Shown::Vertex(name, values) => {
                ScalarField { title: Some(name), ..ScalarField::new(Values::PerVertex(values)) }
            }
            Shown::Face(name, values) => {
                ScalarField { title: Some(name), ..ScalarField::new(Values::PerFace(values)) }
            }
            Shown::Quotient([numerator, denominator]) => ScalarField {
                title: Some(UV_QUOTIENT),
                color_map: Some(ColorMap::signed()),
                ..ScalarField::new(Values::Quotient { numerator, denominator })
            },
            Shown::Nothing => return Coloring::default(),
        };
        Coloring::Field(field)
    }
}

const UV_QUOTIENT: &str = "uv-quotient";

/// Shown only on request: these describe the appearance of the surface, not a result.
const APPEARANCE: [&str; 10] = ["nx", "ny", "nz", "red", "green", "blue", "alpha", "s", "t", "u"];

fn choose_field<'a>(input: &'a MeshInput, wanted: Option<&str>) -> Result<Shown<'a>, Failure> {
    let vertex = |(name, values): &'a (String, Vec<f64>)| Shown::Vertex(name, input.vertex_values(values));
    let scalars = &input.file.vertex_scalars;
    let Some(wanted) = wanted else {
        let by_name = |name: &str| scalars.iter().find(|s| s.0.eq_ignore_ascii_case(name));
        let first = || scalars.iter().find(|s| !APPEARANCE.contains(&s.0.as_str()));
        let chosen = by_name("distance").or_else(|| by_name("quality")).or_else(first);
        return Ok(chosen.map_or(Shown::Nothing, vertex));
    };
    if wanted == "none" {
        return Ok(Shown::Nothing);
    }
    if let Some(found) = scalars.iter().find(|s| s.0 == wanted) {
        return Ok(vertex(found));
    }
    if let Some((name, values)) = input.file.face_scalars.iter().find(|s| s.0 == wanted) {
        if values.len() != input.mesh.face_count() {
            return Err(Failure::Input(format!(
                "{}: the field {wanted} has one value per face for {} faces, but the faces were \
                 triangulated, split or dropped; show a field with one value per vertex",
                input.path.display(),
                values.len()
            )));
        }
        return Ok(Shown::Face(name, values));
    }
    if wanted == UV_QUOTIENT
        && let Some(uvs) = &input.file.corner_uvs
    {
        if uvs.len() != 3 * input.mesh.face_count() || !input.file.mesh.is_triangular() {
            return Err(Failure::Input(format!(
                "{}: the {} texture coordinates belong to corners of faces that were triangulated, split or \
                 dropped; give triangles",
                input.path.display(),
                uvs.len()
            )));
        }
        let (u, v) = uvs.iter().map(|uv| (uv[0], uv[1])).unzip();
        return Ok(Shown::Quotient([u, v]));
    }
    let of_texture = input.file.corner_uvs.iter().map(|_| UV_QUOTIENT);
    let names: Vec<&str> =
        scalars.iter().chain(&input.file.face_scalars).map(|s| s.0.as_str()).chain(of_texture).collect();
    let known = if names.is_empty() { "none".to_string() } else { names.join(", ") };
    Err(Failure::Input(format!(
        "{}: this file has no field {wanted:?}; its fields are: {known}",
        input.path.display()
    )))
}
