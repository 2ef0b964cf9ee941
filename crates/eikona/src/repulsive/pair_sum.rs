//! The sum over all pairs of faces, as it is decided once and holds while the surface moves: which
//! clusters are far, which faces are in near contact, and how those are subdivided.

use crate::geometry::vector::{add, scale};
use crate::repulsive::all_pairs::all_pairs;
use crate::repulsive::contact_sums::add_near_contact;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::{FaceDatum, FaceForce, Row, face_data, pulled_back};
use crate::repulsive::hierarchical::{Interactions, hierarchical};
use crate::repulsive::near_contact::NearContact;
use crate::repulsive::options::{Exponents, Pairs, Quadrature, check_separation};
use crate::spatial::ClusterTree;
use eikona_mesh::{ElementId, Face, TriangleMesh, VertexField};
use eikona_numeric::check_step;

type Vec3 = [f64; 3];

/// How pairs of faces are summed.
pub(crate) struct PairSum {
    unit: f64,
    exponents: Exponents,
    threads: usize,
    contact: NearContact,
    /// `None` if all pairs are summed one by one.
    interactions: Option<Interactions>,
}

/// What [`PairSum::new`] has to know.
#[derive(Clone, Copy)]
pub(crate) struct PairSumOptions {
    pub exponents: Exponents,
    pub pairs: Pairs,
    pub separation: f64,
    pub quadrature: Quadrature,
    pub threads: usize,
}

/// The sum at some positions.
pub(crate) struct Summed<'a> {
    mesh: &'a TriangleMesh,
    unit: f64,
    exponents: Exponents,
    faces: Vec<FaceDatum>,
    rows: Vec<Row>,
    /// Derivatives by the corners of each face; empty if no faces are in near contact.
    at_corners: Vec<[Vec3; 3]>,
}

impl PairSum {
    /// Decides for the surface where it is. Lengths are divided by `unit` from here on.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`], [`RepulsiveError::Separation`],
    /// [`RepulsiveError::NearContact`], [`RepulsiveError::Numeric`].
    pub fn new(mesh: &TriangleMesh, unit: f64, options: &PairSumOptions) -> Result<PairSum, RepulsiveError> {
        let PairSumOptions { exponents, pairs, separation, quadrature, threads } = *options;
        let faces = face_data(mesh, unit, threads)?;
        let contact = match quadrature {
            Quadrature::Midpoint => NearContact::default(),
            Quadrature::Adaptive { separation } => {
                check_separation(separation)?;
                let triangles = triangles(mesh, unit);
                NearContact::new(mesh.triangles(), &triangles, separation, exponents.alpha, threads)?
            }
        };
        let interactions = match pairs {
            Pairs::All => None,
            Pairs::Hierarchical => {
                check_separation(separation)?;
                Some(Interactions::new(&faces, separation, &contact, threads)?)
            }
        };
        Ok(PairSum { unit, exponents, threads, contact, interactions })
    }

    /// Returns the tree of the faces where it was decided, or a new one.
    pub fn tree(&self, faces: &[FaceDatum]) -> ClusterTree {
        match &self.interactions {
            Some(interactions) => interactions.tree.clone(),
            None => ClusterTree::new(&faces.iter().map(|face| face.centroid).collect::<Vec<_>>()),
        }
    }

    /// Sums at the positions of a mesh of the same faces. Derivatives only if they are wanted.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`], [`RepulsiveError::Touching`], [`RepulsiveError::Numeric`].
    pub fn at<'a>(&self, mesh: &'a TriangleMesh, differential: bool) -> Result<Summed<'a>, RepulsiveError> {
        let PairSum { unit, exponents, threads, contact, .. } = self;
        let faces = face_data(mesh, *unit, *threads)?;
        let mut rows = match &self.interactions {
            Some(interactions) => hierarchical(interactions, &faces, *exponents, differential, *threads)?,
            None => all_pairs(&faces, *exponents, contact, *threads)?,
        };
        let mut at_corners = Vec::new();
        if !contact.pairs.is_empty() {
            let triangles = triangles(mesh, *unit);
            at_corners.resize(if differential { faces.len() } else { 0 }, [[0.0; 3]; 3]);
            let corners = differential.then_some(&mut at_corners[..]);
            add_near_contact(contact, &triangles, &faces, *exponents, *threads, &mut rows, corners)?;
        }
        Ok(Summed { mesh, unit: *unit, exponents: *exponents, faces, rows, at_corners })
    }
}

impl Summed<'_> {
    /// Returns the energy.
    ///
    /// # Errors
    /// [`RepulsiveError::Coincident`], [`RepulsiveError::Range`].
    pub fn value(&self) -> Result<f64, RepulsiveError> {
        self.check_finite()?;
        let sum: f64 = self.faces.iter().zip(&self.rows).map(|(face, row)| face.area * row.density).sum();
        Ok(sum * self.unit.powf(self.exponents.degree()))
    }

    /// Returns the energy per area of each face.
    pub fn densities(&self) -> Vec<f64> {
        let factor = self.unit.powf(self.exponents.degree() - 2.0);
        self.rows.iter().map(|row| row.density * factor).collect()
    }

    /// Returns the derivative by each vertex.
    pub fn differential(&self) -> VertexField<Vec3> {
        let forces: Vec<FaceForce> = self.rows.iter().map(|row| row.force).collect();
        let mut sum = pulled_back(self.mesh, self.unit, &self.faces, &forces);
        for (face, forces) in self.mesh.faces().zip(&self.at_corners) {
            for (v, force) in self.mesh.face_vertices(face).into_iter().zip(forces) {
                sum[v] = add(sum[v], *force);
            }
        }
        let factor = self.unit.powf(self.exponents.degree() - 1.0);
        sum.into_vec().into_iter().map(|v| scale(v, factor)).collect::<Vec<_>>().into()
    }

    fn check_finite(&self) -> Result<(), RepulsiveError> {
        let broken = |row: &Row| !(row.density.is_finite() && row.force.area.is_finite());
        let Some(f) = self.rows.iter().position(broken) else { return Ok(()) };
        for (g, other) in self.faces.iter().enumerate().filter(|(g, _)| *g != f) {
            check_step(g)?;
            if other.centroid == self.faces[f].centroid {
                return Err(RepulsiveError::Coincident { faces: [f, g].map(Face::from_index) });
            }
        }
        Err(RepulsiveError::Range { face: Face::from_index(f) })
    }
}

fn triangles(mesh: &TriangleMesh, unit: f64) -> Vec<[Vec3; 3]> {
    mesh.faces().map(|face| mesh.face_positions(face).map(|p| p.map(|x| x / unit))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::shapes;

    /// Two jittered spheres that nearly touch.
    fn spheres() -> TriangleMesh {
        let sphere = eikona_mesh::damage::jitter(&shapes::icosphere(2).unwrap(), 0.1, 3).unwrap();
        let shift = |p: &Vec3| [p[0] + 2.03, p[1] + 0.1, p[2]];
        let positions = sphere.positions().iter().copied().chain(sphere.positions().iter().map(shift));
        let faces = sphere.triangles().iter().map(|t| t.map(|v| v + sphere.vertex_count() as u32));
        let faces = sphere.triangles().iter().copied().chain(faces).collect();
        TriangleMesh::new(positions.collect(), faces).unwrap()
    }

    #[test]
    fn the_differential_is_the_derivative_of_the_sum_with_parts_held() {
        let mesh = spheres();
        let wave = |v: usize, k: usize| (1.3 * v as f64 + 0.7 * k as f64).sin();
        let moved = |step: f64| {
            let at = |(v, p): (usize, &Vec3)| [0, 1, 2].map(|k| p[k] + step * 0.02 * wave(v, k));
            mesh.with_positions(mesh.positions().iter().enumerate().map(at).collect()).unwrap()
        };
        for (alpha, beta) in [(6.0, 12.0), (4.0, 8.0), (8.0, 14.0), (3.5, 7.5)] {
            for pairs in [Pairs::All, Pairs::Hierarchical] {
                let options = PairSumOptions {
                    exponents: Exponents::new(alpha, beta).unwrap(),
                    pairs,
                    separation: 0.4,
                    quadrature: Quadrature::adaptive(),
                    threads: 1,
                };
                let sum = PairSum::new(&mesh, 2.0, &options).unwrap();
                assert!(sum.contact.pairs.len() > 50);
                let sample = |step: f64| sum.at(&moved(step), false).unwrap().value().unwrap();
                let summed = sum.at(&mesh, true).unwrap();
                let slope: f64 = summed
                    .differential()
                    .iter()
                    .flat_map(|(v, d)| (0..3).map(move |k| d[k] * 0.02 * wave(v.0 as usize, k)))
                    .sum();
                assert!((sample(0.0) / summed.value().unwrap() - 1.0).abs() < 1e-13);
                let error = |h: f64| ((sample(h) - sample(-h)) / (2.0 * h) / slope - 1.0).abs();
                let order = (error(2e-3) / error(1e-3)).log2();
                assert!((order - 2.0).abs() < 0.05, "{alpha}, {beta}: {order}");
                assert!(error(1e-4) < 1e-4, "{alpha}, {beta}: {slope}");
            }
        }
    }
}
