//! Output files of `eikona winding`.

use super::arguments::{OutputArguments, WindingArguments};
use crate::exit::Failure;
use crate::input::MeshInput;
use crate::make::output_curves;
use crate::numpy::npy;
use crate::picture::{self, draw};
use crate::session::Session;
use crate::warned::Warned;
use eikona::contour::{obj_lines, polylines};
use eikona::winding::{JumpLoop, Winding};
use eikona_mesh::io::{MeshFormat, MeshOut};
use eikona_mesh::{Curve, CurveFile, ElementId, Face, FileError, Provenance, SurfaceCurves, TriangleMesh};
use eikona_render::{ColorMap, Coloring, Levels, ScalarField, Scene, Values, label_color};
use std::fmt::Write as _;
use std::path::Path;

/// Formats of the outputs, from their file names.
#[derive(Clone, Copy, Debug)]
pub struct Formats {
    output: Option<MainFormat>,
    split: Option<MeshFormat>,
    input_labels: Option<TableFormat>,
}

/// Formats of the main output.
#[derive(Clone, Copy, Debug)]
enum MainFormat {
    /// Values per face.
    Faces,
    /// Texture coordinates per corner.
    Corners,
    /// The mesh cut open, with values per vertex.
    Split(MeshFormat),
    Table(TableFormat),
}

/// Formats without a mesh.
#[derive(Clone, Copy, Debug)]
enum TableFormat {
    Csv,
    Npy,
}

impl Formats {
    /// Determines the formats from the file names.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a format that the output does not support, with those it does.
    pub fn of(outputs: &OutputArguments) -> Result<Formats, Failure> {
        let wrong = |path: &Path, what: &str| Failure::Usage(format!("{}: {what}", path.display()));
        const MAIN: &str = "unsupported format for regions; use .ply, .vtp, .obj, .glb, .gltf, .csv or .npy";
        const SPLIT: &str = "unsupported format for the split mesh; use .ply, .vtp, .obj, .off, .stl, .glb \
         or .gltf";
        const TABLE: &str = "unsupported format for labels of the input faces; use .npy or .csv";
        let main = |path: &Path| match (table_format(path), MeshFormat::from_path(path)) {
            (Some(table), _) => Ok(MainFormat::Table(table)),
            (_, Some(MeshFormat::Ply | MeshFormat::Vtp)) => Ok(MainFormat::Faces),
            (_, Some(MeshFormat::Obj)) => Ok(MainFormat::Corners),
            (_, Some(format @ (MeshFormat::Glb | MeshFormat::Gltf))) => Ok(MainFormat::Split(format)),
            _ => Err(wrong(path, MAIN)),
        };
        let split = |path: &Path| MeshFormat::from_path(path).ok_or_else(|| wrong(path, SPLIT));
        let table = |path: &Path| table_format(path).ok_or_else(|| wrong(path, TABLE));
        for path in outputs.lines().into_iter().flatten() {
            if MeshFormat::from_path(path) != Some(MeshFormat::Obj) {
                return Err(wrong(path, "unsupported format for loops and parts of the curve; use .obj"));
            }
        }
        Ok(Formats {
            output: outputs.output.as_deref().map(main).transpose()?,
            split: outputs.split.as_deref().map(split).transpose()?,
            input_labels: outputs.input_labels.as_deref().map(table).transpose()?,
        })
    }
}

fn table_format(path: &Path) -> Option<TableFormat> {
    let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "csv" => Some(TableFormat::Csv),
        "npy" => Some(TableFormat::Npy),
        _ => None,
    }
}

/// Stages all requested outputs.
pub fn write_outputs(
    arguments: &WindingArguments,
    formats: &Formats,
    winding: &Winding,
    (input, curves): (&MeshInput, &SurfaceCurves),
    session: &mut Session,
) -> Result<(), Failure> {
    let outputs = &arguments.outputs;
    let of_file = input.provenance.then(&winding.provenance);
    if let (Some(path), Some(format)) = (&outputs.output, formats.output) {
        let same_faces = !winding.is_cut() && input.provenance.keeps_faces();
        if let (MainFormat::Table(_), None, false) = (format, &outputs.split, same_faces) {
            let sentence = format!(
                "this table indexes the {} faces of a mesh that is not being written: your mesh with {} \
                 faces {}; use -o OUT.ply to write mesh and labels together, or --input-labels for labels \
                 of your faces",
                winding.mesh.face_count(),
                input.file.mesh.face_count(),
                if winding.is_cut() { "was cut along the curves" } else { "was triangulated or repaired" }
            );
            session.warn(Warned::new("table_of_other_faces", sentence).about(path.display()));
        }
        match format {
            MainFormat::Faces => write_faces(path, winding, &of_file, session)?,
            MainFormat::Corners => write_corners(path, winding, session)?,
            MainFormat::Split(format) => write_split("regions", path, format, (winding, &of_file), session)?,
            MainFormat::Table(TableFormat::Npy) => {
                session.output("regions", path, npy_of_labels(winding.labels.as_slice())?)?;
            }
            MainFormat::Table(TableFormat::Csv) => {
                session.output("regions", path, csv_of_regions(winding, &of_file).into_bytes())?;
            }
        }
    }
    if let (Some(path), Some(format)) = (&outputs.split, formats.split) {
        write_split("split mesh", path, format, (winding, &of_file), session)?;
    }
    if let (Some(path), Some(format)) = (&outputs.input_labels, formats.input_labels) {
        let labels = winding.original_labels(&input.provenance).into_vec();
        if let Some(first) = labels.iter().position(Option::is_none) {
            let faces = match labels.iter().filter(|label| label.is_none()).count() {
                1 => "1 dropped face has".to_string(),
                dropped => format!("{dropped} dropped faces have"),
            };
            let instead = match format {
                TableFormat::Npy => format!("written as {NO_LABEL}"),
                TableFormat::Csv => "written as an empty field".into(),
            };
            let sentence = format!("{faces} no label (first: face {first}); {instead}");
            session.warn(
                Warned::new("faces_without_label", sentence)
                    .about(path.display())
                    .with("first", Face::from_index(first)),
            );
        }
        let bytes = match format {
            TableFormat::Npy => {
                npy_of_labels(&labels.iter().map(|label| label.unwrap_or(NO_LABEL)).collect::<Vec<_>>())?
            }
            TableFormat::Csv => {
                let mut text = String::from("face,label\n");
                for (f, label) in labels.iter().enumerate() {
                    let _ = writeln!(text, "{f},{}", label.map_or(String::new(), |label| label.to_string()));
                }
                text.into_bytes()
            }
        };
        session.output("labels", path, bytes)?;
    }
    let [bounding, nonbounding, bounding_part, nonbounding_part] = outputs.lines();
    for (path, curves) in [
        (bounding, curves_of(&winding.bounding_loops)),
        (nonbounding, curves_of(&winding.nonbounding_loops)),
        (bounding_part, winding.bounding_part()),
        (nonbounding_part, winding.nonbounding_part()),
    ] {
        if let Some(path) = path {
            let lines = polylines(&winding.mesh, &curves.curves).map_err(FileError::from);
            let text = lines.and_then(|lines| obj_lines(&lines));
            let mut text = text.map_err(|e| Failure::Failed(format!("{}: {e}", path.display())))?;
            if text.is_empty() {
                text.push_str("# no lines\n");
            }
            session.output("loops", path, text.into_bytes())?;
        }
    }
    if let (Some(path), Some(orientation)) = (&outputs.suggested, &winding.report.orientation) {
        let file = CurveFile { curves: orientation.suggested(curves), ..CurveFile::default() };
        output_curves(path, &file, &input.mesh, session)?;
    }
    if let Some(path) = &outputs.render {
        let labels: Vec<i64> = winding.labels.as_slice().iter().map(|&l| i64::from(l)).collect();
        let coloring = Coloring::Labels { labels: &labels, title: Some("winding number") };
        let mut scene = Scene::new(&winding.mesh, coloring);
        let borders = curves_of(&winding.bounding_loops);
        scene.drawings.extend(picture::borders(&winding.mesh, &borders)?);
        // The winding number lives on a mesh that may be cut; the curves name points of the input
        // mesh.
        scene.drawings.extend(picture::curves(&input.mesh, curves)?);
        let png = session.phase("render", || draw(scene, &arguments.picture))?;
        session.output("picture", path, png)?;
    }
    if let Some(path) = &outputs.render_values {
        let [numerator, denominator] = homogeneous(winding);
        let field = ScalarField {
            title: Some("winding number"),
            // A fixed map keeps 0 white, and gives +1 and -1 the colours of regions.
            color_map: Some(ColorMap::signed()),
            ..ScalarField::new(Values::Quotient { numerator: &numerator, denominator: &denominator })
        };
        let mut scene = Scene::new(&winding.mesh, Coloring::Field(field));
        scene.drawings.extend(levels_between_integers(&numerator).map(picture::isolines));
        scene.drawings.extend(picture::curves(&input.mesh, curves)?);
        let png = session.phase("render", || draw(scene, &arguments.picture))?;
        session.output("picture", path, png)?;
    }
    Ok(())
}

fn curves_of(loops: &[JumpLoop]) -> SurfaceCurves {
    let curve = |l: &JumpLoop| Curve::signed(l.vertices.iter().copied());
    SurfaceCurves { curves: loops.iter().map(curve).collect(), points: Vec::new() }
}

/// Homogeneous winding number per corner, to be interpolated linearly and divided per pixel: the
/// value and 1, or 0 and 0 where it has no value (endpoints). Shifted so that labels are the
/// rounded values.
fn homogeneous(winding: &Winding) -> [Vec<f64>; 2] {
    let shift = |corner: usize| winding.shift[winding.island.as_slice()[corner / 3] as usize];
    let values = winding.values.as_slice().iter().enumerate();
    let pairs = values.map(|(c, w)| if w.is_nan() { (0.0, 0.0) } else { (w + shift(c), 1.0) });
    let (numerator, denominator) = pairs.unzip();
    [numerator, denominator]
}

/// Multiples of 0.1 without integers: regions have integer values up to rounding, which isolines
/// would show.
fn levels_between_integers(values: &[f64]) -> Option<Levels> {
    const MOST: f64 = 50.0;
    let (low, high) = values.iter().fold((0.0f64, 0.0f64), |(l, h), &w| (l.min(w), h.max(w)));
    let whole = (low.floor(), high.ceil());
    if whole.1 - whole.0 > MOST {
        return None;
    }
    let units = (whole.0 as i64)..(whole.1 as i64);
    Some(Levels::Values(units.flat_map(|n| (1..10).map(move |i| n as f64 + 0.1 * f64::from(i))).collect()))
}

/// Label of a dropped face in integer files: the smallest int32, which is far from any label.
const NO_LABEL: i32 = i32::MIN;

/// Labels and faces of the file per face.
fn as_numbers(winding: &Winding, of_file: &Provenance) -> [Vec<f64>; 2] {
    let labels = winding.labels.as_slice().iter().map(|&l| f64::from(l)).collect();
    [labels, of_file.face_parents().map(|f| f.index() as f64).collect()]
}

fn csv_of_regions(winding: &Winding, of_file: &Provenance) -> String {
    let mut text = String::from("label,margin,parent\n");
    for ((label, margin), parent) in
        winding.labels.as_slice().iter().zip(winding.margin.as_slice()).zip(of_file.face_parents())
    {
        let _ = writeln!(text, "{label},{margin},{}", parent.index());
    }
    text
}

fn write_faces(
    path: &Path,
    winding: &Winding,
    of_file: &Provenance,
    session: &mut Session,
) -> Result<(), Failure> {
    let [labels, parents] = as_numbers(winding, of_file);
    let margin = winding.margin.as_slice();
    let mut out = MeshOut::from(&winding.mesh);
    out.face_scalars = vec![("label", &labels), ("margin", margin), ("parent", &parents)];
    session.mesh_output("regions", path, None, &out)
}

fn write_corners(path: &Path, winding: &Winding, session: &mut Session) -> Result<(), Failure> {
    let [numerator, denominator] = homogeneous(winding);
    let uvs: Vec<[f64; 2]> = numerator.into_iter().zip(denominator).map(|(u, v)| [u, v]).collect();
    let mut out = MeshOut::from(&winding.mesh);
    out.corner_uvs = Some(&uvs);
    session.mesh_output("regions", path, None, &out)
}

/// NumPy file of int32, shape (n,).
fn npy_of_labels(labels: &[i32]) -> Result<Vec<u8>, Failure> {
    npy(&[labels.len()], labels).map_err(Failure::encoding)
}

/// Writes the mesh cut open, with all data that the format can store.
fn write_split(
    kind: &'static str,
    path: &Path,
    format: MeshFormat,
    (winding, of_file): (&Winding, &Provenance),
    session: &mut Session,
) -> Result<(), Failure> {
    let split = winding.split().map_err(|e| Failure::Failed(format!("{}: {e}", path.display())))?;
    let [labels, parents] = as_numbers(winding, of_file);
    let at_vertices = labels_at_vertices(&split.mesh, winding);
    let colours: Vec<[u8; 3]> = at_vertices.iter().map(|&label| label_color(i64::from(label))).collect();
    let at_vertices: Vec<f64> = at_vertices.into_iter().map(f64::from).collect();
    let mut out = MeshOut::from(&split.mesh);
    match format {
        MeshFormat::Ply | MeshFormat::Vtp => {
            out.face_scalars = vec![("label", &labels), ("parent", &parents)]
        }
        MeshFormat::Glb | MeshFormat::Gltf => out.vertex_scalars = vec![("label", &at_vertices)],
        MeshFormat::Obj | MeshFormat::Off | MeshFormat::Stl => {}
    }
    out.vertex_colours = (format != MeshFormat::Stl).then_some(&colours);
    session.mesh_output(kind, path, None, &out)
}

/// Labels per vertex of a split mesh, whose faces agree at each vertex. Unreferenced vertices get
/// 0.
fn labels_at_vertices(split: &TriangleMesh, winding: &Winding) -> Vec<i32> {
    let label = |v| split.vertex_corners(v).first().map_or(0, |c| winding.labels[c.face()]);
    split.vertices().map(label).collect()
}
