//! The tangent-point energy by a sum over near faces and far clusters.
//!
//! The kernel `K(S, T)` depends on T through its centroid only. Seen from a face S, the sum over a
//! far cluster is therefore expanded around the centroid of the cluster up to the second moments;
//! the first ones vanish. Normals are never averaged, which is what makes expansions of lower order
//! wrong on spheres: there `n_S . v` itself is of second order.
//!
//! Deviation: section 4.1 of the paper stops at order zero, which is 5 to 15 % off on fine spheres.
//!
//! Which clusters are far is decided once, for all faces of a leaf, and stays fixed while the
//! surface moves: so the sum is a smooth function of the positions, and the differential is its
//! exact derivative.

use crate::geometry::vector::dot;
use crate::repulsive::faces::{FaceDatum, FaceForce, Row};
use crate::repulsive::kernel::{Kernel, Powers};
use crate::repulsive::leaf_sums::{
    Far, Near, far_density, far_row, fill, near_density, near_row, put_back, take_out,
};
use crate::repulsive::moments::{MomentForce, Moments, force_of_face, moments_of, pass_down, radii};
use crate::repulsive::near_contact::NearContact;
use crate::repulsive::options::Exponents;
use crate::spatial::{ClusterTree, LEAF_POINTS};
use eikona_numeric::{Instructions, NumericError, Vectorized, check_stopped, for_chunks, mapped, vectorized};
use std::ops::Range;

/// Which faces are near to the faces of a leaf, and which clusters are far from them.
pub(crate) struct Interactions {
    pub tree: ClusterTree,
    leaves: Vec<LeafList>,
}

#[derive(Clone, Debug, Default)]
struct LeafList {
    /// The node of the leaf.
    node: u32,
    /// Nodes of near leaves, its own among them.
    near: Vec<u32>,
    /// Far nodes.
    far: Vec<u32>,
    /// Pairs in near contact, which are left out: the number of a face within the leaf, and that of
    /// its partner among the near faces.
    left_out: Vec<[u32; 2]>,
}

impl Interactions {
    /// Divides the faces into near and far ones. A cluster is far from a leaf if its radius is less
    /// than `separation` times its distance from the centroids of the leaf, and none of its faces
    /// is in near contact with one of the leaf. Pairs that are in near contact are left out.
    pub fn new(
        faces: &[FaceDatum],
        separation: f64,
        contact: &NearContact,
        threads: usize,
    ) -> Result<Interactions, NumericError> {
        let centroids: Vec<[f64; 3]> = faces.iter().map(|face| face.centroid).collect();
        let tree = ClusterTree::on_threads(&centroids, threads);
        check_stopped()?;
        let ordered = tree.in_order(faces);
        let moments = moments_of(&tree, &ordered, threads);
        let reach = radii(&tree, &ordered, &moments, threads)?;
        let reach = reach.into_iter().map(|r| (r / separation).powi(2)).collect();
        let place_of = if contact.pairs.is_empty() { Vec::new() } else { places_of(&tree) };
        let search = Search { tree: &tree, ordered: &ordered, moments: &moments, reach, contact, place_of };
        let nodes: Vec<usize> = tree.leaves().collect();
        let leaves = mapped(threads, nodes.len(), |leaf| search.list_of(nodes[leaf]))?;
        Ok(Interactions { tree, leaves })
    }
}

/// What decides which clusters are far from a leaf.
struct Search<'a> {
    tree: &'a ClusterTree,
    ordered: &'a [FaceDatum],
    moments: &'a [Moments],
    /// The square of the distance from which on each cluster is far.
    reach: Vec<f64>,
    contact: &'a NearContact,
    place_of: Vec<u32>,
}

impl Search<'_> {
    fn list_of(&self, node: usize) -> LeafList {
        let Search { tree, moments, .. } = self;
        let places = tree.nodes()[node].places();
        let own = &self.ordered[places.clone()];
        let (mut low, mut high) = (own[0].centroid, own[0].centroid);
        for face in own {
            for k in 0..3 {
                low[k] = low[k].min(face.centroid[k]);
                high[k] = high[k].max(face.centroid[k]);
            }
        }
        let mut list = LeafList { node: node as u32, ..LeafList::default() };
        let partners = partners_of(tree, places, self.contact, &self.place_of);
        let mut stack = vec![0];
        while let Some(other) = stack.pop() {
            let c = moments[other].centre;
            let away = [0, 1, 2].map(|k| (low[k] - c[k]).max(c[k] - high[k]).max(0.0));
            if dot(away, away) > self.reach[other]
                && within(&partners, tree.nodes()[other].places()).is_empty()
            {
                list.far.push(other as u32);
            } else if let Some([first, second]) = tree.children(other) {
                stack.extend([second, first]);
            } else {
                list.near.push(other as u32);
            }
        }
        list.leave_out(tree, &partners);
        list
    }
}

/// The place of each face.
fn places_of(tree: &ClusterTree) -> Vec<u32> {
    let mut places = vec![0; tree.order().len()];
    tree.order().iter().zip(0..).for_each(|(&face, place)| places[face as usize] = place);
    places
}

/// The places of the faces in near contact with those of a leaf, in increasing order, each with the
/// number of the face within the leaf.
fn partners_of(
    tree: &ClusterTree,
    leaf: Range<usize>,
    contact: &NearContact,
    place_of: &[u32],
) -> Vec<[u32; 2]> {
    let own = tree.order()[leaf].iter().zip(0..);
    let partners = |(&face, number): (&u32, u32)| {
        contact.partners(face as usize).iter().map(move |&other| [place_of[other as usize], number])
    };
    let mut partners: Vec<[u32; 2]> = own.flat_map(partners).collect();
    partners.sort_unstable();
    partners
}

/// Returns those of the partners whose places are in a range.
fn within(partners: &[[u32; 2]], places: Range<usize>) -> &[[u32; 2]] {
    let before = |bound: usize| partners.partition_point(|[place, _]| (*place as usize) < bound);
    &partners[before(places.start)..before(places.end)]
}

impl LeafList {
    fn leave_out(&mut self, tree: &ClusterTree, partners: &[[u32; 2]]) {
        if partners.is_empty() {
            return;
        }
        let mut before = 0;
        for &node in &self.near {
            let places = tree.nodes()[node as usize].places();
            let own = within(partners, places.clone()).iter();
            self.left_out.extend(own.map(|&[place, number]| [number, before + place - places.start as u32]));
            before += places.len() as u32;
        }
        self.left_out.sort_unstable();
    }
}

/// Parts into which the leaves are divided. Their sums are added in this order, so that the result
/// is the same for any number of threads.
const PARTS: usize = 8;

/// Returns what each face contributes; the derivatives only if they are wanted.
pub(crate) fn hierarchical(
    interactions: &Interactions,
    faces: &[FaceDatum],
    exponents: Exponents,
    differential: bool,
    threads: usize,
) -> Result<Vec<Row>, NumericError> {
    let tree = &interactions.tree;
    let ordered = tree.in_order(faces);
    let moments = moments_of(tree, &ordered, threads);
    check_stopped()?;
    let work = Work { interactions, faces: &ordered, moments: &moments, differential };
    let mut rows = vec![Row::default(); ordered.len()];
    let mut total = PartnerForces::new(&work);
    let leaves = interactions.leaves.len().div_ceil(PARTS).max(1);
    let mut parts = interactions.leaves.chunks(leaves).zip(rows.chunks_mut(leaves * LEAF_POINTS));
    // Threads that share all parts need not wait for each other.
    let at_once = if threads > 1 { PARTS } else { 1 };
    loop {
        let part = |(lists, rows)| Part { work: &work, lists, rows, partners: PartnerForces::new(&work) };
        let mut parts: Vec<Part> = parts.by_ref().take(at_once).map(part).collect();
        if parts.is_empty() {
            break;
        }
        for_chunks(threads, &mut parts, 1, |_, part| exponents.with_powers(&mut part[0]))?;
        let sums: Vec<PartnerForces> = parts.into_iter().map(|part| part.partners).collect();
        total.add(&sums, threads)?;
    }
    if differential {
        add_partner_forces(&work, total, threads, &mut rows)?;
    }
    let mut result = vec![Row::default(); rows.len()];
    for (row, &face) in rows.into_iter().zip(tree.order()) {
        result[face as usize] = row;
    }
    Ok(result)
}

/// Adds the derivatives by the partners of leaves to the rows of the faces.
fn add_partner_forces(
    work: &Work,
    sums: PartnerForces,
    threads: usize,
    rows: &mut [Row],
) -> Result<(), NumericError> {
    let PartnerForces { at_faces, mut at_clusters } = sums;
    let Interactions { tree, leaves } = work.interactions;
    pass_down(tree, work.moments, &mut at_clusters, threads);
    for_chunks(threads, rows, LEAF_POINTS, |leaf, rows| {
        let node = leaves[leaf].node as usize;
        for (row, place) in rows.iter_mut().zip(tree.nodes()[node].places()) {
            let [x, y, z, area] = at_faces[place];
            row.force.add(&FaceForce { centroid: [x, y, z], area, ..FaceForce::default() });
            row.force.add(&force_of_face(&at_clusters[node], &work.moments[node], &work.faces[place]));
        }
        Ok(())
    })
}

#[derive(Clone, Copy)]
struct Work<'a> {
    interactions: &'a Interactions,
    faces: &'a [FaceDatum],
    moments: &'a [Moments],
    differential: bool,
}

/// Derivatives by the partners of leaves, in the order of the tree.
struct PartnerForces {
    /// By centroid and area of near faces.
    at_faces: Vec<[f64; 4]>,
    at_clusters: Vec<MomentForce>,
}

impl PartnerForces {
    fn new(work: &Work) -> PartnerForces {
        let (faces, clusters) =
            if work.differential { (work.faces.len(), work.moments.len()) } else { (0, 0) };
        PartnerForces { at_faces: vec![[0.0; 4]; faces], at_clusters: vec![MomentForce::default(); clusters] }
    }

    fn add(&mut self, others: &[PartnerForces], threads: usize) -> Result<(), NumericError> {
        const CHUNK: usize = 1024;
        for_chunks(threads, &mut self.at_faces, CHUNK, |chunk, sums| {
            for other in others {
                let own = &other.at_faces[chunk * CHUNK..];
                sums.iter_mut().zip(own).for_each(|(sum, own)| (0..4).for_each(|k| sum[k] += own[k]));
            }
            Ok::<(), NumericError>(())
        })?;
        for_chunks(threads, &mut self.at_clusters, CHUNK, |chunk, sums| {
            for other in others {
                let own = &other.at_clusters[chunk * CHUNK..];
                sums.iter_mut().zip(own).for_each(|(sum, own)| sum.add(own));
            }
            Ok(())
        })
    }
}

/// Some consecutive leaves, with the rows of their faces.
struct Part<'a> {
    work: &'a Work<'a>,
    lists: &'a [LeafList],
    rows: &'a mut [Row],
    partners: PartnerForces,
}

impl Kernel for &mut Part<'_> {
    type Output = Result<(), NumericError>;
    fn with<P: Powers>(self, exponents: Exponents, powers: P) -> Self::Output {
        let (mut near, mut far) = (Vec::new(), Vec::new());
        let work = *self.work;
        for (step, (list, rows)) in self.lists.iter().zip(self.rows.chunks_mut(LEAF_POINTS)).enumerate() {
            if step % 16 == 0 {
                check_stopped()?;
            }
            gather(&work, list, &mut near, &mut far);
            let faces = &work.faces[work.interactions.tree.nodes()[list.node as usize].places()];
            let differential = work.differential;
            let (near_faces, far_clusters, left_out) = (&mut near[..], &mut far[..], &list.left_out[..]);
            vectorized(Leaf {
                exponents,
                powers,
                faces,
                rows,
                near: near_faces,
                far: far_clusters,
                left_out,
                differential,
            });
            if differential {
                scatter(list, &work, &near, &far, &mut self.partners);
            }
        }
        Ok(())
    }
}

/// Collects the partners of a leaf.
fn gather(work: &Work, list: &LeafList, near: &mut Vec<Near>, far: &mut Vec<Far>) {
    let nodes = work.interactions.tree.nodes();
    let faces = list.near.iter().flat_map(|&node| &work.faces[nodes[node as usize].places()]);
    fill(near, faces.map(|&FaceDatum { centroid: [x, y, z], area, .. }| [x, y, z, area]));
    let clusters = list.far.iter().map(|&node| {
        let Moments { area, centre: [x, y, z], second: [xx, yy, zz, xy, xz, yz] } =
            work.moments[node as usize];
        [x, y, z, area, xx, yy, zz, xy, xz, yz]
    });
    fill(far, clusters);
}

/// Adds the derivatives by the partners of a leaf to the sums.
fn scatter(list: &LeafList, work: &Work, near: &[Near], far: &[Far], sums: &mut PartnerForces) {
    let places = list.near.iter().flat_map(|&node| work.interactions.tree.nodes()[node as usize].places());
    for (i, place) in places.enumerate() {
        (0..4).for_each(|k| sums.at_faces[place][k] += near[i / LEAF_POINTS].0[4 + k][i % LEAF_POINTS]);
    }
    for (i, &node) in list.far.iter().enumerate() {
        let numbers = |k: usize| far[i / LEAF_POINTS].0[k][i % LEAF_POINTS];
        let force = &mut sums.at_clusters[node as usize];
        (0..3).for_each(|k| force.centre[k] += numbers(10 + k));
        force.area += numbers(13);
        (0..6).for_each(|k| force.second[k] += numbers(14 + k));
    }
}

/// All pairs of the faces of a leaf with their partners.
struct Leaf<'a, P> {
    exponents: Exponents,
    powers: P,
    faces: &'a [FaceDatum],
    rows: &'a mut [Row],
    near: &'a mut [Near],
    far: &'a mut [Far],
    left_out: &'a [[u32; 2]],
    differential: bool,
}

impl<P: Powers> Vectorized for Leaf<'_, P> {
    type Output = ();
    #[inline(always)]
    fn run<S: Instructions>(self, simd: S) {
        let Leaf { exponents, powers, faces, rows, near, far, mut left_out, differential } = self;
        for ((face, row), number) in faces.iter().zip(rows).zip(0..) {
            let (own, others) = left_out.split_at(left_out.partition_point(|[face, _]| *face == number));
            left_out = others;
            let hidden: Vec<[f64; 8]> = own.iter().map(|[_, i]| take_out(near, *i as usize)).collect();
            let same;
            if differential {
                (*row, same) = near_row(simd, exponents, powers, face, near);
                row.add(&far_row(simd, exponents, powers, face, far));
            } else {
                [row.density, same] = near_density(simd, powers, face, near);
                row.density += far_density(simd, exponents, powers, face, far);
            }
            own.iter().zip(hidden).for_each(|([_, i], numbers)| put_back(near, *i as usize, numbers));
            // Of two faces at one centroid, the energy is infinite.
            if same != 1.0 {
                row.density = f64::INFINITY;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repulsive::faces::{face_data, pulled_back};
    use eikona_mesh::{TriangleMesh, VertexField, shapes};

    /// Returns the number of near faces and of far clusters, summed over all faces.
    fn pairs(interactions: &Interactions) -> [usize; 2] {
        let count = |list: &LeafList| {
            let nodes = interactions.tree.nodes();
            let own = nodes[list.node as usize].places().len();
            let near = list.near.iter().map(|&node| nodes[node as usize].places().len()).sum::<usize>();
            [near * own, list.far.len() * own]
        };
        interactions.leaves.iter().map(count).fold([0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }

    fn energy(faces: &[FaceDatum], rows: &[Row]) -> f64 {
        faces.iter().zip(rows).map(|(face, row)| face.area * row.density).sum()
    }

    fn differential(mesh: &TriangleMesh, faces: &[FaceDatum], rows: &[Row]) -> VertexField<[f64; 3]> {
        pulled_back(mesh, 1.0, faces, &rows.iter().map(|row| row.force).collect::<Vec<_>>())
    }

    #[test]
    fn the_differential_is_the_derivative_of_the_sum_with_clusters_held() {
        let wave = |v: usize, k: usize| (1.3 * v as f64 + 0.7 * k as f64).sin();
        let torus = shapes::torus(1.0, 0.4, 30, 14).unwrap();
        // No centroid crosses a tangent plane, where kernels of odd powers are not smooth.
        let sphere = shapes::icosphere(3).unwrap();
        for (mesh, alpha, beta) in [
            (&torus, 6.0, 12.0),
            (&torus, 4.0, 8.0),
            (&torus, 8.0, 14.0),
            (&sphere, 6.0, 12.0),
            (&sphere, 3.5, 7.5),
            (&sphere, 2.5, 5.0),
        ] {
            let moved = |step: f64| {
                let at = |(v, p): (usize, &[f64; 3])| [0, 1, 2].map(|k| p[k] + step * 0.02 * wave(v, k));
                mesh.with_positions(mesh.positions().iter().enumerate().map(at).collect()).unwrap()
            };
            let exponents = Exponents::new(alpha, beta).unwrap();
            let faces = face_data(mesh, 1.0, 1).unwrap();
            let interactions = Interactions::new(&faces, 0.6, &NearContact::default(), 1).unwrap();
            let at = |step: f64, differential: bool| {
                let faces = face_data(&moved(step), 1.0, 1).unwrap();
                let rows = hierarchical(&interactions, &faces, exponents, differential, 1).unwrap();
                (faces, rows)
            };
            let (faces, rows) = at(0.0, true);
            let slope: f64 = differential(mesh, &faces, &rows)
                .iter()
                .flat_map(|(v, d)| (0..3).map(move |k| d[k] * 0.02 * wave(v.0 as usize, k)))
                .sum();
            // Central differences of fourth order.
            let sample = |step: f64| {
                let (faces, rows) = at(step, false);
                energy(&faces, &rows)
            };
            let h = 1e-3;
            let quotient =
                (8.0 * (sample(h) - sample(-h)) - (sample(2.0 * h) - sample(-2.0 * h))) / (12.0 * h);
            assert!((slope / quotient - 1.0).abs() < 1e-8, "{alpha}, {beta}: {slope} instead of {quotient}");
            assert_eq!(energy(&faces, &rows), sample(0.0));
        }
    }

    #[test]
    fn all_faces_near_give_the_sum_over_all_pairs() {
        let mesh = shapes::icosphere(2).unwrap();
        let faces = face_data(&mesh, 1.0, 1).unwrap();
        let interactions = Interactions::new(&faces, 1e-9, &NearContact::default(), 1).unwrap();
        assert_eq!(pairs(&interactions), [320 * 320, 0]);
        let near = hierarchical(&interactions, &faces, Exponents::default(), true, 1).unwrap();
        let all =
            crate::repulsive::all_pairs::all_pairs(&faces, Exponents::default(), &NearContact::default(), 1)
                .unwrap();
        let [near, all] = [near, all].map(|rows| (energy(&faces, &rows), differential(&mesh, &faces, &rows)));
        assert!((near.0 / all.0 - 1.0).abs() < 1e-13);
        for (v, d) in near.1.iter() {
            (0..3).for_each(|k| assert!((d[k] - all.1[v][k]).abs() < 1e-13, "{v}"));
        }
    }
}
