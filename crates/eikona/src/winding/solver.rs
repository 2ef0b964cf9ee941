//! Preprocesses a mesh once; solves for any number of curves.

use crate::Warning;
use crate::curves::side::consistently_oriented;
use crate::cut::{EmbeddedCurve, embed_curves, parts_of_short_edges};
use crate::geometry::{face_in, lay_out_in};
use crate::phases::{Phases, Running};
use crate::winding::chain::{Chain, Step, along_edge};
use crate::winding::decomposition::{Part, parts_of};
use crate::winding::error::WindingError;
use crate::winding::labels::share_of_area;
use crate::winding::loops::loops_of;
use crate::winding::options::{
    CompletionShape, Diagnosis, EPSILON_RANGE, Reference, SolverOptions, WindingOptions,
};
use crate::winding::orientation::{
    AUTOMATIC_DIAGNOSIS_LIMIT, DIAGNOSIS_LIMIT, Orientation, Stretches, changed_area,
};
use crate::winding::solution::{Winding, WindingReport};
use crate::winding::steps::{Found, solve_chain};
use crate::winding::surface::Surface;
use crate::winding::walks::walks_of;
use crate::winding::warnings::{cancelled_or_ignored, faces_without_value, narrow_rings, several_fans};
use eikona_mesh::{CurveKind, Face, Provenance, SurfaceCurves, TriangleMesh};
use eikona_numeric::{begin_phase, check_stopped};

/// A mesh with its factored operators, reused from curve to curve.
///
/// Curves along edges without endpoints (closed, or from boundary to boundary) share one factor of
/// the Laplacian and one of the Hodge system. Curves with endpoints exclude these vertices, which
/// changes the values of the Laplacian but not its pattern: it is refactored, not reanalysed. On
/// intrinsic Delaunay triangles, which omit the faces at such vertices, everything is rebuilt. For
/// a curve across faces the mesh is cut, and the operators are those of the cut mesh.
#[derive(Debug)]
pub struct Solver {
    surface: Surface,
    /// The faces that were flipped.
    oriented: Provenance,
    warnings: Vec<Warning>,
}

impl Solver {
    /// Checks and orients the mesh. Operators are analysed and factored when a curve first needs
    /// them.
    ///
    /// # Errors
    /// [`WindingError::NoFaces`]; [`NumericError::Stopped`](eikona_numeric::NumericError::Stopped).
    pub fn new(mesh: &TriangleMesh, options: &SolverOptions) -> Result<Solver, WindingError> {
        if mesh.face_count() == 0 {
            return Err(WindingError::NoFaces);
        }
        begin_phase("geometry")?;
        let mut warnings = Vec::new();
        let oriented = consistently_oriented(mesh, &mut warnings);
        check_stopped()?;
        let mut cuts = mesh.edges().filter(|&e| mesh.edge_halfedges(e).len() > 2);
        if let Some(first) = cuts.next() {
            let first = mesh.edge_vertices(first);
            warnings.push(Warning::NonmanifoldEdges { count: 1 + cuts.count(), first });
        }
        let flipped = mesh.faces().filter(|f| mesh.face_vertices(*f) != oriented.face_vertices(*f)).collect();
        let provenance =
            Provenance::identity(mesh.vertex_count(), mesh.face_count()).with_flipped_faces(flipped);
        check_stopped()?;
        let surface = Surface::new(oriented, options.resources())?;
        Ok(Solver { surface, oriented: provenance, warnings })
    }

    /// Returns the mesh that curves refer to: the input, with faces flipped to a consistent
    /// orientation where possible.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.surface.mesh
    }

    /// Computes the winding number of curves. Where they cross faces, or end inside edges or faces,
    /// the mesh is first cut along them ([`embed_curves`]). Open pieces of fewer than 8 edges are
    /// refined, unless [`split_short`](WindingOptions::split_short) is off. The result then lives
    /// on the cut mesh; [`Winding::provenance`] leads back.
    ///
    /// # Errors
    /// [`WindingError::NoCurve`], [`WindingError::Unsigned`], [`WindingError::Curve`],
    /// [`WindingError::Embed`], [`WindingError::Multiplicity`], [`WindingError::Option`], and
    /// failures of the solves.
    ///
    /// # Cost
    /// Two back-substitutions; for curves with endpoints a factorisation, and on surfaces that are
    /// not simply connected the Hodge system (factored once) and a linear program on the faces.
    /// Where the mesh is cut, analysis and factorisation of its operators. The orientation check of
    /// several stretches takes one factorisation and one back-substitution per stretch, on the
    /// faces, and a whole second solve if some look reversed: see [`Diagnosis`](super::Diagnosis).
    /// Straightening completions takes O(F) and the cost of
    /// [`straighten_curve`](crate::curves::straighten_curve) for their pieces, a small part of the
    /// solve.
    pub fn solve(&self, curves: &SurfaceCurves, options: &WindingOptions) -> Result<Winding, WindingError> {
        let phases = Phases::begin("check")?;
        self.check(curves, options)?;
        let segments = curves.segments(&self.surface.mesh)?;
        if segments.iter().all(|s| along_edge(s).is_some()) {
            let walks = walks_of(curves, &segments);
            if !options.split_short || parts_of_short_edges(&self.surface.mesh, &walks).is_empty() {
                let domain =
                    Domain { surface: &self.surface, provenance: self.oriented.clone(), uncut: None };
                return domain.solve(walks, options, self.warnings.clone(), phases);
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
        phases.next("cut")?;
        let mut embedded = embed_curves(&self.surface.mesh, curves)?;
        if options.split_short {
            embedded = embedded.split_short()?;
        }
        let mut options = *options;
        if let Reference::Face(face) = options.reference {
            let area = |child: &Face| face_in(&embedded.mesh, *child, self.surface.unit).area;
            let children = embedded.provenance.face_parts(face);
            let largest = children.max_by(|a, b| area(a).total_cmp(&area(b)));
            options.reference = Reference::Face(largest.ok_or(WindingError::no_such_reference(face))?);
        }
        check_stopped()?;
        let cut = Surface::new(embedded.mesh, self.surface.resources)?;
        let domain = Domain {
            surface: &cut,
            provenance: self.oriented.then(&embedded.provenance),
            uncut: Some(self.surface.mesh.clone()),
        };
        domain.solve(embedded.curves, &options, self.warnings.clone(), phases)
    }

    fn check(&self, curves: &SurfaceCurves, options: &WindingOptions) -> Result<(), WindingError> {
        if curves.curves.is_empty() {
            return Err(WindingError::NoCurve);
        }
        if let Some(curve) = curves.curves.iter().position(|c| c.kind == CurveKind::Unsigned) {
            return Err(WindingError::Unsigned { curve });
        }
        let epsilon = options.epsilon;
        if !EPSILON_RANGE.contains(&epsilon) {
            let bound = "choose a number from 1e-9 to 1";
            return Err(WindingError::Option { name: "epsilon", value: epsilon, bound });
        }
        match options.reference {
            Reference::Face(face) if face.index() >= self.surface.mesh.face_count() => {
                Err(WindingError::no_such_reference(face))
            }
            _ => Ok(()),
        }
    }
}

/// A surface on which curves run along edges, and how it derives from the input.
struct Domain<'a> {
    surface: &'a Surface,
    /// Leads from the input to the surface.
    provenance: Provenance,
    /// The mesh before it was cut, if it was.
    uncut: Option<TriangleMesh>,
}

impl Domain<'_> {
    /// Computes the winding number, checks the orientation of the curves, and straightens the
    /// completion if asked for.
    fn solve(
        self,
        walks: Vec<EmbeddedCurve>,
        options: &WindingOptions,
        warnings: Vec<Warning>,
        phases: Running,
    ) -> Result<Winding, WindingError> {
        let surface = self.surface;
        let winding = self.along_edges(walks, options, warnings, phases)?;
        straightened_and_measured(surface, winding, options)
    }

    /// Solves for curves along edges, and checks their orientation.
    fn along_edges(
        self,
        walks: Vec<EmbeddedCurve>,
        options: &WindingOptions,
        mut warnings: Vec<Warning>,
        mut phases: Running,
    ) -> Result<Winding, WindingError> {
        phases.next("chain")?;
        let Domain { surface, provenance, uncut } = self;
        let mesh = &surface.mesh;
        let (chain, steps) = Chain::of(mesh, surface.consistent, &walks, &mut warnings)?;
        warnings.extend(cancelled_or_ignored(&chain));
        check_stopped()?;
        let found = solve_chain(surface, &chain.jump, options, &mut phases)?;
        warnings.extend(several_fans(&found.coordinates, &provenance));
        warnings.extend(narrow_rings(&found.relaxed, mesh, &provenance));
        warnings.extend(faces_without_value(&found.islands, &provenance));

        phases.next("orientation")?;
        let orientation = orientation(surface, &chain, &steps, &walks, &found, options, &mut warnings);
        let (orientation, orientation_unchecked) = match orientation {
            Ok(orientation) => (orientation, None),
            Err(reason) => {
                warnings.push(Warning::UncheckedOrientation { reason: reason.clone() });
                (None, Some(reason))
            }
        };
        phases.next("loops")?;
        let parts = by_curve(walks.len(), &steps, &parts_of(&steps, &chain.jump, &found.nonbounding));
        let label = &found.labels.label;
        let bounding_loops = loops_of(mesh, |e| {
            let [a, b] = [0, 1].map(|i| mesh.edge_halfedges(e)[i].face().index());
            f64::from(label[a] - label[b])
        });
        let nonbounding_loops = loops_of(mesh, |e| found.nonbounding[e.index()]);
        let largest_nonbounding = found.nonbounding.iter().fold(0.0f64, |m, t| m.max(t.abs()));
        let farthest_from_whole = found.nonbounding.iter().fold(0.0f64, |m, t| m.max((t - t.round()).abs()));
        Ok(Winding {
            mesh: mesh.clone(),
            provenance,
            uncut,
            follows_labels: false,
            values: found.values.into(),
            labels: found.labels.label.into(),
            margin: found.labels.margin.into(),
            shift: found.labels.shift,
            island: found.islands.of_face.into(),
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
                uncertain_area: 0.0,
                completion: None,
                orientation,
                orientation_unchecked,
                warnings,
            },
        })
    }
}

/// Straightens the completion if asked for, and measures the uncertain area.
fn straightened_and_measured(
    surface: &Surface,
    mut winding: Winding,
    options: &WindingOptions,
) -> Result<Winding, WindingError> {
    if options.completion_shape == CompletionShape::Straight {
        let phases = Phases::begin("straightening")?;
        winding = winding.straightened(surface.consistent, options.completion, surface.unit)?;
        winding.report.phases.0.extend(phases.finish().0);
    }
    check_stopped()?;
    let triangles = lay_out_in(&winding.mesh, surface.unit)?;
    let report = &mut winding.report;
    report.uncertain_area = share_of_area(&triangles, |f| winding.margin.as_slice()[f] < UNCERTAIN);
    if report.uncertain_area > MUCH_UNCERTAIN {
        let (share, margin) = (report.uncertain_area, UNCERTAIN);
        report.warnings.push(Warning::UncertainLabels { share, margin });
    }
    Ok(winding)
}

/// Finds stretches of the curve that look reversed, and the effect of reversing them. Fails with
/// the reason if they can not be compared.
fn orientation(
    surface: &Surface,
    chain: &Chain,
    steps: &[Step],
    walks: &[EmbeddedCurve],
    found: &Found,
    options: &WindingOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Orientation>, String> {
    let stretches = Stretches::of(steps);
    match options.diagnosis {
        Diagnosis::Never => return Ok(None),
        Diagnosis::Automatic if stretches.count() > AUTOMATIC_DIAGNOSIS_LIMIT => return Ok(None),
        Diagnosis::Always if stretches.count() > DIAGNOSIS_LIMIT => {
            let count = stretches.count();
            return Err(format!(
                "it has {count} stretches, more than the {DIAGNOSIS_LIMIT} that can be compared"
            ));
        }
        Diagnosis::Automatic | Diagnosis::Always => {}
    }
    let sizes = (surface.triangles.as_slice(), surface.unit);
    match stretches.diagnose(&surface.mesh, sizes, &surface.on_faces, &found.excluded, walks) {
        Ok(mut orientation) => {
            if !orientation.reversed.is_empty() {
                let jump = orientation.with_reversed(steps, &chain.jump);
                let phases = Phases::begin("orientation").ok();
                let other = phases.and_then(|mut p| solve_chain(surface, &jump, options, &mut p).ok());
                let label = &found.labels.label;
                orientation.changed_area =
                    other.map(|other| changed_area(&surface.triangles, label, &other.labels.label));
                warnings.push(orientation.warning());
            }
            Ok(Some(orientation))
        }
        // The result is valid without the check.
        Err(fault) => Err(fault.to_string()),
    }
}

/// Labels with a smaller margin count as uncertain.
const UNCERTAIN: f64 = 0.1;

/// A larger uncertain share of the area raises a warning. A smaller one is normal along the gaps of
/// a broken curve.
const MUCH_UNCERTAIN: f64 = 0.05;

fn by_curve(curves: usize, steps: &[Step], parts: &[Part]) -> Vec<Vec<Part>> {
    let mut result = vec![Vec::new(); curves];
    for (step, part) in steps.iter().zip(parts) {
        result[step.curve].push(*part);
    }
    result
}
