//! Steps 1 to 10 of algorithm 1, for jumps at edges.

use crate::operators::{darboux_derivative, differences, solve_jump_equation};
use crate::phases::Running;
use crate::winding::coordinates::Coordinates;
use crate::winding::corner_values::{integrated_in_faces, jumps_of};
use crate::winding::error::WindingError;
use crate::winding::islands::Islands;
use crate::winding::labels::{Labels, labels};
use crate::winding::nonbounding::nonbounding_part;
use crate::winding::options::{Completion, WindingOptions};
use crate::winding::solution::ProgramReport;
use crate::winding::surface::{Prepared, Surface};
use eikona_mesh::{Edge, TriangleMesh, Vertex};
use eikona_numeric::check_stopped;

/// Results of the steps for jumps at edges.
pub(super) struct Found {
    pub coordinates: Coordinates,
    pub excluded: Vec<bool>,
    pub values: Vec<f64>,
    pub nonbounding: Vec<f64>,
    pub residual_function: Vec<f64>,
    pub islands: Islands,
    pub labels: Labels,
    pub residual: f64,
    pub program: Option<ProgramReport>,
    pub relaxed: Vec<Edge>,
}

/// Harmonic forms below this are rounding errors (jumps are integers): every part of the curve
/// bounds.
const NO_HARMONIC_PART: f64 = 1e-9;

/// At vertices with several fans, smaller jumps fade out instead of making the value undefined:
/// better on meshes full of such vertices.
const FADES: f64 = 0.01;

/// Runs steps 1 to 10 and computes labels, for jumps at edges.
pub(super) fn solve_chain(
    surface: &Surface,
    curve: &[i32],
    options: &WindingOptions,
    phases: &mut Running,
) -> Result<Found, WindingError> {
    let mesh = &surface.mesh;
    let jump: Vec<f64> = curve.iter().map(|&j| f64::from(j)).collect();
    let mut coordinates = Coordinates::of(mesh, &jump, 0.5);
    let mut excluded = vec![false; mesh.vertex_count()];
    coordinates.left_out().for_each(|v| excluded[v.index()] = true);
    phases.next("factorisation")?;
    let mut prepared = surface.prepared(&excluded, options.intrinsic_delaunay)?;
    phases.next("jump equation")?;
    let (mut values, derivative, mut residual) =
        jump_function(mesh, &prepared, &excluded, &coordinates.corner)?;

    let harmonic = if surface.simply_connected {
        None
    } else {
        phases.next("harmonic part")?;
        harmonic_part(surface, &prepared, &excluded, &values, derivative)?
    };
    let mut nonbounding = vec![0.0; mesh.edge_count()];
    let mut residual_function = vec![0.0; 3 * mesh.face_count()];
    let (mut program, mut relaxed) = (None, Vec::new());
    if let Some(harmonic) = harmonic {
        phases.next("linear program")?;
        residual = residual.max(harmonic.residual);
        // Without endpoints the jumps are exactly those of the curve.
        check_stopped()?;
        let shift = if harmonic.is_whole { jump.clone() } else { jumps_of(mesh, &harmonic.in_faces) };
        let part = nonbounding_part(mesh, &surface.triangles, curve, &shift, options.epsilon)?;
        for (corner, value) in residual_function.iter_mut().enumerate() {
            *value = harmonic.in_faces[corner] + part.shift_of_face[corner / 3];
        }
        (nonbounding, relaxed) = (part.jump, part.relaxed);
        program = Some(part.report.in_unit(surface.unit));
        phases.next("second jump equation")?;

        let rest: Vec<f64> = jump.iter().zip(&nonbounding).map(|(j, t)| j - t).collect();
        check_stopped()?;
        let corrected = corrected(mesh, &mut coordinates, &mut excluded, curve, &rest, options.completion);
        check_stopped()?;
        // Jumps that end inside the surface have no derivative 1-form that flips could carry.
        let delaunay = options.intrinsic_delaunay && options.completion == Completion::Full;
        if corrected.leaves_out_more || delaunay != options.intrinsic_delaunay {
            prepared = surface.prepared(&excluded, delaunay)?;
        }
        let second;
        (values, _, second) = jump_function(mesh, &prepared, &excluded, &corrected.corner)?;
        residual = residual.max(second);
    }

    phases.next("labels")?;
    let islands = Islands::of(mesh, &prepared.on.triangulation, &excluded);
    check_stopped()?;
    let labels = labels(mesh, &surface.triangles, &islands, &values, curve, &nonbounding, options.reference);
    drop(prepared);
    Ok(Found {
        coordinates,
        excluded,
        values,
        nonbounding,
        residual_function,
        islands,
        labels,
        residual,
        program,
        relaxed,
    })
}

/// Steps 3 to 6: the harmonic part of the derivative; `None` if it vanishes.
fn harmonic_part(
    surface: &Surface,
    prepared: &Prepared,
    excluded: &[bool],
    values: &[f64],
    derivative: Vec<f64>,
) -> Result<Option<Harmonic>, WindingError> {
    let is_whole = !excluded.contains(&true);
    let triangulation = &prepared.on.triangulation;
    let (mut form, mut residual) = (derivative, 0.0);
    if !is_whole {
        (form, residual) = prepared.on.hodge(&surface.mesh)?.harmonic_part(triangulation, &form)?;
    }
    check_stopped()?;
    if form.iter().all(|x| x.abs() <= NO_HARMONIC_PART) {
        return Ok(None);
    }
    // Without endpoints the derivative is already harmonic.
    let in_faces = if is_whole {
        values.to_vec()
    } else {
        triangulation.form_to_mesh(&mut form);
        integrated_in_faces(&form)
    };
    Ok(Some(Harmonic { in_faces, is_whole, residual }))
}

/// Computes reduced coordinates of the curve without its nonbounding part (algorithm 8, with the
/// running sum that it omits). The curve keeps its endpoints, as the subtracted part is closed.
/// Vertices of several fans are excluded, too, where more than a trace of a jump reaches them.
fn corrected(
    mesh: &TriangleMesh,
    before: &mut Coordinates,
    excluded: &mut [bool],
    curve: &[i32],
    rest: &[f64],
    completion: Completion,
) -> Corrected {
    let Coordinates { mut corner, not_fans, .. } = Coordinates::of(mesh, rest, f64::INFINITY);
    let mut clear = |v: Vertex| mesh.vertex_corners(v).iter().for_each(|c| corner[c.index()] = 0.0);
    before.left_out().for_each(&mut clear);
    let mut leaves_out_more = false;
    if completion == Completion::Curve {
        let mut touched = vec![false; mesh.vertex_count()];
        for e in mesh.edges().filter(|e| curve[e.index()] != 0) {
            mesh.edge_vertices(e).into_iter().for_each(|v| touched[v.index()] = true);
        }
        mesh.vertices().filter(|v| !touched[v.index()]).for_each(clear);
    } else {
        let jumps = |v: &Vertex| {
            let corners = mesh.vertex_corners(*v).iter();
            let mut sides = corners.flat_map(|c| [c.halfedge(), c.halfedge().previous()]);
            sides.any(|h| rest[mesh.edge(h).index()].abs() > FADES)
        };
        for v in not_fans.into_iter().filter(jumps) {
            if !std::mem::replace(&mut excluded[v.index()], true) {
                before.not_fans.push(v);
                leaves_out_more = true;
            }
        }
    }
    Corrected { corner, leaves_out_more }
}

/// The harmonic part of the jump function's derivative.
struct Harmonic {
    /// Integrated in every face, at its corners.
    in_faces: Vec<f64>,
    /// Whether the curve has no endpoints, so that the jumps are exactly the curve's.
    is_whole: bool,
    residual: f64,
}

/// Coordinates at corners, and whether further vertices have lost theirs.
struct Corrected {
    corner: Vec<f64>,
    leaves_out_more: bool,
}

/// Solves for the smoothest function with these coordinates at corners (eq. 10). Returns the
/// function, NaN at excluded vertices; its derivative along the halfedges of the operators'
/// triangulation; and the relative residual.
fn jump_function(
    mesh: &TriangleMesh,
    Prepared { on, factor }: &Prepared,
    excluded: &[bool],
    coordinates: &[f64],
) -> Result<(Vec<f64>, Vec<f64>, f64), WindingError> {
    let mut differences = differences(coordinates);
    check_stopped()?;
    on.triangulation.form_from_mesh(&mut differences);
    check_stopped()?;
    let (base, residual) = solve_jump_equation(&on.triangulation, factor, excluded, &differences)?;
    check_stopped()?;
    let derivative = darboux_derivative(&on.triangulation, excluded, &base, &differences);
    check_stopped()?;
    let value = |(&v, c): (&u32, &f64)| if excluded[v as usize] { f64::NAN } else { base[v as usize] + c };
    let values = mesh.triangles().iter().flatten().zip(coordinates).map(value).collect();
    Ok((values, derivative, residual))
}
