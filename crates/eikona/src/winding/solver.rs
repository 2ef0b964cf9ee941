//! The steps of the method, in order.

use crate::contour::side::consistently_wound;
use crate::geometry::{Triangle, lay_out, winding_is_consistent};
use crate::phases::Phases;
use crate::winding::chain::{Chain, Step};
use crate::winding::decomposition::{nonbounding_steps, polylines};
use crate::winding::error::WindingError;
use crate::winding::harmonic::{Hodge, darboux_derivative, integrated_in_faces, jumps_of};
use crate::winding::jump_laplace::{Coordinates, JumpLaplace, solve_jump_equation};
use crate::winding::labels::labels;
use crate::winding::nonbounding::{Nonbounding, nonbounding_part};
use crate::winding::options::{Completion, Reference, WindingOptions};
use crate::winding::solution::{ProgramReport, Winding, WindingReport};
use crate::winding::weights::Weights;
use crate::wording::counted;
use eikona_mesh::{Components, SurfaceCurves, Topology, TriangleMesh, Vertex};
use eikona_numeric::{Cholesky, NumericError};
use std::sync::OnceLock;

/// A mesh with its factored operators: answers curve after curve.
///
/// Curves without endpoints (closed, or from boundary to boundary) share one factor of the Laplacian. Others leave out the
/// vertices at which they end, which changes its numbers but not its pattern: it is factored anew, not analysed anew.
#[derive(Debug)]
pub struct Solver {
    mesh: TriangleMesh,
    consistent: bool,
    /// Every closed curve bounds: no nonbounding part is looked for.
    simply_connected: bool,
    triangles: Vec<Triangle>,
    weights: Weights,
    laplace: JumpLaplace,
    /// Without excluded vertices; made when the first curve without endpoints comes.
    whole: OnceLock<Cholesky<f64>>,
    /// Made when the first curve comes that needs it.
    hodge: OnceLock<Hodge>,
    warnings: Vec<String>,
}

impl Solver {
    /// Sets up the operators. Nothing is factored before the first curve shows what is needed.
    ///
    /// # Errors
    /// [`WindingError::NoFaces`], [`WindingError::Numeric`].
    pub fn new(mesh: &TriangleMesh) -> Result<Solver, WindingError> {
        if mesh.face_count() == 0 {
            return Err(WindingError::NoFaces);
        }
        let mut warnings = Vec::new();
        let mesh = consistently_wound(mesh, &mut warnings);
        let triangles = lay_out(&mesh);
        Ok(Solver {
            consistent: winding_is_consistent(&mesh),
            simply_connected: is_simply_connected(&mesh),
            weights: Weights::of(&triangles),
            laplace: JumpLaplace::new(&mesh)?,
            whole: OnceLock::new(),
            hodge: OnceLock::new(),
            mesh,
            triangles,
            warnings,
        })
    }

    /// The mesh that curves are given on: the input, with faces turned over so that they are wound alike if that is possible.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The winding number of curves along edges.
    ///
    /// # Errors
    /// [`WindingError::NoCurve`], [`WindingError::Unsigned`], [`WindingError::Curve`], [`WindingError::NotAlongEdges`],
    /// [`WindingError::Multiplicity`], [`WindingError::Option`], and failures of the solves.
    ///
    /// # Cost
    /// Two back-substitutions; for curves with endpoints a factorisation, and on surfaces that are not simply connected the Hodge
    /// system (factored once) and a linear program on the faces.
    pub fn solve(&self, curves: &SurfaceCurves, options: &WindingOptions) -> Result<Winding, WindingError> {
        let mut phases = Phases::start();
        self.check(curves, options)?;
        let mesh = &self.mesh;
        let mut warnings = self.warnings.clone();
        let (chain, steps) = Chain::of(mesh, self.consistent, curves, &mut warnings)?;
        note_chain(&chain, &mut warnings);
        let jump: Vec<f64> = chain.jump.iter().map(|&j| f64::from(j)).collect();
        let coordinates = Coordinates::of(mesh, &jump, 0.5);
        note_not_fans(&coordinates, &mut warnings);
        let mut excluded = vec![false; mesh.vertex_count()];
        coordinates.left_out().for_each(|v| excluded[v.index()] = true);
        let all_closed = coordinates.left_out().next().is_none();
        phases.end("chain");

        let own;
        let factor = if all_closed {
            self.whole_factor()?
        } else {
            own = self.laplace.factor(mesh, &self.weights, &excluded)?;
            &own
        };
        phases.end("factorisation");
        let equation = |corner: &[f64]| solve_jump_equation(mesh, &self.weights, factor, &excluded, corner);
        let (mut values, mut residual) = equation(&coordinates.corner)?;
        phases.end("jump equation");

        let mut program = None;
        let mut nonbounding = vec![0.0; mesh.edge_count()];
        let mut residual_function = vec![0.0; 3 * mesh.face_count()];
        if !self.simply_connected {
            let derivative = darboux_derivative(mesh, &values);
            let mut harmonic = derivative;
            if !all_closed {
                let hodge_residual;
                (harmonic, hodge_residual) = self.hodge()?.harmonic_part(mesh, &harmonic)?;
                residual = residual.max(hodge_residual);
            }
            phases.end("harmonic part");
            let largest = harmonic.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            if largest > NO_HARMONIC_PART {
                let in_faces = integrated_in_faces(&harmonic);
                let shift = jumps_of(mesh, &in_faces);
                let part = nonbounding_part(mesh, &self.triangles, &chain.jump, &shift, options.epsilon)?;
                let Nonbounding { jump: t, shift_of_face, certificate, objective, statistics } = part;
                for (corner, value) in residual_function.iter_mut().enumerate() {
                    *value = in_faces[corner] + shift_of_face[corner / 3];
                }
                nonbounding = t;
                program = Some(ProgramReport { objective, certificate, statistics });
                phases.end("linear program");

                let rest: Vec<f64> = jump.iter().zip(&nonbounding).map(|(j, t)| j - t).collect();
                let corrected = self.corrected(&coordinates, &chain.jump, &rest, options.completion);
                let second;
                (values, second) = equation(&corrected)?;
                residual = residual.max(second);
                phases.end("second jump equation");
            }
        }

        let components = Components::of(mesh);
        let labels =
            labels(mesh, &self.triangles, &components, &values, &chain.jump, &nonbounding, options.reference);
        let bounds = by_curve(curves, &steps, &nonbounding_steps(&steps, &nonbounding));
        let bounding_loops = polylines(mesh, |e| match mesh.edge_halfedges(e) {
            &[a, b] => f64::from(labels.label[a.face().index()] - labels.label[b.face().index()]),
            _ => 0.0,
        });
        let nonbounding_loops = polylines(mesh, |e| nonbounding[e.index()]);
        phases.end("regions");

        let largest_nonbounding = nonbounding.iter().fold(0.0f64, |m, t| m.max(t.abs()));
        let farthest_from_whole = nonbounding.iter().fold(0.0f64, |m, t| m.max((t - t.round()).abs()));
        Ok(Winding {
            mesh: mesh.clone(),
            face_parent: None,
            values: values.into(),
            labels: labels.label.into(),
            margin: labels.margin.into(),
            shift: labels.shift,
            component: components.of_face,
            curve: chain.jump.into(),
            nonbounding: nonbounding.into(),
            residual_function: residual_function.into(),
            endpoints: coordinates.endpoints,
            bounds,
            bounding_loops,
            nonbounding_loops,
            report: WindingReport {
                phases: phases.finish(),
                residual,
                program,
                largest_nonbounding,
                farthest_from_whole,
                warnings,
            },
        })
    }

    fn check(&self, curves: &SurfaceCurves, options: &WindingOptions) -> Result<(), WindingError> {
        if curves.curves.is_empty() {
            return Err(WindingError::NoCurve);
        }
        let epsilon = options.epsilon;
        if !(epsilon > 0.0 && epsilon <= 1.0) {
            let bound = "a number above 0, at most 1, is needed";
            return Err(WindingError::Option { name: "epsilon", value: epsilon, bound });
        }
        match options.reference {
            Reference::Face(face) if face.index() >= self.mesh.face_count() => {
                Err(WindingError::no_such_reference(face))
            }
            _ => Ok(()),
        }
    }

    /// Reduced coordinates of the curve without its nonbounding part (algorithm 8, with the running sum that it leaves out). The
    /// curve still ends where it did, as what was taken off is closed.
    fn corrected(
        &self,
        before: &Coordinates,
        curve: &[i32],
        rest: &[f64],
        completion: Completion,
    ) -> Vec<f64> {
        let mesh = &self.mesh;
        let mut corner = Coordinates::of(mesh, rest, f64::INFINITY).corner;
        let mut clear = |v: Vertex| mesh.vertex_corners(v).iter().for_each(|c| corner[c.index()] = 0.0);
        before.left_out().for_each(&mut clear);
        if completion == Completion::Curve {
            let mut touched = vec![false; mesh.vertex_count()];
            for e in mesh.edges().filter(|e| curve[e.index()] != 0) {
                mesh.edge_vertices(e).into_iter().for_each(|v| touched[v.index()] = true);
            }
            mesh.vertices().filter(|v| !touched[v.index()]).for_each(clear);
        }
        corner
    }

    fn whole_factor(&self) -> Result<&Cholesky<f64>, NumericError> {
        if let Some(factor) = self.whole.get() {
            return Ok(factor);
        }
        let none = vec![false; self.mesh.vertex_count()];
        let factor = self.laplace.factor(&self.mesh, &self.weights, &none)?;
        Ok(self.whole.get_or_init(|| factor))
    }

    fn hodge(&self) -> Result<&Hodge, NumericError> {
        if let Some(hodge) = self.hodge.get() {
            return Ok(hodge);
        }
        let hodge = Hodge::new(&self.mesh, &self.weights)?;
        Ok(self.hodge.get_or_init(|| hodge))
    }
}

/// A harmonic form below this (jumps are whole numbers) is rounding: every part of the curve bounds.
const NO_HARMONIC_PART: f64 = 1e-9;

/// Whether every component is a sphere or a disk.
fn is_simply_connected(mesh: &TriangleMesh) -> bool {
    let topology = Topology::of(mesh);
    topology.is_manifold()
        && topology.components.iter().all(|c| c.genus == Some(0) && c.boundary_loop_count <= 1)
}

fn by_curve(curves: &SurfaceCurves, steps: &[Step], nonbounding: &[bool]) -> Vec<Vec<bool>> {
    let mut result = vec![Vec::new(); curves.curves.len()];
    for (step, nonbounding) in steps.iter().zip(nonbounding) {
        result[step.curve].push(!nonbounding);
    }
    result
}

fn note_chain(chain: &Chain, warnings: &mut Vec<String>) {
    if chain.cancelled > 0 {
        let edges = counted(chain.cancelled, "edge is", "edges are");
        warnings.push(format!("{edges} walked in both directions equally often; these steps cancel"));
    }
    if chain.on_boundary > 0 {
        let steps = counted(chain.on_boundary, "step runs", "steps run");
        warnings.push(format!("{steps} along the boundary, where nothing can jump; they are left out"));
    }
    if chain.on_nonmanifold > 0 {
        let steps = counted(chain.on_nonmanifold, "step runs", "steps run");
        warnings.push(format!(
            "{steps} along edges of three or more faces, where there is no left; they are left out"
        ));
    }
}

fn note_not_fans(coordinates: &Coordinates, warnings: &mut Vec<String>) {
    if let Some(first) = coordinates.not_fans.first() {
        let vertices =
            counted(coordinates.not_fans.len(), "vertex of the curve has", "vertices of the curve have");
        warnings.push(format!(
            "{vertices} more than one fan of faces, the first is vertex {}; the winding number has no value there",
            first.index()
        ));
    }
}
