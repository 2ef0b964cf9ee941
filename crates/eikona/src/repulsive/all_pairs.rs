//! The tangent-point energy by a sum over all pairs of faces (RS equations 2 and 3).

use crate::geometry::vector::{add, dot, scale, sub};
use crate::repulsive::faces::{FaceDatum, FaceForce, Row};
use crate::repulsive::near_contact::NearContact;
use crate::repulsive::options::Exponents;
use eikona_numeric::{NumericError, check_stopped, for_chunks};

/// Faces per piece of work.
const ROWS: usize = 64;

/// Returns what each face contributes, the same for any number of threads. Pairs in near contact
/// are left out.
pub(crate) fn all_pairs(
    faces: &[FaceDatum],
    exponents: Exponents,
    contact: &NearContact,
    threads: usize,
) -> Result<Vec<Row>, NumericError> {
    let Exponents { alpha, beta } = exponents;
    let whole = |x: f64| (x.fract() == 0.0 && x < 64.0).then_some(x as i32);
    // The derivative by the distance q from the tangent plane has the factor q^(alpha - 2) q.
    match (whole(0.5 * alpha - 1.0), whole(0.5 * beta)) {
        (Some(2), Some(6)) => {
            let sixth = |x: f64| {
                let cube = x * x * x;
                cube * cube
            };
            rows(faces, exponents, contact, threads, |x| x * x, sixth)
        }
        (Some(a), Some(b)) => rows(faces, exponents, contact, threads, |x| x.powi(a), |x| x.powi(b)),
        _ => rows(faces, exponents, contact, threads, |x| x.powf(0.5 * alpha - 1.0), |x| x.powf(0.5 * beta)),
    }
}

/// `plane` raises the squared distance from the tangent plane to `alpha / 2 - 1`, and `inverse` the
/// inverse of the squared distance to `beta / 2`.
fn rows(
    faces: &[FaceDatum],
    exponents: Exponents,
    contact: &NearContact,
    threads: usize,
    plane: impl Fn(f64) -> f64 + Copy + Send + Sync,
    inverse: impl Fn(f64) -> f64 + Copy + Send + Sync,
) -> Result<Vec<Row>, NumericError> {
    let mut result = vec![Row::default(); faces.len()];
    for_chunks(threads, &mut result, ROWS, |piece, rows| {
        check_stopped()?;
        for (j, row) in rows.iter_mut().enumerate() {
            let own = piece * ROWS + j;
            *row = one_row(faces, own, contact.partners(own), exponents, plane, inverse);
        }
        Ok::<(), NumericError>(())
    })?;
    Ok(result)
}

fn one_row(
    faces: &[FaceDatum],
    own: usize,
    left_out: &[u32],
    Exponents { alpha, beta }: Exponents,
    plane: impl Fn(f64) -> f64,
    inverse: impl Fn(f64) -> f64,
) -> Row {
    let s = faces[own];
    let (mut density, mut both, mut along_own) = (0.0, 0.0, 0.0);
    let (mut along_other, mut radial, mut tilt) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let mut left_out: Vec<usize> = left_out.iter().map(|t| *t as usize).chain([own]).collect();
    left_out.sort_unstable();
    let ends = left_out.iter().copied().chain([faces.len()]);
    let starts = std::iter::once(0).chain(left_out.iter().map(|t| t + 1));
    for (start, end) in starts.zip(ends) {
        for t in &faces[start..end] {
            let v = sub(s.centroid, t.centroid);
            let inverse_sq = 1.0 / dot(v, v);
            let power = inverse(inverse_sq);
            // Distances from the tangent planes of both faces, and the kernels in both directions.
            let (p, q) = (dot(s.normal, v), dot(t.normal, v));
            let (at_p, at_q) = (plane(p * p) * power, plane(q * q) * power);
            let (out, back) = (at_p * p * p, at_q * q * q);
            density += t.area * out;
            both += t.area * (out + back);
            along_own += t.area * at_p * p;
            along_other = add(along_other, scale(t.normal, t.area * at_q * q));
            radial = add(radial, scale(v, t.area * (out + back) * inverse_sq));
            tilt = add(tilt, scale(v, t.area * at_p * p));
        }
    }
    let turned = scale(add(scale(s.normal, along_own), along_other), alpha);
    let centroid = scale(sub(turned, scale(radial, beta)), s.area);
    let force = FaceForce { centroid, normal: scale(tilt, alpha * s.area), area: both };
    Row { density, force }
}
