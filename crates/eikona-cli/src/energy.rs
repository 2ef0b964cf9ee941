//! `eikona energy`: the tangent-point energy of a mesh, and where it is concentrated.

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::picture::colours;
use crate::quadrature::QuadratureKind;
use crate::session::{General, Session, check_outputs};
use clap::Args;
use eikona::repulsive::{
    EnergyOptions, Exponents, Pairs, Quadrature, TangentPointEnergy, tangent_point_energy,
};
use eikona_mesh::io::{MeshFormat, MeshOut};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `eikona energy`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the mesh):
  eikona make torus -o torus.ply
  eikona energy torus.ply --density density.ply

The energy is that of Yu, Brakensiek, Schumacher and Crane (2021): the sum over ordered pairs of different faces of
|n.v|^alpha / |v|^beta times both areas, where v joins the centroids and n is the first face's normal.")]
pub struct EnergyArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    /// The exponent p, above 2: alpha = p, beta = 2p [default: 6]
    #[arg(long, value_name = "P", allow_hyphen_values = true, conflicts_with_all = ["alpha", "beta"], help_heading = "Method")]
    pub p: Option<f64>,
    /// The exponent of the distance from the tangent plane
    #[arg(long, value_name = "A", allow_hyphen_values = true, requires = "beta", help_heading = "Method")]
    pub alpha: Option<f64>,
    /// The exponent of the distance
    #[arg(long, value_name = "B", allow_hyphen_values = true, requires = "alpha", help_heading = "Method")]
    pub beta: Option<f64>,
    /// Sum over all pairs of faces, without clusters: the time grows with the square of the faces,
    /// to half a minute per thread at 50,000 faces
    #[arg(long, help_heading = "Method")]
    pub all_pairs: bool,
    /// How the energy of two faces is integrated: midpoint, as published, or adaptive (subdivided
    /// where they are close) [default: midpoint]
    #[arg(
        long,
        value_name = "midpoint|adaptive",
        value_enum,
        hide_possible_values = true,
        help_heading = "Method"
    )]
    pub quadrature: Option<QuadratureKind>,
    /// Write the mesh with the energy per area of each face (.ply, .vtp)
    #[arg(long, value_name = "D.ply", help_heading = "Outputs")]
    pub density: Option<PathBuf>,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &EnergyArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("energy", general);
    let outputs: Vec<&Path> =
        [arguments.density.as_deref(), general.report.as_deref()].into_iter().flatten().collect();
    check_outputs(&outputs, &[&arguments.mesh.mesh])?;
    arguments.density.as_deref().map_or(Ok(()), check_density_path)?;
    let exponents = match (arguments.p, arguments.alpha.zip(arguments.beta)) {
        (Some(p), _) => Exponents::of_power(p)?,
        (None, Some((alpha, beta))) => Exponents::new(alpha, beta)?,
        (None, None) => Exponents::default(),
    };
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    let pairs = if arguments.all_pairs { Pairs::All } else { Pairs::Hierarchical };
    let quadrature = arguments.quadrature.map_or(Quadrature::Midpoint, Into::into);
    let options = EnergyOptions::default()
        .with_exponents(exponents)
        .with_pairs(pairs)
        .with_quadrature(quadrature)
        .with_threads(session.threads());
    session.report.options.extend(
        [
            ("alpha", json!(exponents.alpha)),
            ("beta", json!(exponents.beta)),
            ("quadrature", json!(quadrature)),
            ("threads", json!(options.threads)),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    let started = Instant::now();
    let energy = session.solver("energy", || tangent_point_energy(&input.mesh, &options))?;
    session.report.phase("energy", started.elapsed());
    session.report.result.extend(
        [("energy", json!(energy.value)), ("gradient_norm", json!(energy.gradient_norm()))]
            .map(|(key, value)| (key.to_string(), value)),
    );
    session.note(&format!(
        "energy {} with alpha = {}, beta = {}; norm of its differential {}",
        energy.value,
        exponents.alpha,
        exponents.beta,
        energy.gradient_norm()
    ));
    if let Some(path) = &arguments.density {
        output_density(path, &input, &energy, &mut session)?;
    }
    session.finish()
}

fn check_density_path(path: &Path) -> Result<(), Failure> {
    match MeshFormat::from_path(path) {
        Some(MeshFormat::Ply | MeshFormat::Vtp) => Ok(()),
        _ => Err(Failure::Usage(format!(
            "{}: values per face go into .ply and .vtp files; use one of them",
            path.display()
        ))),
    }
}

/// Writes the mesh with the density per face, and its logarithm as colours per vertex.
fn output_density(
    path: &Path,
    input: &MeshInput,
    energy: &TangentPointEnergy,
    session: &mut Session,
) -> Result<(), Failure> {
    let mesh = &input.mesh;
    let mut out = MeshOut::from(mesh);
    let of_vertex = |v| {
        let corners = mesh.vertex_corners(v);
        let sum: f64 = corners.iter().map(|corner| energy.density[corner.face()]).sum();
        (sum / corners.len().max(1) as f64).max(f64::MIN_POSITIVE).ln()
    };
    let logarithms: Vec<f64> = mesh.vertices().map(of_vertex).collect();
    let highest = logarithms.iter().copied().fold(f64::MIN, f64::max);
    // Relative to the highest, since values of both signs have another colour map.
    let shown = colours(&logarithms.iter().map(|x| x - highest).collect::<Vec<f64>>());
    out.vertex_colours = Some(&shown);
    out.face_scalars = vec![("energy_density", energy.density.as_slice())];
    session.mesh_output("density", path, None, &out)?;
    session.name_fields(["energy_density"].into_iter());
    Ok(())
}
