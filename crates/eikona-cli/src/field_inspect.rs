//! `eikona field-inspect`: signed indices, turning, smoothness and curl of anybody's field.

use crate::direction_files::{read_directions, read_matching};
use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::number::fraction;
use crate::session::{General, Session, check_outputs, print_bytes};
use clap::Args;
use eikona::polar_field::{FaceVectors, FieldInspection, inspect_field};
use eikona_mesh::{Edge, Face, counted};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Arguments of `eikona field-inspect`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first two lines make the files):
  eikona make torus -o torus.ply
  eikona field torus.ply --auto -o cross.rawfield
  eikona field-inspect cross.rawfield torus.ply")]
pub struct FieldInspectArguments {
    /// Field of N vectors per face: .rawfield (Directional), .rosy (QuadWild), .csv of
    /// `eikona field`, or .npy of shape (F, N, 3)
    #[arg(value_name = "FIELD")]
    pub field: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArguments,
    /// Fail unless the field has N directions
    #[arg(short = 'n', long, value_name = "N")]
    pub degree: Option<u32>,
    /// How the vectors of neighbouring faces continue each other: .matching (Directional). Without
    /// it, by the smallest rotation
    #[arg(long, value_name = "M.matching")]
    pub matching: Option<PathBuf>,
    /// Print JSON to standard output
    #[arg(long)]
    pub json: bool,
    /// List all elements rather than the first 5 of each kind
    #[arg(long)]
    pub all: bool,
}

/// Number of elements listed per kind without `--all`.
const SHOWN: usize = 5;

/// Runs the command and returns the exit code.
pub fn run(arguments: &FieldInspectArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("field-inspect", general);
    let given = [Some(&arguments.field), Some(&arguments.mesh.mesh), arguments.matching.as_ref()];
    let files: Vec<_> = given.into_iter().flatten().map(PathBuf::as_path).collect();
    check_outputs(general.report.as_deref().as_slice(), &files)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    let mut field = read_directions(&arguments.field, arguments.degree, &input.mesh)?;
    if let Some(path) = &arguments.matching {
        field.matching = read_matching(path, field.degree)?;
    }
    let seen = session.solver("inspection", || inspect_field(&input.mesh, &field))?;
    let facts = facts(&seen, field.degree);
    session.report.result = facts.clone();
    let text = match arguments.json {
        true => serde_json::to_string_pretty(&facts).unwrap_or_default() + "\n",
        false => text(&seen, &field, if arguments.all { usize::MAX } else { SHOWN }),
    };
    print_bytes(text.as_bytes())?;
    session.finish()
}

fn shown<T: ToString>(elements: &[T], most: usize) -> String {
    let names: Vec<String> = elements.iter().take(most).map(T::to_string).collect();
    let more = elements.len().saturating_sub(most);
    names.join(", ") + &if more > 0 { format!(" and {more} more (--all)") } else { String::new() }
}

fn text(seen: &FieldInspection, field: &FaceVectors, most: usize) -> String {
    let degree = field.degree;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "field       {} per face, {}",
        counted(degree as usize, "vector", "vectors"),
        if field.matching.is_empty() { "matched by the smallest rotation" } else { "matched as given" }
    );
    let singular: Vec<String> =
        seen.vertices.iter().map(|(v, index)| format!("{v} ({})", fraction(*index, degree))).collect();
    let _ = writeln!(
        text,
        "singular    {}{}",
        counted(singular.len(), "vertex", "vertices"),
        if singular.is_empty() { String::new() } else { format!(": {}", shown(&singular, most)) }
    );
    for (b, index) in seen.boundaries.iter().enumerate() {
        let _ = writeln!(text, "            boundary loop {b} ({})", fraction(*index, degree));
    }
    let _ = writeln!(
        text,
        "index sum   {}, Euler characteristic {}",
        fraction(seen.index_sum, degree),
        seen.euler_characteristic
    );
    if seen.components.len() > 1 {
        for (c, (sum, euler)) in seen.components.iter().take(most).enumerate() {
            let sum = fraction(*sum, degree);
            let _ = writeln!(text, "            component {c}: {sum}, Euler characteristic {euler}");
        }
    }
    let at = |edge: Option<Edge>| edge.map_or(String::new(), |e| format!(" at {e}"));
    let _ = writeln!(
        text,
        "turning     up to {:.2} degrees per edge{}, root mean square {:.2}",
        seen.largest_rotation.0.to_degrees(),
        at(seen.largest_rotation.1),
        seen.mean_rotation.to_degrees()
    );
    let _ =
        writeln!(text, "smoothness  {:.6e} (Dirichlet energy of the phase across edges)", seen.smoothness);
    let _ = writeln!(
        text,
        "curl        up to {:.3e}{}, root mean square {:.3e} (of the mean length)",
        seen.largest_curl.0,
        at(seen.largest_curl.1),
        seen.mean_curl
    );
    let mut warn = |count: usize, sentence: String| {
        if count > 0 {
            let _ = writeln!(text, "! {sentence}");
        }
    };
    warn(
        seen.ambiguous.len(),
        format!(
            "{} almost half a turn of the N-th power, so the indices at their ends may be others: {}; refine the mesh \
             there, or give --matching",
            counted(seen.ambiguous.len(), "edge turns by", "edges turn by"),
            shown(&seen.ambiguous, most)
        ),
    );
    let faces = |faces: &[Face]| shown(faces, most);
    let count = |faces: &[Face]| counted(faces.len(), "face has", "faces have");
    warn(seen.zero.len(), format!("{} a zero vector: {}", count(&seen.zero), faces(&seen.zero)));
    warn(
        seen.disordered.len(),
        format!(
            "{} vectors that are not counter-clockwise: {}; sort them by angle",
            count(&seen.disordered),
            faces(&seen.disordered)
        ),
    );
    warn(
        seen.asymmetric.len(),
        format!(
            "{} vectors of unequal lengths or spacing: {}",
            count(&seen.asymmetric),
            faces(&seen.asymmetric)
        ),
    );
    let (angle, face) = seen.out_of_plane;
    let is_out = angle > 0.01;
    warn(
        usize::from(is_out),
        format!(
            "vectors leave the plane of their face by up to {:.2} degrees ({})",
            angle.to_degrees(),
            face.map_or(String::new(), |f| f.to_string())
        ),
    );
    text
}

fn facts(seen: &FieldInspection, degree: u32) -> Map<String, Value> {
    let edge = |(value, edge): (f64, Option<Edge>)| json!({"value": value, "edge": edge.map(|e| e.0)});
    let faces = |faces: &[Face]| json!(faces.iter().map(|f| f.0).collect::<Vec<_>>());
    let vertices: Vec<Value> =
        seen.vertices.iter().map(|(v, index)| json!({"vertex": v.0, "index": index})).collect();
    [
        ("degree", json!(degree)),
        ("singular_vertices", json!(vertices)),
        ("boundaries", json!(seen.boundaries)),
        ("index_sum", json!(seen.index_sum)),
        ("euler_characteristic", json!(seen.euler_characteristic)),
        (
            "components",
            seen.components
                .iter()
                .map(|(sum, euler)| json!({"index_sum": sum, "euler_characteristic": euler}))
                .collect(),
        ),
        ("largest_rotation", edge(seen.largest_rotation)),
        ("mean_rotation", json!(seen.mean_rotation)),
        ("ambiguous_edges", json!(seen.ambiguous.iter().map(|e| e.0).collect::<Vec<_>>())),
        ("smoothness", json!(seen.smoothness)),
        ("largest_curl", edge(seen.largest_curl)),
        ("mean_curl", json!(seen.mean_curl)),
        ("zero_faces", faces(&seen.zero)),
        ("disordered_faces", faces(&seen.disordered)),
        ("asymmetric_faces", faces(&seen.asymmetric)),
        ("out_of_plane", json!({"angle": seen.out_of_plane.0, "face": seen.out_of_plane.1.map(|f| f.0)})),
    ]
    .map(|(key, value)| (key.to_string(), value))
    .into_iter()
    .collect()
}
