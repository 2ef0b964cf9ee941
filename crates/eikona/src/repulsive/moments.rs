//! Areas, centroids and second moments of clusters of faces, and derivatives by them passed down to
//! the faces.

use crate::geometry::vector::{add, dot, scale, sub};
use crate::repulsive::faces::{FaceDatum, FaceForce};
use crate::spatial::ClusterTree;
use eikona_numeric::{NumericError, mapped};

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub(crate) type Symmetric = [f64; 6];

/// What the far field knows of a cluster.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub area: f64,
    pub centre: [f64; 3],
    /// The sum of `a_T d d^T`, where `d` leads from the centre to the centroid of T.
    pub second: Symmetric,
}

/// Derivatives of the energy by the moments of a cluster. That by the second moment is a matrix
/// whose product with it, entry by entry over all nine, is the change.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MomentForce {
    pub area: f64,
    pub centre: [f64; 3],
    pub second: Symmetric,
}

impl MomentForce {
    pub fn add(&mut self, other: &MomentForce) {
        self.area += other.area;
        self.centre = add(self.centre, other.centre);
        self.second.iter_mut().zip(other.second).for_each(|(sum, own)| *sum += own);
    }
}

/// Returns the moments of all clusters of faces in the order of the tree.
pub(crate) fn moments_of(tree: &ClusterTree, faces: &[FaceDatum], threads: usize) -> Vec<Moments> {
    let mut result = vec![Moments::default(); tree.nodes().len()];
    tree.ascend(&mut result, 1, threads, |node, own, children| {
        own[0] = match children {
            Some([first, second]) => combined([first[0], second[0]].into_iter()),
            None => combined(faces[tree.nodes()[node].places()].iter().map(of_face)),
        };
    });
    result
}

fn of_face(face: &FaceDatum) -> Moments {
    Moments { area: face.area, centre: face.centroid, second: [0.0; 6] }
}

fn combined(parts: impl Iterator<Item = Moments> + Clone) -> Moments {
    let area: f64 = parts.clone().map(|part| part.area).sum();
    let weighted = parts.clone().fold([0.0; 3], |sum, part| add(sum, scale(part.centre, part.area)));
    let centre = scale(weighted, 1.0 / area);
    let mut second = [0.0; 6];
    for part in parts {
        let d = sub(part.centre, centre);
        for ((sum, own), square) in second.iter_mut().zip(part.second).zip(squares(d)) {
            *sum += own + part.area * square;
        }
    }
    Moments { area, centre, second }
}

/// `d d^T`
fn squares([x, y, z]: [f64; 3]) -> Symmetric {
    [x * x, y * y, z * z, x * y, x * z, y * z]
}

fn times([xx, yy, zz, xy, xz, yz]: Symmetric, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// Returns the largest distance of a centroid from the centre of each cluster.
///
/// # Errors
/// [`NumericError::Stopped`].
pub(crate) fn radii(
    tree: &ClusterTree,
    faces: &[FaceDatum],
    moments: &[Moments],
    threads: usize,
) -> Result<Vec<f64>, NumericError> {
    mapped(threads, tree.nodes().len(), |node| {
        radius(&faces[tree.nodes()[node].places()], moments[node].centre)
    })
}

/// Returns the largest distance of a centroid from a point.
pub(crate) fn radius(faces: &[FaceDatum], centre: [f64; 3]) -> f64 {
    let away = |face: &FaceDatum| {
        let d = sub(face.centroid, centre);
        dot(d, d)
    };
    faces.iter().map(away).fold(0.0, f64::max).sqrt()
}

/// Adds to derivatives by the moments of clusters those that come from the clusters around them.
pub(crate) fn pass_down(tree: &ClusterTree, moments: &[Moments], forces: &mut [MomentForce], threads: usize) {
    tree.descend(forces, 1, threads, |[node, first, second], force, [at_first, at_second]| {
        for (child, sum) in [(first, at_first), (second, at_second)] {
            sum[0].add(&part_of(&force[0], &moments[node], &moments[child]));
        }
    });
}

/// Returns the derivative by a face of a leaf, from that by the moments of the leaf.
pub(crate) fn force_of_face(force: &MomentForce, leaf: &Moments, face: &FaceDatum) -> FaceForce {
    let MomentForce { centre, area, .. } = part_of(force, leaf, &of_face(face));
    FaceForce { centroid: centre, area, ..FaceForce::default() }
}

/// The derivative by the moments of a part, from that by the moments of the whole.
fn part_of(force: &MomentForce, whole: &Moments, part: &Moments) -> MomentForce {
    let d = sub(part.centre, whole.centre);
    let turned = times(force.second, d);
    let share = part.area / whole.area;
    MomentForce {
        area: force.area + dot(force.centre, d) / whole.area + dot(d, turned),
        centre: add(scale(force.centre, share), scale(turned, 2.0 * part.area)),
        second: force.second,
    }
}
