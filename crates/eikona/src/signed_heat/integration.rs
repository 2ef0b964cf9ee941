//! Step III: least-squares fit of the function whose gradient is closest to the unit field (SHM eq.
//! 13), and its shift. Fits with level set constraints are in `level_sets.rs`.

use crate::Warning;
use crate::geometry::Triangle;
use crate::geometry::vector::distance;
use crate::operators::{CotanLaplacian, divergence};
use crate::signed_heat::automatic::ChosenLevelSets;
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::options::LevelSets;
use crate::signed_heat::refinement::{Refined, refined};
use crate::signed_heat::slivers::Slivers;
use crate::signed_heat::source::Source;
use eikona_mesh::{CurveKind, Located, TriangleMesh};
use eikona_numeric::{
    Cholesky, Complex, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, check_step,
    check_stopped, nested_dissection_order,
};
use std::sync::Arc;

/// Cotan Laplacian, grounded and factored.
#[derive(Debug)]
pub(crate) struct Integration {
    pub(super) laplacian: CotanLaplacian,
    /// One vertex per component, at which a term is added to the diagonal. If the right-hand side
    /// sums to zero over the component, as a divergence does, this makes the value at the vertex
    /// exactly zero and changes nothing else.
    pub(super) grounded: Vec<Ground>,
    pub(super) factor: Cholesky<f64>,
    /// Elimination order of the vertices.
    pub(super) vertex_order: Vec<u32>,
    /// Component of each vertex; `None` for a vertex without faces.
    pub(super) component_of_vertex: Vec<Option<u32>>,
    pub(super) component_count: usize,
    /// Square root of the area of each component.
    pub(super) size_of_component: Vec<f64>,
    /// Slivers, where the assembled matrix is inexact.
    pub(super) slivers: Option<Slivers>,
    pub(super) memory: Memory,
}

/// Memory that a solver holds, and its limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    pub kept_bytes: usize,
    pub resources: Resources,
}

impl Memory {
    /// Returns an error if one more factor of this size would exceed the limit.
    pub fn check(&self, more_bytes: usize) -> Result<(), NumericError> {
        self.resources.check(self.kept_bytes + more_bytes)
    }
}

/// Weight of the faces of hanging sheets in a fit. Their influence on the other faces is below
/// rounding, while they fit their own field as closely as the values at their joints allow.
const HANGING: f64 = 1e-12;

#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    pub vertex: u32,
    pub component: u32,
}

/// Analysed operator, not yet factored.
pub(crate) struct PreparedIntegration {
    laplacian: CotanLaplacian,
    symbolic: Symbolic,
    vertex_order: Vec<u32>,
}

/// Fitted distance, with residuals and warnings.
#[derive(Debug)]
pub(crate) struct Integrated {
    /// One value per vertex; NaN where no source reaches.
    pub values: Vec<f64>,
    /// Largest relative residual of the solves.
    pub residual: f64,
    /// Largest deviation of a value on the curves from its level, in the unit of length; `None`
    /// without constraints.
    pub constraint_violation: Option<f64>,
    /// Violated constraints, and digits lost on slivers.
    pub warnings: Vec<Warning>,
    /// Level sets, and the reason for them.
    pub chosen: ChosenLevelSets,
}

/// Unconstrained fit.
pub(crate) struct Fit {
    /// One value per vertex.
    pub values: Vec<f64>,
    /// Relative residual.
    pub residual: f64,
    /// Whether slivers cost digits.
    pub warning: Option<Warning>,
}

/// Assembled operator with an elimination order, not yet analysed.
pub(crate) struct AssembledIntegration {
    laplacian: CotanLaplacian,
    pub vertex_order: Vec<u32>,
}

impl AssembledIntegration {
    pub fn new(mesh: &TriangleMesh, triangles: &[Triangle], threads: usize) -> Result<Self, NumericError> {
        let laplacian = CotanLaplacian::new(mesh, triangles);
        check_stopped()?;
        let vertex_order = nested_dissection_order(&laplacian.graph, mesh.positions(), threads)?;
        Ok(AssembledIntegration { laplacian, vertex_order })
    }

    pub fn symbolic(&self) -> Result<Symbolic, NumericError> {
        Symbolic::new(&self.laplacian.graph, Ordering::Given(&self.vertex_order))
    }

    pub fn analysed(self, symbolic: Symbolic) -> PreparedIntegration {
        PreparedIntegration { symbolic, laplacian: self.laplacian, vertex_order: self.vertex_order }
    }
}

impl PreparedIntegration {
    pub fn predicted_bytes(&self, threads: usize) -> usize {
        self.symbolic.predicted_bytes::<f64>(threads)
    }

    pub fn factor_bytes(&self) -> usize {
        self.symbolic.factor_bytes::<f64>()
    }

    pub fn factor(
        self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        component_of_vertex: Vec<Option<u32>>,
        component_count: usize,
        memory: Memory,
    ) -> Result<Integration, SignedHeatError> {
        check_stopped()?;
        let mut laplacian = self.laplacian;
        let mut grounded = Vec::with_capacity(component_count);
        let mut is_grounded = vec![false; component_count];
        for (v, component) in component_of_vertex.iter().enumerate() {
            check_step(v)?;
            match component {
                None => laplacian.matrix.diagonal[v] = 1.0, // occurs in no equation
                Some(c) if !is_grounded[*c as usize] => {
                    is_grounded[*c as usize] = true;
                    grounded.push(Ground { vertex: v as u32, component: *c });
                }
                Some(_) => {}
            }
        }
        check_stopped()?;
        let mut size_of_component = vec![0.0; component_count];
        for (f, (corners, t)) in mesh.triangles().iter().zip(triangles).enumerate() {
            check_step(f)?;
            if let Some(c) = component_of_vertex[corners[0] as usize] {
                size_of_component[c as usize] += t.area;
            }
        }
        size_of_component.iter_mut().for_each(|a| *a = a.sqrt());
        check_stopped()?;
        let matrix = grounded_matrix(&laplacian, grounded.iter());
        let factor = Cholesky::on_threads(Arc::new(self.symbolic), &matrix, memory.resources.threads)
            .map_err(at_vertex)?;
        check_stopped()?;
        let slivers = Slivers::of(mesh, triangles)?;
        check_stopped()?;
        Ok(Integration {
            laplacian,
            grounded,
            factor,
            vertex_order: self.vertex_order,
            component_of_vertex,
            component_count,
            size_of_component,
            slivers,
            memory,
        })
    }
}

/// Fit in which hanging sheets follow the surface they are attached to without influencing it.
pub(crate) struct WithHanging<'a> {
    pub integration: Integration,
    hanging: &'a [bool],
}

impl WithHanging<'_> {
    /// Multiplies a field by the weights of the fit.
    pub fn weighted(&self, field: &[Complex]) -> Vec<Complex> {
        let weigh = |(y, hanging): (&Complex, &bool)| if *hanging { y.scale(HANGING) } else { *y };
        field.iter().zip(self.hanging).map(weigh).collect()
    }
}

pub(super) fn grounded_matrix<'a>(
    laplacian: &CotanLaplacian,
    grounded: impl Iterator<Item = &'a Ground>,
) -> SymmetricMatrix<f64> {
    let mut matrix = laplacian.matrix.clone();
    for ground in grounded {
        let v = ground.vertex as usize;
        matrix.diagonal[v] += matrix.diagonal[v].abs().max(f64::MIN_POSITIVE);
    }
    matrix
}

pub(super) fn at_vertex(fault: NumericError) -> SignedHeatError {
    match fault {
        NumericError::NonPositivePivot { unknown } | NumericError::NonFinite { unknown, .. } => {
            SignedHeatError::Integration { vertex: unknown, fault }
        }
        other => other.into(),
    }
}

impl Integration {
    /// Factors the fit for sheets attached to the others at vertices only. One system with weights,
    /// rather than two systems, works with every kind of level set constraint, and loses no digits,
    /// since a factor does not depend on the scale of its rows.
    ///
    /// # Cost
    /// One factorisation; the analysis is shared.
    pub fn with_hanging<'a>(
        &self,
        mesh: &TriangleMesh,
        hanging: &'a [bool],
    ) -> Result<WithHanging<'a>, SignedHeatError> {
        let symbolic = self.factor.symbolic();
        self.memory.check(symbolic.predicted_bytes::<f64>(self.memory.resources.threads))?;
        let mut laplacian = CotanLaplacian {
            graph: self.laplacian.graph.clone(),
            matrix: SymmetricMatrix {
                diagonal: vec![0.0; mesh.vertex_count()],
                off_diagonal: self.laplacian.matrix.off_diagonal.clone(),
            },
        };
        let SymmetricMatrix { diagonal, off_diagonal } = &mut laplacian.matrix;
        for (k, (entry, pair)) in off_diagonal.iter_mut().zip(&laplacian.graph.pairs).enumerate() {
            // Three pairs per face.
            if hanging[k / 3] {
                *entry *= HANGING;
            }
            pair.iter().for_each(|&v| diagonal[v as usize] -= *entry);
        }
        let mut supporting = vec![false; mesh.vertex_count()];
        for (corners, _) in mesh.triangles().iter().zip(hanging).filter(|(_, hanging)| !**hanging) {
            corners.iter().for_each(|&v| supporting[v as usize] = true);
        }
        let mut grounded = self.grounded.clone();
        let mut ground_supports = vec![false; self.component_count];
        for (v, component) in self.component_of_vertex.iter().enumerate() {
            match component {
                None => diagonal[v] = 1.0, // occurs in no equation
                Some(c) if supporting[v] && !ground_supports[*c as usize] => {
                    ground_supports[*c as usize] = true;
                    let own = grounded.iter_mut().filter(|g| g.component == *c);
                    own.for_each(|g| g.vertex = v as u32);
                }
                Some(_) => {}
            }
        }
        let matrix = grounded_matrix(&laplacian, grounded.iter());
        let factor = Cholesky::on_threads(symbolic.clone(), &matrix, self.memory.resources.threads)
            .map_err(at_vertex)?;
        let integration = Integration {
            laplacian,
            grounded,
            factor,
            vertex_order: self.vertex_order.clone(),
            component_of_vertex: self.component_of_vertex.clone(),
            component_count: self.component_count,
            size_of_component: self.size_of_component.clone(),
            slivers: self.slivers,
            memory: Memory {
                kept_bytes: self.memory.kept_bytes + symbolic.factor_bytes::<f64>(),
                ..self.memory
            },
        };
        Ok(WithHanging { integration, hanging })
    }

    /// Returns per component whether it has a curve or point.
    pub fn has_source(&self, mesh: &TriangleMesh, source: &Source) -> Vec<bool> {
        let mut has = vec![false; self.component_count];
        let ends = source.segments.iter().map(|s| s.ends[0]);
        for c in ends.chain(source.points.iter().copied()).filter_map(|p| self.component_of(mesh, p)) {
            has[c] = true;
        }
        has
    }

    pub fn component_of_vertex(&self) -> &[Option<u32>] {
        &self.component_of_vertex
    }
    pub fn component_count(&self) -> usize {
        self.component_count
    }

    /// Runs step III. Components without reached faces get NaN.
    pub fn integrate(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        field: &[Complex],
        reached: &[bool],
        source: &Source,
        level_sets: LevelSets,
    ) -> Result<Integrated, SignedHeatError> {
        // Deviation: eq. 13 is printed without the minus, see `divergence`.
        let mut b = divergence(mesh, triangles, field);
        b.iter_mut().for_each(|x| *x = -*x);
        check_stopped()?;
        let mut result = match self.constraints(level_sets) {
            Some(constraints) => {
                let chosen = ChosenLevelSets::given(level_sets);
                Integrated { chosen, ..self.constrained(mesh, triangles, &b, source, &constraints)? }
            }
            None if level_sets == LevelSets::Free => self.free(mesh, &b, source)?,
            None => self.automatic(mesh, triangles, &b, source)?,
        };
        check_stopped()?;
        let mut component_reached = vec![false; self.component_count];
        for (corners, _) in mesh.triangles().iter().zip(reached).filter(|(_, r)| **r) {
            if let Some(c) = self.component_of_vertex[corners[0] as usize] {
                component_reached[c as usize] = true;
            }
        }
        for (value, component) in result.values.iter_mut().zip(&self.component_of_vertex) {
            if !component.is_some_and(|c| component_reached[c as usize]) {
                *value = f64::NAN;
            }
        }
        Ok(result)
    }

    /// Computes the unconstrained fit, up to one constant per component.
    pub fn fit(&self, b: &[f64]) -> Result<Fit, SignedHeatError> {
        let Some(slivers) = &self.slivers else {
            let values = self.factor.solve(b).map_err(at_vertex)?;
            let residual = self.factor.relative_residual(&values, b);
            return Ok(Fit { values, residual, warning: None });
        };
        // Values at grounded vertices are zero, so their terms contribute nothing.
        let Refined { values, correction } =
            refined(&self.factor, b, |x| self.applied(x)).map_err(at_vertex)?;
        let residual = relative_residual(&self.applied(&values), b);
        let warning = slivers.warning(correction, largest(&values));
        Ok(Fit { values, residual, warning })
    }

    /// Multiplies vertex values by the Laplacian, using their differences. Differences keep all
    /// digits where values of nearby vertices nearly agree; a product with the diagonal does not.
    pub(super) fn applied(&self, x: &[f64]) -> Vec<f64> {
        let c = &self.laplacian;
        let mut product = vec![0.0; x.len()];
        for (&[i, j], weight) in c.graph.pairs.iter().zip(&c.matrix.off_diagonal) {
            let flux = weight * (x[j as usize] - x[i as usize]);
            product[i as usize] += flux;
            product[j as usize] -= flux;
        }
        product
    }

    fn free(&self, mesh: &TriangleMesh, b: &[f64], source: &Source) -> Result<Integrated, SignedHeatError> {
        let Fit { mut values, residual, warning } = self.fit(b)?;
        let shift = self.mean_at_source(mesh, &values, source);
        self.subtract(&mut values, &shift);
        Ok(Integrated {
            values,
            residual,
            constraint_violation: None,
            warnings: warning.into_iter().collect(),
            chosen: ChosenLevelSets::given(LevelSets::Free),
        })
    }

    /// Returns per component the mean of a function along its signed curves, weighted by length;
    /// without signed curves its minimum, so that unsigned distances start at zero; without a
    /// source, zero.
    pub fn mean_at_source(&self, mesh: &TriangleMesh, phi: &[f64], source: &Source) -> Vec<f64> {
        let n = self.component_count;
        let (mut sum, mut length, mut sourced) = (vec![0.0; n], vec![0.0; n], vec![false; n]);
        for (segment, kind) in source.segments.iter().zip(&source.kinds) {
            let Some(c) = self.component_of(mesh, segment.ends[0]) else { continue };
            sourced[c] = true;
            if *kind == CurveKind::Signed {
                let [a, b] = segment.ends.map(|p| p.interpolate(mesh, phi));
                let [p, q] = segment.ends.map(|p| p.position(mesh));
                let l = distance(p, q);
                sum[c] += l * 0.5 * (a + b);
                length[c] += l;
            }
        }
        for point in &source.points {
            if let Some(c) = self.component_of(mesh, *point) {
                sourced[c] = true;
            }
        }
        let mut minimum = vec![f64::INFINITY; n];
        for (&value, component) in phi.iter().zip(&self.component_of_vertex) {
            if let Some(c) = component {
                minimum[*c as usize] = minimum[*c as usize].min(value);
            }
        }
        (0..n)
            .map(|c| match (length[c] > 0.0, sourced[c]) {
                (true, _) => sum[c] / length[c],
                (false, true) => minimum[c],
                (false, false) => 0.0,
            })
            .collect()
    }

    pub(super) fn component_of(&self, mesh: &TriangleMesh, point: Located) -> Option<usize> {
        let (v, _) = point.weights(mesh).next()?;
        self.component_of_vertex[v.index()].map(|c| c as usize)
    }

    pub(super) fn subtract(&self, values: &mut [f64], shift: &[f64]) {
        for (value, component) in values.iter_mut().zip(&self.component_of_vertex) {
            if let Some(c) = component {
                *value -= shift[*c as usize];
            }
        }
    }

    /// Returns per component whether it has a signed curve.
    pub(super) fn has_signed(&self, mesh: &TriangleMesh, source: &Source) -> Vec<bool> {
        let mut signed = vec![false; self.component_count];
        for (segment, kind) in source.segments.iter().zip(&source.kinds) {
            if let (CurveKind::Signed, Some(c)) = (kind, self.component_of(mesh, segment.ends[0])) {
                signed[c] = true;
            }
        }
        signed
    }

    /// Clamps negative values to zero in components with unsigned sources only, where they are
    /// discretisation errors.
    ///
    /// Deviation: the paper keeps them, and applies one shift to the whole surface instead of one
    /// per component.
    pub(super) fn clamp_unsigned(&self, mesh: &TriangleMesh, source: &Source, values: &mut [f64]) {
        let signed = self.has_signed(mesh, source);
        for (value, component) in values.iter_mut().zip(&self.component_of_vertex) {
            if component.is_some_and(|c| !signed[c as usize]) {
                *value = value.max(0.0);
            }
        }
    }
}

/// Largest difference between the two sides of an equation, relative to the largest entry of the
/// right side (absolute where that is zero).
pub(super) fn relative_residual(left: &[f64], right: &[f64]) -> f64 {
    let scale = largest(right);
    let worst = left.iter().zip(right).fold(0.0f64, |m, (l, r)| m.max((l - r).abs()));
    if scale > 0.0 { worst / scale } else { worst }
}

/// Largest absolute value.
pub(super) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |m, x| m.max(x.abs()))
}
