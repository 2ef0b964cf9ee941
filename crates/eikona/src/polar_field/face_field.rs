//! The smoothest field of one N-th power per face (after Knöppel, Crane, Pinkall and Schröder 2013,
//! with faces in place of vertices), from which singularities are read.

use crate::polar_field::bevel::{BeveledMesh, Rotation};
use crate::polar_field::guides::power;
use crate::polar_field::powers::{face_graph, face_order};
use eikona_mesh::random::Random;
use eikona_mesh::{Face, FaceField};
use eikona_numeric::{
    Cholesky, Complex, NumericError, Ordering, Resources, Scalar, Symbolic, SymmetricMatrix, check_step,
    check_stopped,
};
use std::sync::Arc;

/// A direction that a face should have: the N-th power, and its weight in the energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceTarget {
    pub face: Face,
    pub value: Complex,
    pub weight: f64,
}

/// Shift of the matrix by this share of the mass, relative to the area, so that constant fields on
/// flat surfaces do no harm. Eigenvalues times the area are around 10.
const SHIFT: f64 = 1e-4;
/// The iteration ends when the energy changes by less than this share of it.
const SETTLED: f64 = 1e-4;
/// Most steps of the iteration.
const MOST_STEPS: usize = 40;
/// Diffusion times of the unit field, relative to the area.
const TIMES: [f64; 3] = [1e-2, 2.5e-3, 6e-4];
/// Most diffusions per time.
const MOST_DIFFUSIONS: usize = 12;
/// A diffusion that turns no face by more than this angle, in radians of the power, is the last
/// one.
const STILL: f64 = 0.01;
/// Size of the disturbance that breaks symmetries.
const DISTURBANCE: f64 = 0.05;

/// Returns the smoothest field of unit length, close to the targets.
///
/// It starts with the field that minimises the squared differences across edges, times their length
/// over the distance of the centroids, by one solve, or by inverse iteration if there are no
/// targets. That field is short around places where the unit field would have several singularities
/// of small index. Diffusions, each followed by normalisation (Viertel and Osting 2019), separate
/// these, and remove pairs that are there for no reason.
///
/// # Cost
/// Four factorisations on the faces, and at most 76 solves.
pub(crate) fn smoothest_face_field(
    bevel: &BeveledMesh,
    connection: &Rotation,
    degree: u32,
    targets: &[FaceTarget],
    resources: Resources,
) -> Result<FaceField<Complex>, NumericError> {
    let system = System::new(bevel, connection, degree, targets, resources)?;
    let mut field =
        if targets.is_empty() { system.lowest()? } else { system.factored(0.0)?.solve(&system.rhs)? };
    let mut random = Random::from_seed(2);
    for u in &mut field {
        let noise = Complex { re: random.normal(), im: random.normal() };
        *u = unit(unit(*u) + noise * DISTURBANCE);
    }
    for time in TIMES {
        system.diffuse(&mut field, time * system.area)?;
    }
    Ok(field.into())
}

/// The smoothness of a face field, with targets.
struct System {
    symbolic: Arc<Symbolic>,
    matrix: SymmetricMatrix<Complex>,
    rhs: Vec<Complex>,
    mass: Vec<f64>,
    area: f64,
    resources: Resources,
}

impl System {
    fn new(
        bevel: &BeveledMesh,
        connection: &Rotation,
        degree: u32,
        targets: &[FaceTarget],
        resources: Resources,
    ) -> Result<System, NumericError> {
        let faces = bevel.mesh.face_count();
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; faces], off_diagonal: Vec::new() };
        for (step, (h, twin)) in bevel.edges().enumerate() {
            check_step(step)?;
            let [f, g] = [h, twin].map(|h| h.face().index());
            let length = bevel.triangles[f].lengths[h.side()];
            let weight = 1.5 * length * length / (bevel.triangles[f].area + bevel.triangles[g].area);
            matrix.diagonal[f] += weight;
            matrix.diagonal[g] += weight;
            let angle = connection.jump[h];
            let transport = power(Complex { re: angle.cos(), im: angle.sin() }, degree);
            matrix.off_diagonal.push(transport * -weight);
        }
        let mut rhs = vec![Complex::ZERO; faces];
        for target in targets {
            matrix.diagonal[target.face.index()] += target.weight;
            rhs[target.face.index()] += target.value * target.weight;
        }
        let graph = face_graph(bevel)?;
        let order = face_order(bevel, &graph, resources.threads)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?.into();
        let mass: Vec<f64> = bevel.triangles.iter().map(|t| t.area).collect();
        let area = mass.iter().sum();
        Ok(System { symbolic, matrix, rhs, mass, area, resources })
    }

    /// Factors the matrix plus a multiple of the mass.
    fn factored(&self, shift: f64) -> Result<Cholesky<Complex>, NumericError> {
        check_stopped()?;
        let mut matrix = self.matrix.clone();
        check_stopped()?;
        for (diagonal, mass) in matrix.diagonal.iter_mut().zip(&self.mass) {
            *diagonal += (shift + SHIFT / self.area) * mass;
        }
        check_stopped()?;
        Cholesky::within(self.resources, self.symbolic.clone(), &matrix)
    }

    /// Returns the eigenvector of the smallest eigenvalue, by inverse iteration.
    fn lowest(&self) -> Result<Vec<Complex>, NumericError> {
        let factor = self.factored(0.0)?;
        let mut random = Random::from_seed(1);
        let mut field: Vec<Complex> =
            self.mass.iter().map(|_| Complex { re: random.normal(), im: random.normal() }).collect();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            check_stopped()?;
            let loaded: Vec<Complex> = field.iter().zip(&self.mass).map(|(u, m)| *u * *m).collect();
            let next = factor.solve(&loaded)?;
            // The energy <A x, x> / <M x, x>, where A x = M u.
            let of_mass: f64 = next.iter().zip(&self.mass).map(|(x, m)| m * x.norm_sq()).sum();
            let of_energy: f64 = next.iter().zip(&loaded).map(|(x, b)| (x.conj() * *b).re).sum();
            let energy = of_energy / of_mass;
            let size = of_mass.sqrt();
            field = next.into_iter().map(|x| x * (1.0 / size)).collect();
            if (before - energy).abs() <= SETTLED * energy {
                break;
            }
            before = energy;
        }
        Ok(field)
    }

    /// Diffuses a unit field for some time and normalises it, until nothing moves.
    fn diffuse(&self, field: &mut [Complex], time: f64) -> Result<(), NumericError> {
        let factor = self.factored(1.0 / time)?;
        for _ in 0..MOST_DIFFUSIONS {
            check_stopped()?;
            let loaded = |i: usize| self.rhs[i] + field[i] * (self.mass[i] / time);
            let rhs: Vec<Complex> = (0..field.len()).map(loaded).collect();
            let mut moved = 0.0f64;
            for (u, next) in field.iter_mut().zip(factor.solve(&rhs)?) {
                let next = unit(next);
                moved = moved.max((next - *u).norm());
                *u = next;
            }
            if moved <= STILL {
                break;
            }
        }
        Ok(())
    }
}

fn unit(z: Complex) -> Complex {
    let length = z.norm();
    if length > 0.0 { z * (1.0 / length) } else { Complex { re: 1.0, im: 0.0 } }
}
