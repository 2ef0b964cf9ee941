//! Prepares a mesh once; solves for any number of prescriptions.

use crate::Warning;
use crate::phases::Phases;
use crate::polar_field::alignment::Following;
use crate::polar_field::automatic::{Prescription, prescription};
use crate::polar_field::bevel::Cycle;
use crate::polar_field::domain::Domain;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::field::{Phased, Values};
use crate::polar_field::guides::{missing_creases, paths};
use crate::polar_field::options::{AutomaticOptions, FieldOptions, Smoothness, SolverOptions};
use crate::polar_field::powers::{FaceSystem, powers};
use crate::polar_field::problem::{Problem, check_closed, check_degree};
use crate::polar_field::scale::{ScaleSearch, smoothest_scales, ties};
use crate::polar_field::singularity::{Singularity, name};
use crate::polar_field::smoothness::CornerLaplacian;
use crate::polar_field::solution::{FieldReport, Measured, PolarField};
use crate::polar_field::surface::Surface;
use crate::polar_field::targets::targets;
use crate::polar_field::trivial::trivial_rotation;
use eikona_mesh::{FaceField, TriangleMesh};
use eikona_numeric::{NumericError, Resources, check_stopped};
use std::sync::Arc;

/// A mesh with its beveled mesh and factored energy, reused from prescription to prescription.
#[derive(Debug)]
pub struct Solver {
    pub(super) domain: Arc<Domain>,
    laplacian: CornerLaplacian,
    faces: FaceSystem,
    resources: Resources,
    warnings: Vec<Warning>,
    phases: Phases,
}

impl Solver {
    /// Orients the mesh, and analyses and factors the energy.
    ///
    /// # Errors
    /// [`PolarFieldError::NoFaces`], [`PolarFieldError::NonmanifoldEdge`],
    /// [`PolarFieldError::NonmanifoldVertex`], [`PolarFieldError::NotOrientable`],
    /// [`PolarFieldError::FlatFace`], [`PolarFieldError::Regularizer`]; failures of the
    /// factorisation.
    ///
    /// # Cost
    /// A sparse factorisation on the corners: O(F^1.5) time, O(F log F) memory.
    pub fn new(mesh: &TriangleMesh, options: &SolverOptions) -> Result<Solver, PolarFieldError> {
        if let Smoothness::Printed { regularizer } = options.smoothness
            && !(regularizer > 0.0 && regularizer.is_finite())
        {
            return Err(PolarFieldError::Regularizer { regularizer });
        }
        let mut phases = Phases::begin("surface")?;
        let Surface { bevel, warnings } = Surface::of(mesh)?;
        check_stopped()?;
        let domain = Domain::new(bevel)?;
        phases.next("factorisation")?;
        let resources = options.resources();
        let laplacian = CornerLaplacian::new(&domain.bevel, options.smoothness, resources)?;
        let faces = FaceSystem::new(resources);
        Ok(Solver { domain: domain.into(), laplacian, faces, resources, warnings, phases: phases.finish() })
    }

    /// Returns the mesh of the field: the input, with faces flipped to a consistent orientation.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.domain.bevel.mesh
    }

    /// Returns the number of homology generators, two per handle.
    pub fn generator_count(&self) -> usize {
        self.domain.homology.generators.len()
    }

    /// Returns a first prescription, to be edited or solved as it is: the indices of the smoothest
    /// field of N directions, or of the smoothest near what it should follow.
    ///
    /// The indices add up to the Euler characteristic of each component.
    ///
    /// # Errors
    /// [`PolarFieldError::Degree`]; [`PolarFieldError::NoBoundary`] and other faults of the guides;
    /// [`PolarFieldError::CurvatureWithOddDegree`]; failures of the solves.
    ///
    /// # Cost
    /// A factorisation on the faces, and some ten solves.
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::polar_field::{AutomaticOptions, FieldOptions, Solver};
    /// let sphere = shapes::icosphere(3)?;
    /// let solver = Solver::new(&sphere, &Default::default())?;
    /// let found = solver.automatic(&AutomaticOptions::default())?;
    /// assert_eq!(found.singularities.iter().map(|s| s.index).sum::<f64>(), 2.0);
    /// let field = solver.solve(&found.singularities, &FieldOptions::default())?;
    /// assert!(field.report.aliased.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn automatic(&self, options: &AutomaticOptions) -> Result<Prescription, PolarFieldError> {
        check_degree(options.degree)?;
        prescription(&self.domain, options, self.resources)
    }

    /// Computes the smoothest field with these singularities.
    ///
    /// # Errors
    /// [`PolarFieldError::Degree`]; [`PolarFieldError::Index`], [`PolarFieldError::IndexSum`] and
    /// the other faults of a prescription, before anything is solved;
    /// [`PolarFieldError::FaceAndEdge`]; [`PolarFieldError::Conflict`];
    /// [`PolarFieldError::NotClosed`]; failures of the solves.
    ///
    /// # Cost
    /// A few back-substitutions, and one factorisation on the faces if some index times N is beyond
    /// 1.
    pub fn solve(
        &self,
        singularities: &[Singularity],
        options: &FieldOptions,
    ) -> Result<PolarField, PolarFieldError> {
        self.solve_from(&[], singularities, options)
    }

    /// Computes the smoothest field of an edited prescription: some singularities of `previous`
    /// were moved, added, removed or given another index.
    ///
    /// The field is that of [`solve`](Self::solve) up to rounding, but is found sooner: the search
    /// for the scales starts from those of the previous field. Whatever does not depend on the
    /// edited elements is kept by the solver in either case.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve). `previous` may be of any prescription and degree, but must be
    /// of this solver; a field of another one is no help, and no harm.
    pub fn edit(
        &self,
        previous: &PolarField,
        singularities: &[Singularity],
        options: &FieldOptions,
    ) -> Result<PolarField, PolarFieldError> {
        let is_own = Arc::ptr_eq(&previous.domain, &self.domain);
        self.solve_from(if is_own { &previous.lowest_corners } else { &[] }, singularities, options)
    }

    /// Solves, with a guess of the corners with the lowest scales.
    fn solve_from(
        &self,
        guess: &[u32],
        singularities: &[Singularity],
        options: &FieldOptions,
    ) -> Result<PolarField, PolarFieldError> {
        let bevel = &self.domain.bevel;
        let mut phases = Phases::begin("prescription")?;
        let problem = Problem::new(&self.domain, singularities, options)?;
        let paths = paths(bevel, &options.guides, problem.degree)?;
        let missing = missing_creases(bevel, &options.guides);
        check_stopped()?;
        let particular = problem.particular()?;
        phases.next("rotation")?;
        let near = targets(bevel, &problem.prescribed, |v| problem.around.vertex[v]);
        let smoothest = self.laplacian.smoothest(bevel, particular, &near)?;
        let start = vec![0.0; bevel.topology.components.len()];
        let mut phased = Phased { theta: smoothest, start };
        let following = Following { paths: &paths, degree: problem.degree, weight: options.guide_weight };
        if !paths.is_empty() {
            phases.next("alignment")?;
            let evaluate = |phased: &Phased| Ok(self.evaluated(&problem, phased, guess, |_| Ok(()))?.values);
            phased = following.turned(bevel, &self.laplacian, &near, phased.theta, evaluate)?;
        }
        check_stopped()?;
        let residual = problem.correct(&mut phased.theta)?;
        let evaluated = self.evaluated(&problem, &phased, guess, |phase| phases.next(phase))?;
        check_closed(residual, evaluated.values.closure, problem.degree)?;
        let followed = following.followed(&evaluated.values);
        let mut field = self.field(&problem, &phased, evaluated)?;
        field.report.residual = residual;
        field.report.followed = followed;
        field.report.warnings.extend(missing);
        field.report.phases = phases.finish();
        Ok(field)
    }

    /// Computes the trivial connection with these singularities: a field that is constant in each
    /// face, with the least square sum of rotations across edges. For comparison; its singularities
    /// are at vertices and boundary loops only, and it follows no guides.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve); [`PolarFieldError::NotAtVertex`].
    ///
    /// # Cost
    /// A factorisation on the vertices.
    ///
    /// # Reference
    /// Keenan Crane, Mathieu Desbrun and Peter Schröder, *Trivial Connections on Discrete
    /// Surfaces*, 2010.
    ///
    /// ```
    /// use eikona::mesh::{SurfacePoint, shapes};
    /// use eikona::polar_field::{FieldOptions, Place, Singularity, Solver};
    /// let sphere = shapes::icosphere(3)?;
    /// let at = |vertex| Place::Point(SurfacePoint::Vertex { vertex });
    /// let poles = [0, 11].map(|v| Singularity { place: at(v), index: 1.0 });
    /// let options = FieldOptions::default().with_degree(1);
    /// let solver = Solver::new(&sphere, &Default::default())?;
    /// let smooth = solver.solve(&poles, &options)?;
    /// let flat = solver.trivial_connection(&poles, &options)?;
    /// assert_eq!(flat.report.measured, [1.0, 1.0]);
    /// assert!(smooth.report.energy < flat.report.energy);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn trivial_connection(
        &self,
        singularities: &[Singularity],
        options: &FieldOptions,
    ) -> Result<PolarField, PolarFieldError> {
        let bevel = &self.domain.bevel;
        let mut phases = Phases::begin("prescription")?;
        let problem = Problem::new(&self.domain, singularities, options)?;
        phases.next("rotation")?;
        let theta = trivial_rotation(&self.domain, &problem, self.resources)?;
        let residual = problem.residual(&theta)?;
        phases.next("integration")?;
        let phased = Phased { theta, start: vec![0.0; bevel.topology.components.len()] };
        let ones = FaceField::constant(bevel.mesh.face_count(), 1);
        let scales = vec![1.0; bevel.mesh.halfedge_count()];
        let values = Values::new(&self.domain, &phased, &scales, ones, problem.degree)?;
        check_closed(residual, values.closure, problem.degree)?;
        let evaluated = Evaluated { values, unplaced: Vec::new(), search: ScaleSearch::default() };
        let mut field = self.field(&problem, &phased, evaluated)?;
        field.report.residual = residual;
        field.report.phases = phases.finish();
        Ok(field)
    }

    /// Returns the field of a rotation.
    fn evaluated(
        &self,
        problem: &Problem<'_>,
        phased: &Phased,
        guess: &[u32],
        mut phase: impl FnMut(&'static str) -> Result<(), NumericError>,
    ) -> Result<Evaluated, PolarFieldError> {
        let bevel = &self.domain.bevel;
        phase("powers")?;
        let powers = powers(bevel, &self.faces, &problem.prescribed, &phased.theta)?;
        phase("scales")?;
        let ties = ties(bevel, &problem.prescribed, &phased.theta, &powers);
        let (scales, search) = smoothest_scales(bevel, &self.laplacian, &ties.ties, guess)?;
        phase("integration")?;
        let values = Values::new(&self.domain, phased, &scales, powers, problem.degree)?;
        Ok(Evaluated { values, unplaced: ties.unplaced, search })
    }

    /// Measures the field and reports.
    fn field(
        &self,
        problem: &Problem<'_>,
        phased: &Phased,
        evaluated: Evaluated,
    ) -> Result<PolarField, NumericError> {
        let Domain { bevel, connection, curvature, .. } = &*self.domain;
        let Evaluated { values, unplaced, search } = evaluated;
        let n = f64::from(problem.degree);
        let seen = values.measured(bevel, connection, |c| curvature[c], problem.degree)?;
        check_stopped()?;
        let aliased = bevel.cycles().filter(|&c| seen[c] != problem.turns[c]);
        let report = FieldReport {
            preparation: self.phases.clone(),
            closure: values.closure,
            energy: bevel.energy(&phased.theta),
            printed_energy: bevel.printed_energies(&phased.theta, [50.0, 1.0]),
            measured: problem.prescribed.iter().map(|s| seen[s.cycle] as f64 / n).collect(),
            aliased: aliased
                .map(|c| Measured {
                    element: name(c),
                    prescribed: problem.turns[c] as f64 / n,
                    measured: seen[c] as f64 / n,
                })
                .collect(),
            unplaced: unplaced.into_iter().map(name).collect(),
            largest_power: values.powers.as_slice().iter().max().copied().unwrap_or(1),
            scale_rounds: search.rounds,
            scales_at_bound: search.active.len(),
            scales_gave_up: search.gave_up,
            warnings: self.warnings.clone(),
            ..FieldReport::default()
        };
        let (domain, degree) = (self.domain.clone(), problem.degree);
        let singular = problem.prescribed.clone();
        Ok(PolarField { domain, values, degree, singular, lowest_corners: search.active, report })
    }
}

/// The field of a rotation, as far as it could be placed.
struct Evaluated {
    values: Values,
    /// Faces and edges whose singular point could not be placed.
    unplaced: Vec<Cycle>,
    search: ScaleSearch,
}
