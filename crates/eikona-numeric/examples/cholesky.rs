//! Times our Cholesky factorisation beside the backend's supernodal one, on Laplacians of a torus:
//! `cargo run -p eikona-numeric --example cholesky [--features faer/rayon] [vertices ...]`. With
//! the feature, the backend also runs on all cores.
//!
//! Both use the same elimination order. The matrix is `M + t L`, with the mass `M` and the
//! cotangent Laplacian `L`; its factor decays with distance over lengths of about the square root
//! of `t`, so the shorter the time, the more of its entries are denormal or zero.

use eikona_numeric::{Cholesky, Graph, Ordering, Symbolic, SymmetricMatrix, nested_dissection_order};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut, Par, Side};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

/// Repetitions of each measurement, of which the fastest counts.
const REPETITIONS: usize = 5;

fn main() {
    let given: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    println!("vertices  t / h2 code threads symbolic  numeric    1 rhs    2 rhs    8 rhs   entries residual");
    for vertices in if given.is_empty() { vec![100_000, 250_000] } else { given } {
        for time in [1e4, 1.0, 1e-2] {
            let torus = Torus::new(vertices, time);
            for threads in [1, 2] {
                torus.print("ours", threads, &torus.ours(threads));
            }
            // All cores with the feature, else one.
            let mut all = vec![Par::Seq, faer::get_global_parallelism()];
            all.dedup_by_key(|par| par.degree());
            for par in all {
                torus.print("faer", par.degree(), &torus.faer(par));
            }
        }
    }
}

/// Measured seconds, entries of the factor and largest residual.
struct Measured {
    symbolic: f64,
    numeric: f64,
    /// For one, two and eight right-hand sides.
    solve: [f64; 3],
    entries: usize,
    residual: f64,
}

/// A system on a triangulated torus.
struct Torus {
    /// Diffusion time over the squared mean edge length.
    time: f64,
    graph: Graph,
    matrix: SymmetricMatrix<f64>,
    order: Vec<u32>,
    rhs: Vec<Vec<f64>>,
}

impl Torus {
    fn new(vertices: usize, time: f64) -> Torus {
        let columns = (vertices as f64 / 2.0).sqrt() as usize;
        let rows = 2 * columns;
        let id = |i: usize, j: usize| ((i % rows) * columns + j % columns) as u32;
        let position = |v: u32| {
            let [a, b] = [v as usize / columns, v as usize % columns];
            let (sa, ca) = (TAU * a as f64 / rows as f64).sin_cos();
            let (sb, cb) = (TAU * b as f64 / columns as f64).sin_cos();
            [(2.0 + cb) * ca, (2.0 + cb) * sa, sb]
        };
        let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let faces: Vec<[u32; 3]> = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let positions: Vec<[f64; 3]> = (0..(rows * columns) as u32).map(position).collect();
        let mut graph = Graph { unknowns: positions.len(), pairs: Vec::new() };
        let mut cotangents = Vec::new();
        let mut mass = vec![0.0; positions.len()];
        let mut squares = 0.0;
        for face in &faces {
            for k in 0..3 {
                let [i, j, opposite] = [0, 1, 2].map(|side| face[(k + side) % 3]);
                let [p, q, o] = [i, j, opposite].map(|v| positions[v as usize]);
                let dot =
                    |a: [f64; 3], b: [f64; 3]| (0..3).map(|x| (a[x] - o[x]) * (b[x] - o[x])).sum::<f64>();
                let twice_area = (dot(p, p) * dot(q, q) - dot(p, q).powi(2)).sqrt();
                graph.pairs.push([i, j]);
                cotangents.push(dot(p, q) / twice_area / 2.0);
                mass[opposite as usize] += twice_area / 6.0;
                squares += dot(p, p) + dot(q, q) - 2.0 * dot(p, q);
            }
        }
        let t = time * squares / graph.pairs.len() as f64;
        let mut matrix =
            SymmetricMatrix { off_diagonal: cotangents.iter().map(|c| -t * c).collect(), diagonal: mass };
        for (&[i, j], cotangent) in graph.pairs.iter().zip(&cotangents) {
            matrix.diagonal[i as usize] += t * cotangent;
            matrix.diagonal[j as usize] += t * cotangent;
        }
        let order = nested_dissection_order(&graph, &positions, 1).expect("one position per unknown");
        let rhs = (0..8).map(|c| (0..graph.unknowns).map(|i| ((i + c) as f64).sin()).collect()).collect();
        Torus { time, graph, matrix, order, rhs }
    }

    fn ours(&self, threads: usize) -> Measured {
        let analyse = || Symbolic::new(&self.graph, Ordering::Given(&self.order)).expect("a valid pattern");
        let (symbolic, analysed) = fastest(analyse);
        let analysed = Arc::new(analysed);
        let factor = || Cholesky::on_threads(analysed.clone(), &self.matrix, threads).expect("definite");
        let (numeric, factor) = fastest(factor);
        let solve = |count: usize| fastest(|| factor.solve_many(&self.rhs[..count]).expect("finite"));
        let measured = [1, 2, 8].map(solve);
        let residuals = measured[2].1.iter().zip(&self.rhs).map(|(x, rhs)| factor.relative_residual(x, rhs));
        Measured {
            symbolic,
            numeric,
            residual: residuals.fold(0.0, f64::max),
            solve: measured.map(|(seconds, _)| seconds),
            entries: analysed.factor_entries(),
        }
    }

    fn faer(&self, par: Par) -> Measured {
        let n = self.graph.unknowns;
        let diagonal =
            self.matrix.diagonal.iter().enumerate().map(|(i, &v)| Triplet::new(i as u32, i as u32, v));
        let below = self.graph.pairs.iter().zip(&self.matrix.off_diagonal);
        let below = below.map(|(&[i, j], &v)| Triplet::new(i.max(j), i.min(j), v));
        let triplets: Vec<_> = diagonal.chain(below).collect();
        let lower = SparseColMat::try_new_from_triplets(n, n, &triplets).expect("valid indices");
        let mut place = vec![0u32; n];
        self.order.iter().enumerate().for_each(|(p, &unknown)| place[unknown as usize] = p as u32);
        let order = PermRef::new_checked(&self.order, &place, n);
        let analyse = || {
            let supernodal = SupernodalThreshold::FORCE_SUPERNODAL;
            let params =
                CholeskySymbolicParams { supernodal_flop_ratio_threshold: supernodal, ..Default::default() };
            let order = SymmetricOrdering::Custom(order);
            factorize_symbolic_cholesky(lower.symbolic(), Side::Lower, order, params).expect("enough memory")
        };
        let (symbolic, analysed) = fastest(analyse);
        let SymbolicCholeskyRaw::Supernodal(structure) = analysed.raw() else { unreachable!("forced") };
        let (numeric, values) = fastest(|| {
            let mut values = vec![0.0; analysed.len_val()];
            let mut memory =
                MemBuffer::new(analysed.factorize_numeric_llt_scratch::<f64>(par, Default::default()));
            let stack = MemStack::new(&mut memory);
            let (regularization, params) = (LltRegularization::default(), Default::default());
            analysed
                .factorize_numeric_llt(
                    &mut values,
                    lower.as_ref(),
                    Side::Lower,
                    regularization,
                    par,
                    stack,
                    params,
                )
                .expect("definite");
            values
        });
        let factor = faer::sparse::linalg::cholesky::LltRef::new(&analysed, &values);
        let measured = [1, 2, 8].map(|count| {
            fastest(|| {
                let mut x = self.rhs[..count].concat();
                let mut memory = MemBuffer::new(analysed.solve_in_place_scratch::<f64>(count, par));
                let columns = MatMut::from_column_major_slice_mut(&mut x, n, count);
                factor.solve_in_place_with_conj(Conj::No, columns, par, MemStack::new(&mut memory));
                x
            })
        });
        let symbolic_of_ours =
            Symbolic::new(&self.graph, Ordering::Given(&self.order)).expect("a valid pattern");
        let ours = Cholesky::new(symbolic_of_ours.into(), &self.matrix).expect("definite");
        let residuals = measured[2].1.chunks(n).zip(&self.rhs).map(|(x, rhs)| ours.relative_residual(x, rhs));
        Measured {
            symbolic,
            numeric,
            residual: residuals.fold(0.0, f64::max),
            solve: measured.map(|(seconds, _)| seconds),
            entries: structure.len_val(),
        }
    }

    fn print(&self, method: &str, threads: usize, measured: &Measured) {
        let [one, two, eight] = measured.solve;
        println!(
            "{:8} {:7.0e} {method} {threads:7} {:8.3} {:8.3} {one:8.4} {two:8.4} {eight:8.4} {:9.3e} {:8.0e}",
            self.graph.unknowns,
            self.time,
            measured.symbolic,
            measured.numeric,
            measured.entries as f64,
            measured.residual
        );
    }
}

/// Returns the seconds of the fastest of several runs, and its result.
fn fastest<R>(run: impl Fn() -> R) -> (f64, R) {
    let timed = || {
        let start = Instant::now();
        let result = run();
        (start.elapsed().as_secs_f64(), result)
    };
    (1..REPETITIONS).fold(timed(), |best, _| {
        let next = timed();
        if next.0 < best.0 { next } else { best }
    })
}
