//! The fractional inner product `A = B + B0` (RS section 3.2) and its products and solves.
//!
//! All three operators have the form `2 W^T (diag((H a) / a) - H) W`, where W takes a function on
//! vertices to its gradients or means on faces, times their areas `a`, and H is a kernel matrix on
//! pairs of faces (RS section 5.1 and appendix A). H is stored on the leaves of a block cluster
//! tree.
//!
//! Deviations: the print of section 5.1 has the projector of S twice as arguments of the kernel,
//! and W of the gradients in the formula of `B0`; the sides `e_ij` of section 3.2.1 are not of unit
//! length.

mod all_pairs;
mod elements;
mod kernel;
mod laplacian;
mod local;
mod partition;
mod solve;
mod stiffness;

pub use solve::MetricSolution;

use crate::repulsive::energy::unit_of_length;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::{FaceDatum, face_data};
use crate::repulsive::moments::{moments_of, radii};
use crate::repulsive::options::{Exponents, Pairs, check_separation};
use crate::setters::setters;
use crate::spatial::ClusterTree;
use eikona_mesh::{TriangleMesh, Vertex, VertexField};
use eikona_numeric::{NumericError, check_stopped};
use elements::Elements;
use kernel::{KernelKind, KernelMatrices, Kernels};
use partition::Partition;

pub(super) use local::{LocalMetric, LocalOrder};
pub(super) use solve::{Analysis, Preconditioner};
pub(super) use stiffness::{Bending, Stiffness};

/// Options of [`Metric`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MetricOptions {
    /// The exponents of the energy, from which the order `s = (beta - 2) / alpha` follows. Default:
    /// `p = 6`.
    pub exponents: Exponents,
    /// Whether the term of low order `B0` is part of the product. Default: yes.
    pub low_order: bool,
    /// Whether far clusters are seen as one. Default: [`Pairs::Hierarchical`].
    pub pairs: Pairs,
    /// Two clusters count as far if the sum of their radii is less than this share of the distance
    /// of their centres. Default: 0.7.
    pub separation: f64,
    /// Solves stop when an iteration changes the solution by less than this share, in the norm of
    /// the product. Default: 0.01.
    pub tolerance: f64,
    /// Number of threads. Default: 1. Results are the same for any number.
    pub threads: usize,
}

impl Default for MetricOptions {
    fn default() -> Self {
        MetricOptions {
            exponents: Exponents::default(),
            low_order: true,
            pairs: Pairs::Hierarchical,
            separation: 0.7,
            tolerance: 0.01,
            threads: 1,
        }
    }
}

setters!(MetricOptions {
    with_exponents: exponents = Exponents,
    with_low_order: low_order = bool,
    with_pairs: pairs = Pairs,
    with_separation: separation = f64,
    with_tolerance: tolerance = f64,
    with_threads: threads = usize
});

/// The fractional inner product at a surface: takes displacements to forces, and back.
///
/// It is symmetric and positive semidefinite. It vanishes for translations only.
///
/// ```
/// use eikona::mesh::{VertexField, shapes};
/// use eikona::repulsive::{Metric, MetricOptions};
/// let sphere = shapes::icosphere(1)?;
/// let metric = Metric::new(&sphere, &MetricOptions::default())?;
/// let positions = VertexField::from(sphere.positions().to_vec());
/// let image = metric.product(&positions)?;
/// let product = |v, k| image[v][k] * positions[v][k];
/// let square: f64 = sphere.vertices().flat_map(|v| [0, 1, 2].map(|k| product(v, k))).sum();
/// // Of all pairs: 200.5043839668927 + 37.46951754088190.
/// assert!((square / 237.9739015 - 1.0).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Metric {
    options: MetricOptions,
    /// Lengths are divided by it.
    unit: f64,
    matrices: Matrices,
    elements: Elements,
    preconditioner: Preconditioner,
    /// The weights of deviations from means on faces in the preconditioner, in the order of the
    /// tree.
    deviations: Vec<f64>,
    /// Vertices that do not move; empty if all do.
    pinned: Vec<bool>,
    /// What potentials add, in the unit of length.
    stiffness: Stiffness,
}

/// The kernel matrices.
enum Matrices {
    Stored { tree: ClusterTree, partition: Partition, kernels: Box<KernelMatrices> },
    AllPairs { faces: Vec<FaceDatum>, kernels: Kernels },
}

impl Matrices {
    fn times<const N: usize>(
        &self,
        kind: KernelKind,
        columns: &[[f64; N]],
        many: usize,
        threads: usize,
    ) -> Result<Vec<[f64; N]>, NumericError> {
        match self {
            Matrices::Stored { tree, partition, kernels } => {
                kernels.get(kind).times(tree, partition, columns, many, threads)
            }
            Matrices::AllPairs { faces, kernels } => {
                all_pairs::times(kind, *kernels, faces, columns, many, threads)
            }
        }
    }
}

impl Metric {
    /// Computes the kernel matrices and the factor of the preconditioner.
    ///
    /// # Errors
    /// Those of [`tangent_point_energy`](super::tangent_point_energy).
    ///
    /// # Cost
    /// O(F log F): about 5 us and 5 kB per face.
    pub fn new(mesh: &TriangleMesh, options: &MetricOptions) -> Result<Metric, RepulsiveError> {
        Metric::with_pins(mesh, options, &[])
    }

    /// Like [`new`](Self::new), with vertices that do not move: [`solve`](Self::solve) finds
    /// displacements that are zero there, whose products are the forces at all other vertices (RS
    /// section 7.1.2).
    ///
    /// # Errors
    /// As for [`new`](Self::new), and [`RepulsiveError::Constraint`] for a vertex that is none of
    /// the mesh.
    ///
    /// # Cost
    /// As for [`new`](Self::new).
    pub fn with_pins(
        mesh: &TriangleMesh,
        options: &MetricOptions,
        pins: &[Vertex],
    ) -> Result<Metric, RepulsiveError> {
        if mesh.face_count() == 0 {
            return Err(RepulsiveError::NoFaces);
        }
        check_separation(options.separation)?;
        let unit = unit_of_length(mesh);
        let faces = face_data(mesh, unit, options.threads)?;
        let centroids: Vec<[f64; 3]> = faces.iter().map(|face| face.centroid).collect();
        let tree = ClusterTree::on_threads(&centroids, options.threads);
        check_stopped()?;
        let mut pinned = vec![false; if pins.is_empty() { 0 } else { mesh.vertex_count() }];
        for &vertex in pins {
            let Some(pinned) = pinned.get_mut(vertex.index()) else {
                let fault = format!("{vertex} is pinned, but the mesh has {} vertices", mesh.vertex_count());
                return Err(RepulsiveError::Constraint { fault });
            };
            *pinned = true;
        }
        let preconditioner = Preconditioner::new(mesh, unit, options.threads, None, &pinned)?;
        Ok(Metric::on(mesh, unit, tree, &faces, options, preconditioner, pinned, Stiffness::default())?)
    }

    /// Like [`new`](Self::new), for a tree and a preconditioner that are there already.
    pub(super) fn on(
        mesh: &TriangleMesh,
        unit: f64,
        tree: ClusterTree,
        faces: &[FaceDatum],
        options: &MetricOptions,
        preconditioner: Preconditioner,
        pinned: Vec<bool>,
        mut stiffness: Stiffness,
    ) -> Result<Metric, NumericError> {
        let scale = unit.powf(-2.0 * (options.exponents.order() - 1.0));
        stiffness.scale(1.0 / scale);
        let ordered = tree.in_order(faces);
        let power = options.exponents.order() - 1.0;
        let deviations = ordered.iter().map(|face| face.area.powf(power)).collect();
        let elements = Elements::new(mesh, unit, &tree, &ordered, options.threads);
        check_stopped()?;
        let kernels = Kernels::new(options.exponents);
        let matrices = match options.pairs {
            Pairs::All => Matrices::AllPairs { faces: ordered, kernels },
            Pairs::Hierarchical => {
                let threads = options.threads;
                let moments = moments_of(&tree, &ordered, threads);
                let radii = radii(&tree, &ordered, &moments, threads)?;
                let partition = Partition::new(&tree, &moments, &radii, options.separation, threads)?;
                let kernels = KernelMatrices::new(&tree, &partition, &ordered, &moments, kernels, threads)?;
                Matrices::Stored { tree, partition, kernels: Box::new(kernels) }
            }
        };
        let options = *options;
        Ok(Metric { options, unit, matrices, elements, preconditioner, deviations, pinned, stiffness })
    }

    /// Returns the product with a vector field on the vertices.
    ///
    /// # Errors
    /// [`RepulsiveError::Numeric`] if an observer stops it.
    ///
    /// # Cost
    /// One pass over the kernel matrices: about 0.5 us per face and thread.
    pub fn product(&self, field: &VertexField<[f64; 3]>) -> Result<VertexField<[f64; 3]>, RepulsiveError> {
        Ok(self.force_of(field.as_slice())?.into())
    }

    /// Returns the product with the fractional Laplacian of order `2 - s`, which the preconditioner
    /// uses.
    ///
    /// # Errors
    /// As for [`product`](Self::product).
    ///
    /// # Cost
    /// As for [`product`](Self::product).
    pub fn fractional_product(
        &self,
        field: &VertexField<[f64; 3]>,
    ) -> Result<VertexField<[f64; 3]>, RepulsiveError> {
        // a a / |v|^(2 (2 - s) + 2)
        let scale = self.unit.powf(2.0 * (self.options.exponents.order() - 1.0));
        let mut image = self.fractional_products(&[field.as_slice()])?;
        let image = image.pop().unwrap_or_default();
        Ok(image.into_iter().map(|x| x.map(|x| scale * x)).collect::<Vec<_>>().into())
    }

    /// Whether there is a diagonal term.
    pub(super) fn is_stiff(&self) -> bool {
        !self.stiffness.diagonal.is_empty()
    }

    /// The product with a field in space.
    pub(super) fn force_of(&self, field: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, NumericError> {
        let scale = self.scale();
        let image = self.products(&[field])?.pop().unwrap_or_default();
        Ok(image.into_iter().map(|x| x.map(|x| scale * x)).collect())
    }

    /// The factor of products that belongs to the unit of length.
    fn scale(&self) -> f64 {
        self.unit.powf(-2.0 * (self.options.exponents.order() - 1.0))
    }

    /// Products in the unit of length.
    fn products(&self, fields: &[&[[f64; 3]]]) -> Result<Vec<Vec<[f64; 3]>>, NumericError> {
        let Metric { matrices, elements, options, .. } = self;
        let many = fields.len();
        let mut result = vec![vec![[0.0; 3]; elements.vertices()]; many];
        let gradients = elements.gradients(fields)?;
        let gradients = matrices.times(KernelKind::High, &gradients, many, options.threads)?;
        elements.add_divergences(&gradients, 2.0, &mut result)?;
        if options.low_order {
            let means = elements.means(fields)?;
            let means = matrices.times(KernelKind::Low, &means, many, options.threads)?;
            elements.add_means(&means, 2.0, &mut result)?;
        }
        for (result, field) in result.iter_mut().zip(fields) {
            self.stiffness.add_product(field, result);
        }
        Ok(result)
    }

    /// Products with the fractional Laplacian of order `2 - s`, in the unit of length.
    fn fractional_products(&self, fields: &[&[[f64; 3]]]) -> Result<Vec<Vec<[f64; 3]>>, NumericError> {
        let Metric { matrices, elements, options, .. } = self;
        let many = fields.len();
        let mut result = vec![vec![[0.0; 3]; elements.vertices()]; many];
        let means = elements.means(fields)?;
        let means = matrices.times(KernelKind::Fractional, &means, many, options.threads)?;
        elements.add_means(&means, 2.0, &mut result)?;
        Ok(result)
    }
}
