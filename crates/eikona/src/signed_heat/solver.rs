//! Solver of the signed heat method: factors both systems once, then solves for any number of
//! sources.

use crate::Warning;
use crate::curves::side::consistently_oriented;
use crate::geometry::vector::{add, dot, normalize, scale, sub};
use crate::geometry::{Triangle, lay_out_in};
use crate::operators::divergence;
use crate::phases::{Phases, Running};
use crate::signed_heat::confidence::confidence;
use crate::signed_heat::diffusion::{AssembledDiffusion, Diffusion, UnitField};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::integration::{AssembledIntegration, Integration, Memory, WithHanging};
use crate::signed_heat::options::{DiffusionTime, LevelSets, SOFT_WEIGHT_RANGE, SolveOptions, SolverOptions};
use crate::signed_heat::report::{NormalConstraints, Preparation, Report};
use crate::signed_heat::sheets::Sheets;
use crate::signed_heat::slivers::degenerate_faces;
use crate::signed_heat::solution::Solution;
use crate::signed_heat::source::Source;
use crate::signed_heat::time::{ChosenTime, choose_time};
use eikona_mesh::{Components, ElementId, Face, FaceField, SurfaceCurves, TriangleMesh, Vertex, VertexField};
use eikona_numeric::{Complex, Resources, check_stopped, side_by_side};
use std::sync::OnceLock;

/// Signed heat solver for one triangle mesh: factors both systems once, for any number of sources.
///
/// ```
/// use eikona::signed_heat::{Solver, SolverOptions, SolveOptions};
/// use eikona_mesh::{shapes, Curve, SurfaceCurves, Vertex};
/// // The line x = 5 on a strip of 10 x 2 unit squares, from y = 0 to y = 2: left of it is x < 5.
/// let mesh = shapes::grid(10, 2, 10.0, 2.0, shapes::Diagonal::Alternating)?;
/// let on_line = |v: &Vertex| mesh.position(*v)[0] == 5.0;
/// let curve = Curve::signed(mesh.vertices().filter(on_line));
/// let solver = Solver::new(&mesh, &SolverOptions::default())?;
/// let solution = solver.solve(&SurfaceCurves::from_curve(curve), &SolveOptions::default())?;
/// for v in mesh.vertices() {
///     assert!((solution.distance[v] - (mesh.position(v)[0] - 5.0)).abs() < 1e-9);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Solver {
    /// The mesh, consistently oriented where possible; numbering as given.
    mesh: TriangleMesh,
    triangles: Vec<Triangle>,
    diffusion: AtTime,
    /// With [`DiffusionTime::Automatic`]: the operators for smooth and for rough sources with gaps,
    /// each factored when the first such source is solved.
    for_gaps: Option<[OnceLock<AtTime>; 2]>,
    integration: Integration,
    preparation: Preparation,
    memory: Memory,
}

/// Diffusion operator factored for one diffusion time.
#[derive(Debug)]
struct AtTime {
    time: ChosenTime,
    diffusion: Diffusion,
}

impl Solver {
    /// Sets up and factors both systems.
    ///
    /// # Errors
    /// [`SignedHeatError::NoFaces`], [`SignedHeatError::NoArea`], [`SignedHeatError::Option`],
    /// [`SignedHeatError::Scale`];
    /// [`MemoryLimit`](eikona_numeric::NumericError::MemoryLimit) before anything large is
    /// allocated; failures of the factorisations, with the edge or vertex at which they occurred.
    ///
    /// # Cost
    /// Two sparse factorisations: O(n^1.5) time, O(n log n) memory.
    pub fn new(mesh: &TriangleMesh, options: &SolverOptions) -> Result<Solver, SignedHeatError> {
        let mut phases = Phases::begin("geometry")?;
        if mesh.face_count() == 0 {
            return Err(SignedHeatError::NoFaces);
        }
        let mut warnings = Vec::new();
        let mesh = consistently_oriented(mesh, &mut warnings);
        check_stopped()?;
        let (components, triangles) =
            side_by_side(options.threads, || Components::of(&mesh), || lay_out_in(&mesh, 1.0));
        let triangles = triangles?;
        check_scale(&triangles)?;
        warnings.extend(degenerate_faces(&triangles));
        let time = choose_time(&mesh, &triangles, options.time)?;
        phases.next("analysis")?;

        let (integration, diffusion) = side_by_side(
            options.threads,
            || AssembledIntegration::new(&mesh, &triangles, options.threads),
            || AssembledDiffusion::new(&mesh, &triangles),
        );
        let (integration, diffusion) = (integration?, diffusion?);
        let (symbolic, diffusion) = side_by_side(
            options.threads,
            || integration.symbolic(),
            || diffusion.analysed(&mesh, &integration.vertex_order),
        );
        let (integration, diffusion) = (integration.analysed(symbolic?), diffusion?);
        phases.next("factorisation")?;
        let needed_bytes =
            diffusion.predicted_bytes(options.threads) + integration.predicted_bytes(options.threads);
        let resources = Resources { threads: options.threads, memory_limit: options.memory_limit };
        resources.check(needed_bytes)?;
        let factor_bytes = diffusion.factor_bytes() + integration.factor_bytes();
        let memory = Memory { kept_bytes: factor_bytes, resources };

        let component_of_vertex = components.of_vertex.into_vec();
        if let Some(first) = component_of_vertex.iter().position(Option::is_none) {
            let count = component_of_vertex.iter().filter(|c| c.is_none()).count();
            warnings.push(Warning::UnusedVertices { count, first: Vertex::from_index(first) });
        }
        let diffusion = diffusion.factor(time.time, options.threads)?;
        let integration =
            integration.factor(&mesh, &triangles, component_of_vertex, components.count, memory)?;
        let preparation = Preparation {
            phases: phases.finish(),
            factor_bytes,
            needed_bytes,
            real_frames: diffusion.is_real(),
            warnings,
        };
        Ok(Solver {
            mesh,
            triangles,
            diffusion: AtTime { time, diffusion },
            for_gaps: (options.time == DiffusionTime::Automatic).then(Default::default),
            integration,
            preparation,
            memory,
        })
    }

    /// Computes the distance to curves and points.
    ///
    /// # Errors
    /// [`SignedHeatError::Curve`] with the curve and node, if a node is not on the mesh or out of
    /// range, or if consecutive nodes share no face; [`SignedHeatError::Option`]; failures of the
    /// solves; [`MemoryLimit`](eikona_numeric::NumericError::MemoryLimit) if an additional factor
    /// (for a second diffusion time, for level sets or for sheets attached at vertices only) would
    /// exceed the limit.
    ///
    /// # Cost
    /// * [`LevelSets::Free`]: two back-substitutions.
    /// * Constraints: one more factorisation of the vertex system; for [`LevelSets::PerComponent`]
    ///   also its symbolic analysis, for any number of pieces; up to two factorisations for
    ///   [`LevelSets::Automatic`].
    /// * Parts of the mesh hundreds of edges away from the source: one more back-substitution for
    ///   each such distance.
    /// * Sheets attached to the reached surface at vertices only: one more factorisation of the
    ///   vertex system.
    /// * [`DiffusionTime::Automatic`]: one more factorisation of the diffusion operator, which is
    ///   kept, for the first source with gaps. [`DiffusionTime::for_source`] chooses that time from
    ///   the start.
    pub fn solve(&self, source: &SurfaceCurves, options: &SolveOptions) -> Result<Solution, SignedHeatError> {
        let mut phases = Phases::begin("source")?;
        if let LevelSets::Soft(weight) = options.level_sets
            && !SOFT_WEIGHT_RANGE.contains(&weight)
        {
            return Err(SignedHeatError::Option {
                name: "soft weight",
                value: weight,
                bound: "from 1e-9 to 1e12",
            });
        }
        let AtTime { time, diffusion } = self.at_time_for(source, &mut phases)?;
        check_stopped()?;
        let curves = source.curves.len();
        let source = Source::new(&self.mesh, !diffusion.is_real(), source)?;
        phases.next("diffusion")?;

        // Steps I and II: diffuse the normals, normalise per face.
        let mut field = diffusion.unit_field(&self.mesh, &self.triangles, &source, options)?;
        let hanging = self.hanging_faces(&field);
        let with_hanging = match &hanging {
            Some((sheets, hanging)) => {
                let fit = self.integration.with_hanging(&self.mesh, hanging)?;
                self.bridge_vertices(diffusion, &source, sheets, hanging, &fit, &mut field)?;
                Some(fit)
            }
            None => None,
        };
        phases.next("integration")?;

        // Step III: integrate.
        check_stopped()?;
        let weighted = with_hanging.as_ref().map(|fit| fit.weighted(&field.vectors));
        let integration = with_hanging.as_ref().map_or(&self.integration, |fit| &fit.integration);
        let integrated = integration.integrate(
            &self.mesh,
            &self.triangles,
            weighted.as_ref().unwrap_or(&field.vectors),
            &field.reached,
            &source,
            options.level_sets,
        )?;
        phases.next("confidence")?;
        let confidence = options
            .confidence
            .then(|| confidence(&self.mesh, &self.triangles, &source, &field, &integrated.values));

        check_stopped()?;
        let has_source = self.integration.has_source(&self.mesh, &source);
        let levels = source.means(&self.mesh, curves, &integrated.values);
        let mut warnings = source.warnings;
        warnings.extend(integrated.warnings);
        warnings.extend(field.normal_constraints.as_ref().and_then(NormalConstraints::warning));
        self.warn_unreached(&integrated.values, &has_source, &mut warnings);
        Ok(Solution {
            distance: VertexField::from(integrated.values),
            gradient: self.gradient(&field.vectors),
            confidence,
            report: Report {
                preparation: self.preparation.clone(),
                time: time.clone(),
                phases: phases.finish(),
                stages: field.stages,
                diffusion_residual: field.residual,
                normal_constraints: field.normal_constraints,
                integration_residual: integrated.residual,
                level_sets: integrated.chosen,
                constraint_violation: integrated.constraint_violation,
                levels,
                source_segments: source.segments.len(),
                source_points: source.points.len(),
                warnings,
            },
        })
    }

    /// The mesh that the solver works on: consistently oriented where possible, numbered as given.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// The diffusion time and the reason for it. With [`DiffusionTime::Automatic`], this is the
    /// time for sources without gaps; each [`Report`] has the time that was used.
    pub fn time(&self) -> &ChosenTime {
        &self.diffusion.time
    }

    /// Returns the diffusion operator for a source, by the rule of [`DiffusionTime::for_source`].
    fn at_time_for(&self, source: &SurfaceCurves, phases: &mut Running) -> Result<&AtTime, SignedHeatError> {
        let Some(for_gaps) = &self.for_gaps else { return Ok(&self.diffusion) };
        let wanted = DiffusionTime::Automatic.for_source(&self.mesh, source);
        let for_gaps = match wanted {
            DiffusionTime::ForGaps => &for_gaps[0],
            DiffusionTime::ForRoughGaps => &for_gaps[1],
            _ => return Ok(&self.diffusion),
        };
        if let Some(made) = for_gaps.get() {
            return Ok(made);
        }
        phases.next("factorisation")?;
        let own = &self.diffusion.diffusion;
        self.memory.check(own.predicted_bytes(self.memory.resources.threads))?;
        let time = choose_time(&self.mesh, &self.triangles, wanted)?;
        let diffusion = own.at(&self.mesh, &self.triangles, time.time, self.memory.resources.threads)?;
        phases.next("source")?;
        Ok(for_gaps.get_or_init(|| AtTime { time, diffusion }))
    }

    /// Returns the sheets, and which faces belong to unreached sheets attached to reached ones at
    /// vertices only; `None` if there are none.
    fn hanging_faces(&self, field: &UnitField) -> Option<(Sheets, Vec<bool>)> {
        if field.reached.iter().all(|r| *r) {
            return None;
        }
        let sheets = Sheets::of(&self.mesh);
        let hanging = sheets.hanging(&field.reached);
        (!sheets.front(&self.mesh, &hanging).is_empty()).then_some((sheets, hanging))
    }

    /// Extends the field into the hanging sheets: one fit gives the distance at the vertices that
    /// they share with reached sheets, and one more diffusion continues from there. Sheets share no
    /// edges, so they do not interact.
    fn bridge_vertices(
        &self,
        diffusion: &Diffusion,
        source: &Source,
        sheets: &Sheets,
        hanging: &[bool],
        fit: &WithHanging,
        field: &mut UnitField,
    ) -> Result<(), SignedHeatError> {
        let mut b = divergence(&self.mesh, &self.triangles, &field.vectors);
        b.iter_mut().for_each(|x| *x = -*x);
        let phi = fit.integration.fit(&b)?.values;
        let zero = self.integration.mean_at_source(&self.mesh, &phi, source);
        let distance = |v: Vertex| {
            let component = self.integration.component_of_vertex()[v.index()].unwrap_or(0) as usize;
            phi[v.index()] - zero[component]
        };
        let front: Vec<(Vertex, f64)> =
            sheets.front(&self.mesh, hanging).into_iter().map(|v| (v, distance(v))).collect();
        let entrances = sheets.entrances(&self.mesh, &self.triangles, hanging, &front);
        diffusion.continue_from(&self.mesh, &self.triangles, sheets, &entrances, field)
    }

    /// Warns of each component whose distance is NaN. `has_source` says per component whether it
    /// has a curve or point.
    fn warn_unreached(&self, values: &[f64], has_source: &[bool], warnings: &mut Vec<Warning>) {
        // Number of faces and the first of them, per component.
        let mut faces = vec![(0usize, Face(0)); self.integration.component_count()];
        for f in self.mesh.faces() {
            let v = self.mesh.face_vertices(f)[0].index();
            if let (true, Some(c)) = (values[v].is_nan(), self.integration.component_of_vertex()[v]) {
                let (count, first) = &mut faces[c as usize];
                *first = if *count == 0 { f } else { *first };
                *count += 1;
            }
        }
        for (component, &(count, first)) in faces.iter().enumerate().filter(|(_, (count, _))| *count > 0) {
            warnings.push(if has_source[component] {
                Warning::CancelledComponent { component, faces: count, first }
            } else {
                Warning::UnreachedComponent { component, faces: count, first }
            });
        }
    }

    /// Converts one tangent vector per face to unit vectors in space.
    fn gradient(&self, vectors: &[Complex]) -> FaceField<[f64; 3]> {
        self.mesh
            .faces()
            .zip(vectors)
            .map(|(face, y)| {
                let [a, b, c] = self.mesh.face_positions(face);
                let along = normalize(sub(b, a)).unwrap_or_default();
                let other = sub(c, a);
                let across = normalize(sub(other, scale(along, dot(other, along)))).unwrap_or_default();
                add(scale(along, y.re), scale(across, y.im))
            })
            .collect::<Vec<_>>()
            .into()
    }
}

/// Longest edges for which squares of lengths, and quotients of these, are normal numbers.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

fn check_scale(triangles: &[Triangle]) -> Result<(), SignedHeatError> {
    let scale = |i: usize| SignedHeatError::Scale { face: Face(i as u32), lengths: triangles[i].lengths };
    let (mut longest, mut its_face) = (0.0, 0);
    for (i, t) in triangles.iter().enumerate() {
        let side = t.lengths.iter().fold(0.0f64, |m, l| m.max(*l));
        if side.is_nan() || side > *LENGTHS.end() {
            return Err(scale(i));
        }
        if side > longest {
            (longest, its_face) = (side, i);
        }
    }
    if triangles.iter().all(|t| t.mollified) {
        return Err(SignedHeatError::NoArea);
    }
    if longest < *LENGTHS.start() {
        return Err(scale(its_face));
    }
    Ok(())
}
