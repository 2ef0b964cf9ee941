//! Kernel matrices on a partition of all pairs of faces, and their products.

use super::partition::Partition;
use crate::geometry::vector::{dot, sub};
use crate::repulsive::faces::FaceDatum;
use crate::repulsive::moments::{Moments, Symmetric};
use crate::repulsive::options::Exponents;
use crate::spatial::{ClusterTree, LEAF_POINTS};
use eikona_numeric::{
    CompressedRows, Instructions, NumericError, Pack, Vectorized, check_step, check_stopped, for_chunks,
    together, vectorized,
};

/// Entries of a near block: column by column, so that the faces of a leaf fill vectors.
const BLOCK: usize = LEAF_POINTS * LEAF_POINTS;

/// One of the kernels.
#[derive(Clone, Copy, Debug)]
pub(super) enum KernelKind {
    High,
    Low,
    Fractional,
}

/// The kernels of the inner product, as powers of the squared distance `q`: `q^-s` for the term of
/// high order; the same times `((n_S . v)^2 + (n_T . v)^2) / 2 q^2` for that of low order; and
/// `q^-(3 - s)` for the fractional Laplacian of the preconditioner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernels {
    order: f64,
    /// `3 s`, if that is a whole number: then powers of a cube root suffice.
    thirds: Option<i32>,
}

impl Kernels {
    /// Returns the kernels of `s = (beta - 2) / alpha`.
    pub fn new(exponents: Exponents) -> Kernels {
        let order = exponents.order();
        let thirds = (3.0 * order).round();
        let is_whole = (3.0 * order - thirds).abs() < 1e-12 && (0.0..9.0).contains(&thirds);
        Kernels { order, thirds: is_whole.then_some(thirds as i32) }
    }

    /// Returns the high and the fractional kernel at a squared distance; zero at zero.
    pub fn at(&self, squared: f64) -> [f64; 2] {
        if squared == 0.0 {
            return [0.0; 2];
        }
        match self.thirds {
            Some(thirds) => {
                let root = squared.cbrt().recip();
                [root.powi(thirds), root.powi(9 - thirds)]
            }
            None => [squared.powf(-self.order), squared.powf(self.order - 3.0)],
        }
    }

    /// Returns the entry of two faces.
    pub fn entry(&self, kind: KernelKind, s: &FaceDatum, t: &FaceDatum) -> f64 {
        let v = sub(s.centroid, t.centroid);
        let squared = dot(v, v);
        let [high, fractional] = self.at(squared);
        match kind {
            KernelKind::High => high,
            KernelKind::Low => {
                let (p, q) = (dot(s.normal, v), dot(t.normal, v));
                0.5 * (p * p + q * q) / (squared * squared) * high
            }
            KernelKind::Fractional => fractional,
        }
    }

    /// Like [`at`](Self::at), to single precision.
    #[inline(always)]
    fn at_pack<S: Instructions>(&self, simd: S, squared: Pack<S>) -> [Pack<S>; 2] {
        match self.thirds {
            Some(thirds) => {
                let root = squared.inverse_cube_root(simd);
                // Zero at the face itself.
                let root = root - root * squared.is_zero();
                [root.power(thirds as u32), root.power(9 - thirds as u32)]
            }
            None => {
                let power = |exponent: f64| move |x: f64| if x == 0.0 { 0.0 } else { x.powf(exponent) };
                [squared.map(power(-self.order)), squared.map(power(self.order - 3.0))]
            }
        }
    }
}

/// One kernel matrix `H`, with a zero diagonal, on the leaves of a block cluster tree.
#[derive(Default)]
pub(super) struct KernelMatrix {
    /// Near blocks in the order of the partition.
    near: Vec<f32>,
    /// Far blocks, each one number.
    far: Vec<f64>,
    /// `(H a) / a` at each face.
    row_sums: Vec<f64>,
}

/// The three kernel matrices.
pub(super) struct KernelMatrices {
    high: KernelMatrix,
    low: KernelMatrix,
    fractional: KernelMatrix,
}

impl KernelMatrices {
    pub fn get(&self, kind: KernelKind) -> &KernelMatrix {
        match kind {
            KernelKind::High => &self.high,
            KernelKind::Low => &self.low,
            KernelKind::Fractional => &self.fractional,
        }
    }

    /// Computes the entries for faces in the order of the tree.
    pub fn new(
        tree: &ClusterTree,
        partition: &Partition,
        faces: &[FaceDatum],
        moments: &[Moments],
        kernels: Kernels,
        threads: usize,
    ) -> Result<KernelMatrices, NumericError> {
        let near = filled(&partition.near, BLOCK, threads, |leaf, near, entries| {
            vectorized(Blocks { faces, kernels, leaf, near, entries });
        })?;
        let projectors = mean_projectors(tree, faces, moments, threads);
        let far = filled(&partition.far, 1, threads, |node, row, [high, low, fractional]| {
            for (i, &other) in row.iter().enumerate() {
                let other = other as usize;
                let v = sub(moments[node].centre, moments[other].centre);
                let squared = dot(v, v);
                let out = in_plane(&projectors[node], v) + in_plane(&projectors[other], v);
                [high[i], fractional[i]] = kernels.at(squared);
                low[i] = 0.5 * out / (squared * squared) * high[i];
            }
        })?;
        let areas: Vec<[f64; 1]> = faces.iter().map(|face| [face.area]).collect();
        let matrix = |near: Vec<f32>, far: Vec<f64>| -> Result<KernelMatrix, NumericError> {
            let mut matrix = KernelMatrix { near, far, row_sums: vec![0.0; faces.len()] };
            let sums = matrix.times(tree, partition, &areas, 1, threads)?;
            matrix.row_sums = sums.iter().zip(faces).map(|([sum], face)| -sum / face.area).collect();
            Ok(matrix)
        };
        let ([high, low, fractional], [far_high, far_low, far_fractional]) = (near, far);
        Ok(KernelMatrices {
            high: matrix(high, far_high)?,
            low: matrix(low, far_low)?,
            fractional: matrix(fractional, far_fractional)?,
        })
    }
}

/// Returns three arrays with `size` entries per item of the rows, which `fill` writes row by row.
fn filled<T: Clone + Default + Send>(
    rows: &CompressedRows<u32>,
    size: usize,
    threads: usize,
    fill: impl Fn(usize, &[u32], [&mut [T]; 3]) + Sync,
) -> Result<[Vec<T>; 3], NumericError> {
    let (starts, items) = (rows.starts(), rows.items().len());
    let mut arrays = [(); 3].map(|()| vec![T::default(); items * size]);
    check_stopped()?;
    let mut rest = arrays.each_mut().map(|array| &mut array[..]);
    let share = items.div_ceil(threads.max(1)).max(1);
    let (mut tasks, mut row, last) = (Vec::new(), 0, starts.len() - 1);
    while row < last {
        let end = starts.partition_point(|start| (*start as usize) < starts[row] as usize + share).min(last);
        let own = row..if starts[end] as usize == items { last } else { end };
        row = own.end;
        let mut entries = rest.each_mut().map(|rest| {
            let length = (starts[own.end] - starts[own.start]) as usize * size;
            rest.split_off_mut(..length).unwrap_or_default()
        });
        let fill = &fill;
        tasks.push(move || {
            for row in own {
                check_step(64 * row)?;
                let items = rows.row(row);
                let own = entries.each_mut().map(|entries| entries.split_off_mut(..items.len() * size));
                fill(row, items, own.map(Option::unwrap_or_default));
            }
            Ok(())
        });
    }
    together(tasks).into_iter().collect::<Result<(), NumericError>>()?;
    Ok(arrays)
}

/// `v^T P v`
fn in_plane([xx, yy, zz, xy, xz, yz]: &Symmetric, [x, y, z]: [f64; 3]) -> f64 {
    xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z)
}

/// The mean of `n n^T` over each cluster.
fn mean_projectors(
    tree: &ClusterTree,
    faces: &[FaceDatum],
    moments: &[Moments],
    threads: usize,
) -> Vec<Symmetric> {
    let mut sums = vec![[0.0; 6]; moments.len()];
    tree.ascend(&mut sums, 1, threads, |node, own, children| {
        let sum = &mut own[0];
        match children {
            Some(children) => {
                for child in children {
                    (0..6).for_each(|k| sum[k] += child[0][k]);
                }
            }
            None => {
                for face in &faces[tree.nodes()[node].places()] {
                    let [x, y, z] = face.normal;
                    let own = [x * x, y * y, z * z, x * y, x * z, y * z];
                    (0..6).for_each(|k| sum[k] += face.area * own[k]);
                }
            }
        }
    });
    sums.iter_mut().zip(moments).for_each(|(sum, own)| sum.iter_mut().for_each(|x| *x /= own.area));
    sums
}

/// The near blocks of a leaf.
struct Blocks<'a> {
    faces: &'a [FaceDatum],
    kernels: Kernels,
    leaf: usize,
    near: &'a [u32],
    entries: [&'a mut [f32]; 3],
}

/// The places of the faces of a leaf.
fn places(faces: usize, leaf: usize) -> std::ops::Range<usize> {
    LEAF_POINTS * leaf..faces.min(LEAF_POINTS * (leaf + 1))
}

impl Vectorized for Blocks<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Instructions>(self, simd: S) {
        let Blocks { faces, kernels, leaf, near, entries: [high, low, fractional] } = self;
        let mut own = [[0.0; LEAF_POINTS]; 6];
        for (lane, face) in faces[places(faces.len(), leaf)].iter().enumerate() {
            for k in 0..3 {
                own[k][lane] = face.centroid[k];
                own[3 + k][lane] = face.normal[k];
            }
        }
        let half = Pack::splat(simd, 0.5);
        for (block, &other) in near.iter().enumerate() {
            for (column, face) in faces[places(faces.len(), other as usize)].iter().enumerate() {
                let start = block * BLOCK + column * LEAF_POINTS;
                for part in 0..LEAF_POINTS / Pack::<S>::LANES {
                    let [x, y, z, nx, ny, nz] = std::array::from_fn(
                        #[inline(always)]
                        |k| Pack::load(simd, &own[k], part),
                    );
                    let [cx, cy, cz] = face.centroid.map(
                        #[inline(always)]
                        |x| Pack::splat(simd, x),
                    );
                    let [mx, my, mz] = face.normal.map(
                        #[inline(always)]
                        |x| Pack::splat(simd, x),
                    );
                    let v = [x - cx, y - cy, z - cz];
                    let squared = v[0].mul_add(v[0], v[1].mul_add(v[1], v[2] * v[2]));
                    let p = nx.mul_add(v[0], ny.mul_add(v[1], nz * v[2]));
                    let q = mx.mul_add(v[0], my.mul_add(v[1], mz * v[2]));
                    let [own_high, own_fractional] = kernels.at_pack(simd, squared);
                    let inverse = squared.inverse_or_zero();
                    // The same in both directions to the last bit.
                    let out = half * (p * p + q * q) * inverse * inverse;
                    let range = start + part * Pack::<S>::LANES..;
                    own_high.store_single(&mut high[range.clone()]);
                    (out * own_high).store_single(&mut low[range.clone()]);
                    own_fractional.store_single(&mut fractional[range]);
                }
            }
        }
    }
}

impl KernelMatrix {
    /// Returns `diag((H a) / a) u - H u` for `many` times N columns `u` with one entry per face, in
    /// the order of the tree: the entries of a face lie together.
    ///
    /// # Cost
    /// One pass over the entries of the matrix.
    pub fn times<const N: usize>(
        &self,
        tree: &ClusterTree,
        partition: &Partition,
        columns: &[[f64; N]],
        many: usize,
        threads: usize,
    ) -> Result<Vec<[f64; N]>, NumericError> {
        let far = self.far_parts(tree, partition, columns, many, threads)?;
        let mut result = vec![[0.0; N]; columns.len()];
        for_chunks(threads, &mut result, LEAF_POINTS * many, |leaf, result| {
            if leaf % 64 == 0 {
                check_stopped()?;
            }
            let node = partition.leaves[leaf] as usize;
            let far = &far[node * many..(node + 1) * many];
            vectorized(Product { matrix: self, partition, columns, many, leaf, far, result });
            Ok::<(), NumericError>(())
        })?;
        Ok(result)
    }

    /// The far part of `H u` at the faces of each cluster.
    fn far_parts<const N: usize>(
        &self,
        tree: &ClusterTree,
        partition: &Partition,
        columns: &[[f64; N]],
        many: usize,
        threads: usize,
    ) -> Result<Vec<[f64; N]>, NumericError> {
        let nodes = tree.nodes().len();
        let add = |sum: &mut [f64; N], own: &[f64; N]| (0..N).for_each(|c| sum[c] += own[c]);
        let add_all = |sums: &mut [[f64; N]], others: &[[f64; N]]| {
            sums.iter_mut().zip(others).for_each(|(sum, own)| add(sum, own));
        };
        let mut sums = vec![[0.0; N]; nodes * many];
        tree.ascend(&mut sums, many, threads, |node, own, children| match children {
            Some(children) => children.iter().for_each(|child| add_all(own, child)),
            None => {
                let places = tree.nodes()[node].places();
                columns[places.start * many..places.end * many]
                    .chunks(many)
                    .for_each(|face| add_all(own, face));
            }
        });
        check_stopped()?;
        let mut result = vec![[0.0; N]; nodes * many];
        for_chunks(threads, &mut result, many, |node, result| {
            check_step(node)?;
            let first = partition.far.starts()[node] as usize;
            for (entry, &other) in self.far[first..].iter().zip(partition.far.row(node)) {
                for (result, sum) in result.iter_mut().zip(&sums[other as usize * many..]) {
                    (0..N).for_each(|c| result[c] += entry * sum[c]);
                }
            }
            Ok::<(), NumericError>(())
        })?;
        tree.descend(&mut result, many, threads, |_, own, children| {
            children.into_iter().for_each(|child| add_all(child, own));
        });
        Ok(result)
    }
}

/// The rows of a product at the faces of a leaf.
struct Product<'a, const N: usize> {
    matrix: &'a KernelMatrix,
    partition: &'a Partition,
    columns: &'a [[f64; N]],
    many: usize,
    leaf: usize,
    far: &'a [[f64; N]],
    result: &'a mut [[f64; N]],
}

impl<const N: usize> Vectorized for Product<'_, N> {
    type Output = ();
    #[inline(always)]
    fn run<S: Instructions>(self, simd: S) {
        let Product { matrix, partition, columns, many, leaf, far, result } = self;
        let faces = columns.len() / many;
        let first = partition.near.starts()[leaf] as usize * BLOCK;
        let lanes = Pack::<S>::LANES;
        for k in 0..many {
            for part in 0..LEAF_POINTS / lanes {
                let mut sums = [Pack::splat(simd, 0.0); N];
                for (block, &other) in partition.near.row(leaf).iter().enumerate() {
                    let entries = &matrix.near[first + block * BLOCK..][..BLOCK];
                    for (column, place) in places(faces, other as usize).enumerate() {
                        let entry = Pack::load_single(simd, entries, column * (LEAF_POINTS / lanes) + part);
                        let partner = &columns[place * many + k];
                        for c in 0..N {
                            sums[c] = entry.mul_add(Pack::splat(simd, partner[c]), sums[c]);
                        }
                    }
                }
                let mut near = [[0.0; LEAF_POINTS]; N];
                for c in 0..N {
                    sums[c].add_to(&mut near[c], 0);
                }
                for (lane, place) in places(faces, leaf).skip(part * lanes).take(lanes).enumerate() {
                    let own = &columns[place * many + k];
                    let result = &mut result[(part * lanes + lane) * many + k];
                    let row_sum = matrix.row_sums[place];
                    for c in 0..N {
                        result[c] = row_sum * own[c] - near[c][lane] - far[k][c];
                    }
                }
            }
        }
    }
}
