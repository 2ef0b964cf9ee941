//! The steps of the method, in order.

use crate::contour::side::consistently_wound;
use crate::contour::{Embedded, EmbeddedCurve, embed_curves, parts_of_short_edges};
use crate::geometry::{Triangle, lay_out_in, unit_of, winding_is_consistent};
use crate::phases::{Phases, Running};
use crate::winding::chain::{Chain, Step, along_edge};
use crate::winding::coordinates::Coordinates;
use crate::winding::decomposition::{Part, parts_of};
use crate::winding::error::WindingError;
use crate::winding::harmonic::{integrated_in_faces, jumps_of};
use crate::winding::islands::Islands;
use crate::winding::jump_laplace::{darboux_derivative, differences, solve_jump_equation};
use crate::winding::labels::{Labels, labels};
use crate::winding::loops::loops_of;
use crate::winding::nonbounding::nonbounding_part;
use crate::winding::operators::Operators;
use crate::winding::options::{Completion, Diagnosis, Reference, WindingOptions};
use crate::winding::orientation::{MOST_STRETCHES, Stretches, changed_area};
use crate::winding::solution::{Parents, ProgramReport, Winding, WindingReport};
use crate::wording::counted;
use eikona_mesh::{
    Curve, CurveKind, Edge, Face, Located, Segment, SurfaceCurves, Topology, TriangleMesh, Vertex,
    segment_host,
};
use eikona_numeric::Cholesky;
use std::sync::OnceLock;

/// A mesh with its factored operators: answers curve after curve.
///
/// Curves along edges without endpoints (closed, or from boundary to boundary) share one factor of the Laplacian and one of the
/// Hodge system. Others leave out the vertices at which they end, which changes the numbers of the Laplacian but not its pattern: it
/// is factored anew, not analysed anew. For a curve across faces the mesh is cut, and the operators are those of the cut mesh.
#[derive(Debug)]
pub struct Solver {
    mesh: TriangleMesh,
    /// Faces whose winding was turned over; empty if none was.
    turned: Vec<bool>,
    consistent: bool,
    /// Every closed curve bounds: no nonbounding part is looked for.
    simply_connected: bool,
    /// What lengths are divided by: labels do not depend on the size of the mesh, which may be one that can not be squared.
    unit: f64,
    triangles: Vec<Triangle>,
    on_faces: Operators,
    /// On the intrinsic Delaunay triangles.
    on_delaunay: OnceLock<Operators>,
    warnings: Vec<String>,
}

impl Solver {
    /// Sets up the operators. Nothing is analysed or factored before the first curve shows what is needed.
    ///
    /// # Errors
    /// [`WindingError::NoFaces`].
    pub fn new(mesh: &TriangleMesh) -> Result<Solver, WindingError> {
        if mesh.face_count() == 0 {
            return Err(WindingError::NoFaces);
        }
        let mut warnings = Vec::new();
        let wound = consistently_wound(mesh, &mut warnings);
        let cuts = mesh.edges().filter(|&e| mesh.edge_halfedges(e).len() > 2).count();
        if cuts > 0 {
            let edges = counted(cuts, "edge has", "edges have");
            warnings.push(format!("{edges} three or more faces; the surface is taken as cut open there"));
        }
        let mut turned: Vec<bool> =
            mesh.faces().map(|f| mesh.face_vertices(f) != wound.face_vertices(f)).collect();
        if !turned.contains(&true) {
            turned = Vec::new();
        }
        Ok(Solver { turned, warnings, ..Solver::on_wound(wound) })
    }

    fn on_wound(mesh: TriangleMesh) -> Solver {
        let unit = unit_of(&mesh);
        let triangles = lay_out_in(&mesh, unit);
        Solver {
            turned: Vec::new(),
            consistent: winding_is_consistent(&mesh),
            simply_connected: is_simply_connected(&mesh),
            on_faces: Operators::on_faces(&mesh, &triangles),
            on_delaunay: OnceLock::new(),
            mesh,
            unit,
            triangles,
            warnings: Vec::new(),
        }
    }

    /// The mesh that curves are given on: the input, with faces turned over so that they are wound alike if that is possible.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The winding number of curves. Where they cross faces, or end inside of edges or faces, the mesh is cut along them first
    /// ([`embed_curves`]); and where open pieces of them have fewer than 8 edges, unless
    /// [`split_short`](WindingOptions::split_short) is off. The result is on the cut mesh then, with the parent of each face in
    /// [`Winding::face_parent`].
    ///
    /// # Errors
    /// [`WindingError::NoCurve`], [`WindingError::Unsigned`], [`WindingError::Curve`], [`WindingError::Embed`],
    /// [`WindingError::Multiplicity`], [`WindingError::Option`], and failures of the solves.
    ///
    /// # Cost
    /// Two back-substitutions; for curves with endpoints a factorisation, and on surfaces that are not simply connected the Hodge
    /// system (factored once) and a linear program on the faces. Where the mesh is cut, analysis and factorisation of its operators.
    pub fn solve(&self, curves: &SurfaceCurves, options: &WindingOptions) -> Result<Winding, WindingError> {
        let mut phases = Phases::start();
        self.check(curves, options)?;
        let segments = curves.segments(&self.mesh)?;
        phases.end("check");
        if segments.iter().all(|s| along_edge(s).is_some()) {
            let walks = walks(curves, &segments);
            if !options.split_short || parts_of_short_edges(&self.mesh, &walks).is_empty() {
                let warnings = self.warnings.clone();
                let mut winding =
                    self.solve_along_edges(curves, &segments, walks, options, warnings, phases)?;
                winding.parents = Parents { turned: self.turned.clone(), ..Parents::default() };
                return Ok(winding);
            }
        }
        self.solve_cut(curves, options, phases)
    }

    /// Cuts the mesh and solves there.
    fn solve_cut(
        &self,
        curves: &SurfaceCurves,
        options: &WindingOptions,
        mut phases: Running,
    ) -> Result<Winding, WindingError> {
        let mut embedded = embed_curves(&self.mesh, curves)?;
        if options.split_short {
            embedded = embedded.split_short()?;
        }
        let mut options = *options;
        if let Reference::Face(face) = options.reference {
            let area = |child: &Face| Triangle::of_face(&embedded.mesh, *child).area;
            let children = embedded.mesh.faces().filter(|child| embedded.face_parent[child.index()] == face);
            let largest = children.max_by(|a, b| area(a).total_cmp(&area(b)));
            options.reference = Reference::Face(largest.ok_or(WindingError::no_such_reference(face))?);
        }
        let cut = Solver::on_wound(embedded.mesh.clone());
        phases.end("cut");
        let Embedded { mesh, face_parent, vertex_place, curves: walks, .. } = embedded;
        let curve = |w: &EmbeddedCurve| {
            let nodes = w.vertices.iter().map(|&v| v.into()).collect();
            Curve { kind: w.kind, up: w.up, nodes }
        };
        let along = SurfaceCurves { curves: walks.iter().map(curve).collect(), points: Vec::new() };
        let segments = segments_of(&mesh, &walks);
        let warnings = self.warnings.clone();
        let mut winding = cut.solve_along_edges(&along, &segments, walks, &options, warnings, phases)?;
        winding.face_parent = face_parent;
        winding.parents =
            Parents { turned: self.turned.clone(), cut: Some((self.mesh.clone(), vertex_place)) };
        Ok(winding)
    }

    /// Solves for curves along edges, and looks at their orientation.
    fn solve_along_edges(
        &self,
        curves: &SurfaceCurves,
        segments: &[Segment],
        walks: Vec<EmbeddedCurve>,
        options: &WindingOptions,
        mut warnings: Vec<String>,
        mut phases: Running,
    ) -> Result<Winding, WindingError> {
        let mesh = &self.mesh;
        let (chain, steps) = Chain::of(mesh, self.consistent, curves, segments, &mut warnings)?;
        note_chain(&chain, &mut warnings);
        let found = self.solve_chain(&chain.jump, options, &mut phases)?;
        note_not_fans(&found.coordinates, &mut warnings);
        note_freed(&found.freed, mesh, &mut warnings);
        note_without_value(&found.islands, &mut warnings);

        let stretches = Stretches::of(&steps);
        let diagnosed = match options.diagnosis {
            Diagnosis::Never => false,
            Diagnosis::Always => true,
            Diagnosis::Automatic => stretches.count() <= MOST_STRETCHES,
        };
        let mut orientation = None;
        if diagnosed {
            match stretches.diagnose(
                mesh,
                (&self.triangles, self.unit),
                &self.on_faces,
                &found.excluded,
                &walks,
            ) {
                Ok(mut report) => {
                    if !report.reversed.is_empty() {
                        let jump = report.turned_over(&steps, &chain.jump);
                        let other = self.solve_chain(&jump, options, &mut Phases::start()).ok();
                        report.changed_area = other
                            .map(|o| changed_area(&self.triangles, &found.labels.label, &o.labels.label));
                        warnings.push(report.sentence());
                    }
                    orientation = Some(report);
                }
                // The answer stands without it.
                Err(fault) => {
                    warnings.push(format!("the orientation of the curve was not looked at: {fault}"))
                }
            }
            phases.end("orientation");
        }

        let parts = by_curve(walks.len(), &steps, &parts_of(&steps, &chain.jump, &found.nonbounding));
        let label = &found.labels.label;
        let bounding_loops = loops_of(mesh, |e| {
            let [a, b] = [0, 1].map(|i| mesh.edge_halfedges(e)[i].face().index());
            f64::from(label[a] - label[b])
        });
        let nonbounding_loops = loops_of(mesh, |e| found.nonbounding[e.index()]);
        phases.end("loops");
        let largest_nonbounding = found.nonbounding.iter().fold(0.0f64, |m, t| m.max(t.abs()));
        let farthest_from_whole = found.nonbounding.iter().fold(0.0f64, |m, t| m.max((t - t.round()).abs()));
        Ok(Winding {
            mesh: mesh.clone(),
            face_parent: mesh.faces().collect(),
            parents: Parents::default(),
            values: found.values.into(),
            labels: found.labels.label.into(),
            margin: found.labels.margin.into(),
            shift: found.labels.shift,
            component: found.islands.of_face.into(),
            curves: walks,
            jump: chain.jump.into(),
            nonbounding: found.nonbounding.into(),
            residual_function: found.residual_function.into(),
            endpoints: found.coordinates.endpoints,
            parts,
            bounding_loops,
            nonbounding_loops,
            report: WindingReport {
                phases: phases.finish(),
                residual: found.residual,
                program: found.program,
                largest_nonbounding,
                farthest_from_whole,
                orientation,
                warnings,
            },
        })
    }

    /// Steps 1 to 10 and the labels, for jumps at edges.
    fn solve_chain(
        &self,
        curve: &[i32],
        options: &WindingOptions,
        phases: &mut Running,
    ) -> Result<Found, WindingError> {
        let mesh = &self.mesh;
        let jump: Vec<f64> = curve.iter().map(|&j| f64::from(j)).collect();
        let coordinates = Coordinates::of(mesh, &jump, 0.5);
        let mut excluded = vec![false; mesh.vertex_count()];
        coordinates.left_out().for_each(|v| excluded[v.index()] = true);
        let all_closed = coordinates.left_out().next().is_none();
        phases.end("chain");

        let own_operators;
        let on = if !options.intrinsic_delaunay {
            &self.on_faces
        } else if all_closed {
            self.on_delaunay.get_or_init(|| Operators::on_delaunay(mesh, &self.triangles, &excluded))
        } else {
            own_operators = Operators::on_delaunay(mesh, &self.triangles, &excluded);
            &own_operators
        };
        let own_factor;
        let factor = if all_closed {
            on.whole_factor(mesh)?
        } else {
            own_factor = on.factor(mesh, &excluded)?;
            &own_factor
        };
        phases.end("factorisation");
        let equation = |corner: &[f64]| jump_function(mesh, on, factor, &excluded, corner);
        let (mut values, derivative, mut residual) = equation(&coordinates.corner)?;
        let mut nonbounding = vec![0.0; mesh.edge_count()];
        let mut residual_function = vec![0.0; 3 * mesh.face_count()];
        let (mut program, mut freed) = (None, Vec::new());
        phases.end("jump equation");

        if !self.simply_connected {
            let mut harmonic = derivative;
            if !all_closed {
                let hodge_residual;
                (harmonic, hodge_residual) = on.hodge(mesh)?.harmonic_part(&on.triangulation, &harmonic)?;
                residual = residual.max(hodge_residual);
            }
            phases.end("harmonic part");
            let largest = harmonic.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            if largest > NO_HARMONIC_PART {
                // Without endpoints the function itself has the harmonic derivative, and its jumps are whole numbers to the last digit.
                let in_faces = if all_closed {
                    values.clone()
                } else {
                    on.triangulation.form_to_mesh(&mut harmonic);
                    integrated_in_faces(&harmonic)
                };
                let shift = if all_closed { jump.clone() } else { jumps_of(mesh, &in_faces) };
                let part = nonbounding_part(mesh, &self.triangles, curve, &shift, options.epsilon)?;
                for (corner, value) in residual_function.iter_mut().enumerate() {
                    *value = in_faces[corner] + part.shift_of_face[corner / 3];
                }
                (nonbounding, freed) = (part.jump, part.freed);
                program = Some(ProgramReport { objective: self.unit * part.report.objective, ..part.report });
                phases.end("linear program");

                let rest: Vec<f64> = jump.iter().zip(&nonbounding).map(|(j, t)| j - t).collect();
                let corrected = self.corrected(&coordinates, curve, &rest, options.completion);
                let second;
                (values, _, second) = equation(&corrected)?;
                residual = residual.max(second);
                phases.end("second jump equation");
            }
        }

        let islands = Islands::of(mesh, &on.triangulation, &excluded);
        let labels = labels(mesh, &self.triangles, &islands, &values, curve, &nonbounding, options.reference);
        phases.end("labels");
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
            freed,
        })
    }

    fn check(&self, curves: &SurfaceCurves, options: &WindingOptions) -> Result<(), WindingError> {
        if curves.curves.is_empty() {
            return Err(WindingError::NoCurve);
        }
        if let Some(curve) = curves.curves.iter().position(|c| c.kind == CurveKind::Unsigned) {
            return Err(WindingError::Unsigned { curve });
        }
        let epsilon = options.epsilon;
        if !(1e-9..=1.0).contains(&epsilon) {
            let bound = "a number from 1e-9 to 1 is needed";
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
}

/// What the steps give for jumps at edges.
struct Found {
    coordinates: Coordinates,
    excluded: Vec<bool>,
    values: Vec<f64>,
    nonbounding: Vec<f64>,
    residual_function: Vec<f64>,
    islands: Islands,
    labels: Labels,
    residual: f64,
    program: Option<ProgramReport>,
    freed: Vec<Edge>,
}

/// The smoothest function with these coordinates at corners, NaN at excluded vertices; its derivative along the halfedges of the
/// operators' triangulation; and the relative residual.
fn jump_function(
    mesh: &TriangleMesh,
    on: &Operators,
    factor: &Cholesky<f64>,
    excluded: &[bool],
    coordinates: &[f64],
) -> Result<(Vec<f64>, Vec<f64>, f64), WindingError> {
    let mut differences = differences(coordinates);
    on.triangulation.form_from_mesh(&mut differences);
    let (base, residual) = solve_jump_equation(&on.triangulation, factor, excluded, &differences)?;
    let derivative = darboux_derivative(&on.triangulation, excluded, &base, &differences);
    let value = |(&v, c): (&u32, &f64)| if excluded[v as usize] { f64::NAN } else { base[v as usize] + c };
    let values = mesh.triangles().iter().flatten().zip(coordinates).map(value).collect();
    Ok((values, derivative, residual))
}

/// A harmonic form below this (jumps are whole numbers) is rounding: every part of the curve bounds.
const NO_HARMONIC_PART: f64 = 1e-9;

/// Whether every component is a sphere or a disk.
fn is_simply_connected(mesh: &TriangleMesh) -> bool {
    let topology = Topology::of(mesh);
    topology.is_manifold()
        && topology.components.iter().all(|c| c.genus == Some(0) && c.boundary_loop_count <= 1)
}

/// The steps of walks along edges.
fn segments_of(mesh: &TriangleMesh, walks: &[EmbeddedCurve]) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (curve, walk) in walks.iter().enumerate() {
        for (node, ends) in walk.vertices.windows(2).enumerate() {
            let ends = [Located::Vertex(ends[0]), Located::Vertex(ends[1])];
            if let Some(host) = segment_host(mesh, ends[0], ends[1]) {
                segments.push(Segment { curve, node, ends, host });
            }
        }
    }
    segments
}

/// Curves along edges as walks.
fn walks(curves: &SurfaceCurves, segments: &[Segment]) -> Vec<EmbeddedCurve> {
    let mut walks: Vec<EmbeddedCurve> = curves
        .curves
        .iter()
        .map(|c| EmbeddedCurve { kind: c.kind, up: c.up, vertices: Vec::new(), segments: Vec::new() })
        .collect();
    for segment in segments {
        let [Located::Vertex(from), Located::Vertex(to)] = segment.ends else { continue };
        let walk = &mut walks[segment.curve];
        if walk.vertices.is_empty() {
            walk.vertices.push(from);
        }
        walk.vertices.push(to);
        walk.segments.push(segment.node);
    }
    walks
}

fn by_curve(curves: usize, steps: &[Step], parts: &[Part]) -> Vec<Vec<Part>> {
    let mut result = vec![Vec::new(); curves];
    for (step, part) in steps.iter().zip(parts) {
        result[step.curve].push(*part);
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
    if chain.jump.iter().all(|&j| j == 0) {
        warnings.push("nothing is left of the curve, so every region is outside".into());
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

fn note_without_value(islands: &Islands, warnings: &mut Vec<String>) {
    if let Some((first, _)) = islands.without_value.first() {
        let faces = counted(islands.without_value.len(), "face has", "faces have");
        warnings.push(format!(
            "{faces} endpoints at all corners, so no value, the first is {first}; labelled like the nearest face with one"
        ));
    }
}

fn note_freed(freed: &[Edge], mesh: &TriangleMesh, warnings: &mut Vec<String>) {
    if let Some(&first) = freed.first() {
        let [a, b] = mesh.edge_vertices(first);
        let edges = counted(freed.len(), "edge of the curve is", "edges of the curve are");
        warnings.push(format!(
            "{edges} all that joins a ring of faces, the first from vertex {} to {}: the nonbounding part may be larger than the \
             curve there; refine the mesh around it",
            a.index(),
            b.index()
        ));
    }
}
