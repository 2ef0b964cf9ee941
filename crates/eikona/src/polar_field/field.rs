//! The field: phases by integration, and its values at points (PLPF sections 4.4 and 5).

use crate::polar_field::bevel::{BeveledMesh, Cycle, PerCycle, Rotation, wrapped};
use crate::polar_field::domain::Domain;
use eikona_mesh::{Face, FaceField, Halfedge, HalfedgeField};
use eikona_numeric::{Complex, NumericError, Scalar, check_step};
use std::f64::consts::TAU;

/// A rotation with the phase at the first corner of each component.
#[derive(Clone, Debug)]
pub(crate) struct Phased {
    pub theta: Rotation,
    pub start: Vec<f64>,
}

/// Values that determine the field: per corner the base of the power in its face.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    /// The linear field at each corner, in the layout of its face.
    pub base: Vec<Complex>,
    pub powers: FaceField<u32>,
    /// How far the power turns from face to face at the origin of each halfedge, as solved for.
    pub jump: HalfedgeField<f64>,
    /// Largest deviation of a phase around a cycle from a whole number of turns.
    pub closure: f64,
}

impl Values {
    /// Integrates the rotation to phases and combines them with the scales.
    pub fn new(
        Domain { bevel, homology, connection, .. }: &Domain,
        Phased { theta, start }: &Phased,
        scales: &[f64],
        powers: FaceField<u32>,
        degree: u32,
    ) -> Result<Values, NumericError> {
        let n = f64::from(degree);
        let mut phase = vec![0.0; bevel.mesh.halfedge_count()];
        for (step, &face) in homology.order.iter().enumerate() {
            check_step(step)?;
            let first = homology.entry[face.index()].unwrap_or(face.halfedge(0));
            match homology.entry[face.index()] {
                Some(h) => {
                    let twin = bevel.twin[h].expect("the tree crosses interior edges only");
                    let across = theta.jump[h] + n * connection.jump[h];
                    phase[h.index()] = wrapped(phase[twin.next().index()] + across);
                }
                None => phase[first.index()] = start[bevel.component_of(Cycle::Face(face))],
            }
            phase[first.next().index()] = phase[first.index()] + theta.split[first];
            phase[first.previous().index()] = phase[first.next().index()] + theta.split[first.next()];
        }
        let mut closure = 0.0f64;
        for h in bevel.halfedges() {
            check_step(h.index())?;
            let along = phase[h.next().index()] - phase[h.index()] - theta.split[h];
            closure = closure.max(wrapped(along).abs());
        }
        for (h, twin) in bevel.interior() {
            check_step(h.index())?;
            let across = theta.jump[h] + n * connection.jump[h];
            let difference = phase[h.index()] - phase[twin.next().index()] - across;
            closure = closure.max(wrapped(difference).abs());
        }
        let mut base = vec![Complex::ZERO; phase.len()];
        for face in bevel.mesh.faces() {
            check_step(face.index())?;
            let m = f64::from(powers[face]);
            let mut angle = phase[face.halfedge(0).index()] / m;
            for h in [0, 1, 2].map(|k| face.halfedge(k)) {
                base[h.index()] = polar(scales[h.index()].powf(1.0 / m), angle);
                angle += theta.split[h] / m;
            }
        }
        Ok(Values { base, powers, jump: theta.jump.clone(), closure })
    }

    /// Returns the N-th power of the field at a point of a face, in the layout of the face.
    pub fn power_at(&self, face: Face, weights: [f64; 3]) -> Complex {
        let base =
            (0..3).fold(Complex::ZERO, |sum, k| sum + self.base[face.halfedge(k).index()] * weights[k]);
        let m = f64::from(self.powers[face]);
        polar(base.norm().powf(m), m * base.arg())
    }

    /// Returns how far the N-th power turns along the segment between two points of a face.
    pub fn turn_between(&self, face: Face, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [from, to] = [from, to].map(|weights| {
            (0..3).fold(Complex::ZERO, |sum, k| sum + self.base[face.halfedge(k).index()] * weights[k])
        });
        f64::from(self.powers[face]) * (to * from.conj()).arg()
    }

    /// Returns the derivatives of the phase at a point of a face by the phases at its corners;
    /// `None` where the field vanishes.
    pub fn phase_derivatives(&self, face: Face, weights: [f64; 3]) -> Option<[f64; 3]> {
        let parts = [0, 1, 2].map(|k| self.base[face.halfedge(k).index()] * weights[k]);
        let sum = parts.iter().fold(Complex::ZERO, |sum, part| sum + *part);
        let size = sum.norm_sq();
        (size > 0.0).then(|| parts.map(|part| (part * sum.conj()).re / size))
    }

    /// Returns how far the N-th power turns along a side of a face.
    pub fn turn(&self, h: Halfedge) -> f64 {
        let m = f64::from(self.powers[h.face()]);
        m * (self.base[h.next().index()] * self.base[h.index()].conj()).arg()
    }

    /// Returns the rotation of the N-th power at the origin of a halfedge, from the face of its
    /// twin to its own, within half a turn.
    pub fn jump(&self, h: Halfedge, twin: Halfedge, connection: &Rotation, degree: u32) -> f64 {
        let at = |corner: Halfedge| f64::from(self.powers[corner.face()]) * self.base[corner.index()].arg();
        wrapped(at(h) - at(twin.next()) - f64::from(degree) * connection.jump[h])
    }

    /// Returns the index times N of each cycle, as measured from the field.
    pub fn measured(
        &self,
        bevel: &BeveledMesh,
        connection: &Rotation,
        curvature: impl Fn(Cycle) -> f64,
        degree: u32,
    ) -> Result<PerCycle<i64>, NumericError> {
        let mut seen = bevel.zero();
        for h in bevel.halfedges() {
            check_step(h.index())?;
            seen.split[h] = self.turn(h);
        }
        for (h, twin) in bevel.interior() {
            check_step(h.index())?;
            seen.jump[h] = self.jump(h, twin, connection, degree);
        }
        let sums = bevel.sums(&seen);
        let mut indices = bevel.constant(0);
        for c in bevel.cycles() {
            indices[c] = ((sums[c] + f64::from(degree) * curvature(c)) / TAU).round() as i64;
        }
        Ok(indices)
    }
}

pub(crate) fn polar(length: f64, angle: f64) -> Complex {
    Complex { re: length * angle.cos(), im: length * angle.sin() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polar_field::scale::ties;
    use crate::polar_field::singularity::Prescribed;
    use crate::polar_field::surface::Surface;
    use eikona_mesh::random::Random;
    use eikona_mesh::{Located, shapes};

    /// The rotation of a linear field, its zero, and the scales away from it determine it: elliptic
    /// and hyperbolic ones, holomorphic ones and others.
    #[test]
    fn linear_fields_on_a_flat_patch_are_reproduced() {
        let domain = Domain::new(Surface::of(&shapes::disk(4, 7, 1.0).unwrap()).unwrap().bevel).unwrap();
        let bevel = &domain.bevel;
        let mesh = &bevel.mesh;
        let mut random = Random::from_seed(11);
        for _ in 0..200 {
            let singular = Face(random.below(mesh.face_count()) as u32);
            let weights = [0; 3].map(|_| random.range(0.1, 1.0));
            let sum: f64 = weights.iter().sum();
            let weights = weights.map(|w| w / sum);
            let mut complex = || Complex { re: random.normal(), im: random.normal() };
            let (a, b) = (complex(), complex());
            let in_plane = |p: [f64; 3]| Complex { re: p[0], im: p[1] };
            let point = Located::Face(singular, weights);
            let zero = in_plane(point.position(mesh));
            let field = |p: [f64; 3]| {
                let z = in_plane(p) - zero;
                a * z + b * z.conj()
            };
            let mut theta = bevel.zero();
            let mut scales = vec![0.0; mesh.halfedge_count()];
            for h in bevel.halfedges() {
                let [own, next] = [mesh.origin(h), mesh.tip(h)].map(|v| field(mesh.position(v)));
                theta.split[h] = (next * own.conj()).arg();
                scales[h.index()] = own.norm();
            }
            let turns = if a.norm() > b.norm() { 1 } else { -1 };
            let prescribed = [Prescribed { cycle: Cycle::Face(singular), point: Some(point), turns }];
            let ones = FaceField::constant(mesh.face_count(), 1);
            let found = ties(bevel, &prescribed, &theta, &ones);
            assert!(found.unplaced.is_empty() && found.ties.len() == 1);
            // The scales of the singular face follow from its zero, up to a factor.
            let logs = &found.ties[0].logs;
            let factor = scales[logs[0].0.index()] / logs[0].1.exp();
            for &(h, log) in logs {
                let (found, exact) = (factor * log.exp(), scales[h.index()]);
                assert!((found / exact - 1.0).abs() < 1e-10, "{found} {exact}");
                scales[h.index()] = found;
            }
            let phased = Phased { theta, start: vec![0.0] };
            let values = Values::new(&domain, &phased, &scales, ones, 1).unwrap();
            assert!(values.closure < 1e-12);
            // One constant rotation is left.
            let mut rotation = None;
            for face in mesh.faces() {
                let [along, ..] = bevel.frame(face);
                let w = [0; 3].map(|_| random.range(0.0, 1.0));
                let sum: f64 = w.iter().sum();
                let w = w.map(|w| w / sum);
                let exact = field(Located::in_face(mesh, face, w).position(mesh));
                let ratio = values.power_at(face, w) * in_plane(along) * exact.conj();
                let ratio = ratio * (1.0 / exact.norm_sq());
                let expected = *rotation.get_or_insert(ratio);
                assert!((expected.norm() - 1.0).abs() < 1e-9, "{expected:?}");
                assert!((ratio - expected).norm() < 1e-9, "{face}: {ratio:?} {expected:?}");
            }
        }
    }
}
