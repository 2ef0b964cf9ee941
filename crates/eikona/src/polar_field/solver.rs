//! Prepares a mesh once; solves for any number of prescriptions.

use crate::Warning;
use crate::curves::side::consistently_oriented;
use crate::geometry::{lay_out_in, unit_of};
use crate::phases::Phases;
use crate::polar_field::alignment::Following;
use crate::polar_field::automatic::{Prescription, prescription};
use crate::polar_field::bevel::{BeveledMesh, Cycle, PerCycle, Rotation};
use crate::polar_field::domain::Domain;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::field::{Phased, Values};
use crate::polar_field::guides::paths;
use crate::polar_field::homology::Homology;
use crate::polar_field::options::{AutomaticOptions, FieldOptions, SolverOptions};
use crate::polar_field::particular::particular_rotation;
use crate::polar_field::powers::{FaceSystem, powers};
use crate::polar_field::scale::{ScaleSearch, smoothest_scales, ties};
use crate::polar_field::singularity::{Prescribed, Singularity, located, name, turns_of_cycles, whole_turns};
use crate::polar_field::smoothness::CornerLaplacian;
use crate::polar_field::solution::{FieldReport, Measured, PolarField};
use crate::polar_field::targets::{needed_sum, targets};
use eikona_mesh::{Topology, TriangleMesh};
use eikona_numeric::{NumericError, Resources, check_stopped};
use std::f64::consts::TAU;
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
    /// [`PolarFieldError::FlatFace`]; failures of the factorisation.
    ///
    /// # Cost
    /// A sparse factorisation on the corners: O(F^1.5) time, O(F log F) memory.
    pub fn new(mesh: &TriangleMesh, options: &SolverOptions) -> Result<Solver, PolarFieldError> {
        let mut phases = Phases::begin("geometry")?;
        if mesh.face_count() == 0 {
            return Err(PolarFieldError::NoFaces);
        }
        let topology = Topology::of(mesh);
        check_stopped()?;
        check_surface(mesh, &topology)?;
        let mut warnings = Vec::new();
        let mesh = consistently_oriented(mesh, &mut warnings);
        // The numbers of boundary halfedges depend on the orientation.
        let topology = if warnings.is_empty() { topology } else { Topology::of(&mesh) };
        let triangles = lay_out_in(&mesh, unit_of(&mesh))?;
        if let Some(face) = mesh.faces().find(|f| triangles[f.index()].mollified) {
            return Err(PolarFieldError::FlatFace { face });
        }
        phases.next("bevel")?;
        let bevel = BeveledMesh::new(&mesh, topology, triangles);
        check_stopped()?;
        let homology = Homology::of(&bevel);
        check_stopped()?;
        let (connection, curvature) = (bevel.connection(), bevel.curvature());
        phases.next("factorisation")?;
        let resources = options.resources();
        let laplacian = CornerLaplacian::new(&bevel, resources)?;
        let faces = FaceSystem::new(resources);
        let domain = Domain { bevel, homology, connection, curvature }.into();
        Ok(Solver { domain, laplacian, faces, resources, warnings, phases: phases.finish() })
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
    /// [`PolarFieldError::Conflict`]; failures of the solves.
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
        let Domain { bevel, homology, connection, curvature } = &*self.domain;
        let degree = options.degree;
        let mut phases = Phases::begin("prescription")?;
        check_degree(degree)?;
        let expected = homology.generators.len();
        if !options.generators.is_empty() && options.generators.len() != expected {
            return Err(PolarFieldError::Generators { found: options.generators.len(), expected });
        }
        let prescribed = located(bevel, singularities, degree)?;
        let turns = turns_of_cycles(bevel, &prescribed, degree)?;
        let mut wanted = bevel.constant(0.0);
        for cycle in bevel.cycles() {
            wanted[cycle] = needed_sum(turns[cycle], degree, curvature[cycle]);
        }
        let n = f64::from(degree);
        let mut along = Vec::with_capacity(expected);
        for (i, generator) in homology.generators.iter().enumerate() {
            let index = options.generators.get(i).copied().unwrap_or(0.0);
            let turns = whole_turns(index, degree, || format!("generator {i}"))?;
            along.push(TAU * turns as f64 - n * generator.curvature);
        }
        let theta = particular_rotation(bevel, homology, &wanted, &along);
        let paths = paths(bevel, &options.guides, degree)?;
        let following = Following { paths: &paths, degree, weight: options.guide_weight };
        if let Some(weight) = options.guide_weight.filter(|weight| !(*weight > 0.0 && weight.is_finite())) {
            return Err(PolarFieldError::GuideWeight { weight });
        }
        phases.next("rotation")?;
        let near = targets(bevel, &prescribed, |v| wanted.vertex[v]);
        let smoothest = self.laplacian.smoothest(bevel, theta, &near)?;
        let start = vec![0.0; bevel.topology.components.len()];
        let mut phased = Phased { theta: smoothest, start };
        if !paths.is_empty() {
            phases.next("alignment")?;
            let evaluate = |phased: &Phased| {
                self.evaluated(&prescribed, phased, guess, degree, |_| Ok(())).map(|(values, ..)| values)
            };
            phased = following.turned(bevel, &self.laplacian, &near, phased.theta, evaluate)?;
        }
        // Rounding adds up along the trees; what is missing now is small, and its rounding smaller.
        let ((cycles, generators), _) = missing_sums(&self.domain, &phased.theta, &wanted, &along);
        phased.theta.add(1.0, &particular_rotation(bevel, homology, &cycles, &generators));
        let (_, residual) = missing_sums(&self.domain, &phased.theta, &wanted, &along);
        let (values, unplaced, search) =
            self.evaluated(&prescribed, &phased, guess, degree, |phase| phases.next(phase))?;
        let seen = values.measured(bevel, connection, |c| curvature[c], degree);
        let aliased: Vec<(Cycle, i64)> = seen.into_iter().filter(|&(c, i)| i != turns[c]).collect();
        let measured = prescribed
            .iter()
            .map(|s| aliased.iter().find(|(c, _)| *c == s.cycle).map_or(s.turns, |(_, i)| *i) as f64 / n)
            .collect();
        let report = FieldReport {
            phases: phases.finish(),
            preparation: self.phases.clone(),
            residual,
            closure: values.closure,
            energy: bevel.energy(&phased.theta),
            measured,
            aliased: aliased
                .into_iter()
                .map(|(c, i)| Measured {
                    element: name(c),
                    prescribed: turns[c] as f64 / n,
                    measured: i as f64 / n,
                })
                .collect(),
            unplaced: unplaced.into_iter().map(name).collect(),
            followed: following.followed(&values),
            largest_power: values.powers.as_slice().iter().max().copied().unwrap_or(1),
            scale_rounds: search.rounds,
            scales_at_bound: search.active.len(),
            scales_gave_up: search.gave_up,
            warnings: self.warnings.clone(),
        };
        Ok(PolarField { domain: self.domain.clone(), values, degree, lowest_corners: search.active, report })
    }

    /// Returns the field of a rotation, the edges without a place for their singularity, and the
    /// search for the scales.
    fn evaluated(
        &self,
        prescribed: &[Prescribed],
        phased: &Phased,
        guess: &[u32],
        degree: u32,
        mut phase: impl FnMut(&'static str) -> Result<(), NumericError>,
    ) -> Result<(Values, Vec<Cycle>, ScaleSearch), PolarFieldError> {
        let bevel = &self.domain.bevel;
        phase("powers")?;
        let powers = powers(bevel, &self.faces, prescribed, &phased.theta)?;
        phase("scales")?;
        let ties = ties(bevel, prescribed, &phased.theta, &powers);
        let (scales, search) = smoothest_scales(bevel, &self.laplacian, &ties.ties, guess)?;
        phase("integration")?;
        Ok((Values::new(&self.domain, phased, &scales, powers, degree), ties.unplaced, search))
    }
}

/// Returns what is missing from the prescribed sums around cycles and along generators, and the
/// largest of it.
fn missing_sums(
    Domain { bevel, homology, .. }: &Domain,
    theta: &Rotation,
    wanted: &PerCycle<f64>,
    along: &[f64],
) -> ((PerCycle<f64>, Vec<f64>), f64) {
    let mut missing = bevel.sums(theta);
    let mut largest = 0.0f64;
    for cycle in bevel.cycles() {
        missing[cycle] = wanted[cycle] - missing[cycle];
        largest = largest.max(missing[cycle].abs());
    }
    let of_generators: Vec<f64> =
        homology.generators.iter().zip(along).map(|(g, wanted)| wanted - g.sum(theta)).collect();
    let largest = of_generators.iter().fold(largest, |m, x| m.max(x.abs()));
    ((missing, of_generators), largest)
}

fn check_degree(degree: u32) -> Result<(), PolarFieldError> {
    if (1..=1000).contains(&degree) { Ok(()) } else { Err(PolarFieldError::Degree { degree }) }
}

/// Refuses surfaces on which a field has no sense.
fn check_surface(mesh: &TriangleMesh, topology: &Topology) -> Result<(), PolarFieldError> {
    if let Some(&edge) = topology.nonmanifold_edges.first() {
        let (vertices, faces) = (mesh.edge_vertices(edge), mesh.edge_halfedges(edge).len());
        return Err(PolarFieldError::NonmanifoldEdge { edge, vertices, faces });
    }
    if let Some(v) = topology.nonmanifold_vertices.first() {
        return Err(PolarFieldError::NonmanifoldVertex { vertex: v.vertex, fans: v.fans });
    }
    match topology.components.iter().position(|c| !c.orientable) {
        Some(component) => {
            let first_face = topology.components[component].first_face;
            Err(PolarFieldError::NotOrientable { component, first_face })
        }
        None => Ok(()),
    }
}
