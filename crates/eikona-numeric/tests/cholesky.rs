//! Tests the factorisation against matrices with known solutions, and its invariance under
//! renumbering.

use eikona_numeric::{
    Cholesky, Complex, Graph, NumericError, Ordering, Scalar, Symbolic, SymmetricMatrix,
    nested_dissection_order,
};

/// Five-point Laplacian of an `n` by `n` grid plus `shift`, with the position of each unknown.
fn grid(n: usize, shift: f64) -> (Graph, SymmetricMatrix<f64>, Vec<[f64; 3]>) {
    let id = |i: usize, j: usize| (i * n + j) as u32;
    let mut graph = Graph { unknowns: n * n, pairs: Vec::new() };
    let mut matrix = SymmetricMatrix { diagonal: vec![shift; n * n], off_diagonal: Vec::new() };
    let mut join = |a: u32, b: u32| {
        graph.pairs.push([a, b]);
        matrix.off_diagonal.push(-1.0);
        matrix.diagonal[a as usize] += 1.0;
        matrix.diagonal[b as usize] += 1.0;
    };
    for i in 0..n {
        for j in 0..n {
            if i + 1 < n {
                join(id(i, j), id(i + 1, j));
            }
            if j + 1 < n {
                join(id(i, j), id(i, j + 1));
            }
        }
    }
    let positions = (0..n * n).map(|k| [(k / n) as f64, (k % n) as f64, 0.0]).collect();
    (graph, matrix, positions)
}

fn product<T: Scalar>(graph: &Graph, matrix: &SymmetricMatrix<T>, x: &[T]) -> Vec<T> {
    let mut y: Vec<T> = x.iter().zip(&matrix.diagonal).map(|(x, d)| x.scale(*d)).collect();
    for ([i, j], v) in graph.pairs.iter().zip(&matrix.off_diagonal) {
        y[*i as usize] += *v * x[*j as usize];
        y[*j as usize] += v.conj() * x[*i as usize];
    }
    y
}

/// Deterministic pseudorandom sequence in [-1, 1].
fn noise(i: usize) -> f64 {
    let x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[test]
fn eigenvector_of_the_grid_laplacian() {
    let n = 40;
    let (graph, matrix, positions) = grid(n, 0.5);
    // cos(pi k (i + 1/2) / n) cos(pi l (j + 1/2) / n) is an eigenvector of the Laplacian with zero
    // flux at the boundary.
    let (k, l) = (3.0, 5.0);
    let wave = |m: f64, i: usize| (std::f64::consts::PI * m * (i as f64 + 0.5) / n as f64).cos();
    let value = |m: f64| 2.0 - 2.0 * (std::f64::consts::PI * m / n as f64).cos();
    let vector: Vec<f64> = (0..n * n).map(|p| wave(k, p / n) * wave(l, p % n)).collect();
    let eigenvalue = 0.5 + value(k) + value(l);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    for ordering in [Ordering::MinimumDegree, Ordering::Given(&order)] {
        let factor = Cholesky::new(Symbolic::new(&graph, ordering).unwrap().into(), &matrix).unwrap();
        let x = factor.solve(&vector).unwrap();
        for (x, v) in x.iter().zip(&vector) {
            assert!((x * eigenvalue - v).abs() < 1e-13);
        }
        assert!(factor.relative_residual(&x, &vector) < 1e-14);
    }
}

#[test]
fn hermitian_matrix_with_repeated_pairs() {
    let (mut graph, real, positions) = grid(17, 0.1);
    let n = graph.unknowns;
    let mut matrix = SymmetricMatrix { diagonal: real.diagonal, off_diagonal: Vec::new() };
    // Unit phases keep the matrix diagonally dominant. Every pair is given in two halves, one of
    // them transposed.
    let pairs = std::mem::take(&mut graph.pairs);
    for (k, [i, j]) in pairs.into_iter().enumerate() {
        let value = Complex { re: noise(k).cos(), im: noise(k).sin() }.scale(-0.5);
        graph.pairs.extend([[i, j], [j, i]]);
        matrix.off_diagonal.extend([value, value.conj()]);
    }
    let x: Vec<Complex> = (0..n).map(|i| Complex { re: noise(i), im: noise(i + n) }).collect();
    let b = product(&graph, &matrix, &x);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let symbolic = Symbolic::new(&graph, Ordering::Given(&order)).unwrap();
    let factor = Cholesky::new(symbolic.into(), &matrix).unwrap();
    let solution = factor.solve(&b).unwrap();
    for (a, b) in solution.iter().zip(&x) {
        assert!((*a - *b).max_part() < 1e-12);
    }
    assert!(factor.relative_residual(&solution, &b) < 1e-14);
}

#[test]
fn large_fronts_use_the_blocked_kernels() {
    // A dense matrix is one supernode of many columns. With 1 off the diagonal and n + 1 on it, its
    // inverse is known.
    let n = 150;
    let pairs: Vec<[u32; 2]> = (0..n).flat_map(|i| (0..i).map(move |j| [i, j])).collect();
    let matrix =
        SymmetricMatrix { diagonal: vec![n as f64 + 1.0; n as usize], off_diagonal: vec![1.0; pairs.len()] };
    let graph = Graph { unknowns: n as usize, pairs };
    let factor =
        Cholesky::new(Symbolic::new(&graph, Ordering::MinimumDegree).unwrap().into(), &matrix).unwrap();
    let x = factor.solve(&vec![2.0 * n as f64; n as usize]).unwrap();
    assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-14), "{:?}", &x[..3]);
}

#[test]
fn dissection_does_not_depend_on_the_numbering() {
    let n = 60;
    let (graph, _, positions) = grid(n, 1.0);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let entries =
        |graph: &Graph, order: &[u32]| Symbolic::new(graph, Ordering::Given(order)).unwrap().factor_entries();
    // Renumber by a stride coprime to n^2.
    let renumber = |i: u32| (u64::from(i) * 1_009 % (n * n) as u64) as u32;
    let shuffled =
        Graph { unknowns: graph.unknowns, pairs: graph.pairs.iter().map(|p| p.map(renumber)).collect() };
    let mut moved = vec![[0.0; 3]; n * n];
    for (i, p) in positions.iter().enumerate() {
        moved[renumber(i as u32) as usize] = *p;
    }
    let other = nested_dissection_order(&shuffled, &moved, 1).unwrap();
    let (a, b) = (entries(&graph, &order), entries(&shuffled, &other));
    assert!(a.abs_diff(b) * 50 < a, "{a} and {b} entries");
    // George's bound for nested dissection of a square grid: (31/4) n^2 log2 n; the natural order
    // has n^3.
    assert!((a as f64) < 7.75 * (n * n) as f64 * (n as f64).log2(), "{a} entries");
}

#[test]
fn tiny_solutions_keep_their_relative_accuracy() {
    // A chain with strong decay: x_i = q^i with q + 1/q = diagonal. The squares of the values are
    // far below the smallest normal number.
    let (n, q) = (120, 0.1f64);
    let graph = Graph { unknowns: n, pairs: (1..n as u32).map(|i| [i - 1, i]).collect() };
    let matrix = SymmetricMatrix { diagonal: vec![q + 1.0 / q; n], off_diagonal: vec![-1.0; n - 1] };
    let factor =
        Cholesky::new(Symbolic::new(&graph, Ordering::MinimumDegree).unwrap().into(), &matrix).unwrap();
    let mut b = vec![0.0; n];
    b[0] = 1.0;
    let x = factor.solve(&b).unwrap();
    for i in 0..n - 20 {
        assert!((x[i + 1] / x[i] - q).abs() < 1e-12, "at {i}: {} {}", x[i], x[i + 1]);
    }
    assert!(x[99] > 0.0 && x[99] < 1e-98);
}

#[test]
fn errors_name_the_unknown() {
    let (graph, mut matrix, _) = grid(5, 1.0);
    let symbolic = std::sync::Arc::new(Symbolic::new(&graph, Ordering::MinimumDegree).unwrap());
    let good = Cholesky::new(symbolic.clone(), &matrix).unwrap();
    let mut b = vec![0.0; 25];
    b[13] = f64::NAN;
    assert_eq!(good.solve(&b), Err(NumericError::NonFinite { what: "the right-hand side", unknown: 13 }));
    assert_eq!(good.solve(&b[..3]), Err(NumericError::WrongLength { found: 3, expected: 25 }));
    matrix.diagonal[7] = -4.0;
    assert_eq!(
        Cholesky::new(symbolic.clone(), &matrix).unwrap_err(),
        NumericError::NonPositivePivot { unknown: 7 }
    );
    matrix.diagonal[7] = f64::INFINITY;
    let error = Cholesky::new(symbolic, &matrix).unwrap_err();
    assert_eq!(error, NumericError::NonFinite { what: "a matrix entry", unknown: 7 });
    assert_eq!(
        Symbolic::new(&graph, Ordering::Given(&[0; 25])).unwrap_err(),
        NumericError::NotAnOrder { unknown: 0 }
    );
}

#[test]
fn empty_and_disconnected_systems() {
    let none = Graph { unknowns: 0, pairs: Vec::new() };
    let factor = Cholesky::<f64>::new(
        Symbolic::new(&none, Ordering::MinimumDegree).unwrap().into(),
        &SymmetricMatrix::default(),
    )
    .unwrap();
    assert_eq!(factor.solve(&[]).unwrap(), Vec::<f64>::new());
    let apart = Graph { unknowns: 3, pairs: vec![[2, 0]] };
    let matrix = SymmetricMatrix { diagonal: vec![2.0, 5.0, 2.0], off_diagonal: vec![1.0] };
    let order = nested_dissection_order(&apart, &[[0.0; 3]; 3], 1).unwrap();
    let symbolic = Symbolic::new(&apart, Ordering::Given(&order)).unwrap();
    let x = Cholesky::new(symbolic.into(), &matrix).unwrap().solve(&[3.0, 10.0, 3.0]).unwrap();
    assert!(x.iter().zip([1.0, 2.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{x:?}");
}

#[test]
fn solve_where_agrees_with_solve() {
    let n = 60;
    let (graph, matrix, positions) = grid(n, 0.3);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let symbolic = Symbolic::new(&graph, Ordering::Given(&order)).unwrap();
    let factor = Cholesky::new(symbolic.into(), &matrix).unwrap();
    let mut rhs = vec![0.0; n * n];
    rhs[5 * n + 7] = 1.0;
    let whole = factor.solve(&rhs).unwrap();
    let wanted = |unknown: usize| unknown / n < 9;
    let part = factor.solve_where(&rhs, wanted).unwrap();
    for (unknown, (&x, &y)) in part.iter().zip(&whole).enumerate() {
        assert!(x == y || !wanted(unknown) && x == 0.0, "unknown {unknown}: {x} instead of {y}");
    }
    assert!(part.iter().filter(|&&x| x == 0.0).count() > n * n / 2, "most of the factor is skipped");
    let none = factor.solve_where(&rhs, |_| false).unwrap();
    assert!(none.iter().all(|&x| x == 0.0));
}

#[test]
fn half_solutions_give_entries_of_the_inverse_and_solutions() {
    let n = 40;
    let (graph, matrix, positions) = grid(n, 0.3);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let symbolic = Symbolic::new(&graph, Ordering::Given(&order)).unwrap();
    let factor = Cholesky::new(symbolic.into(), &matrix).unwrap();
    let sparse: Vec<Vec<(usize, f64)>> =
        (0..21).map(|i| vec![(i * 76, 1.0), ((i * 397 + 5) % (n * n), -0.5)]).collect();
    let rhs: Vec<&[(usize, f64)]> = sparse.iter().map(Vec::as_slice).collect();
    let halves = factor.half_solve_sparse(&rhs).unwrap();
    let dense = |entries: &[(usize, f64)]| {
        let mut dense = vec![0.0; n * n];
        entries.iter().for_each(|&(i, x)| dense[i] += x);
        dense
    };
    for (entries, half) in sparse.iter().zip(&halves) {
        let x = factor.solve(&dense(entries)).unwrap();
        assert_eq!(factor.complete(half).unwrap(), x, "the sweeps are the same");
        assert!(half.len() < n * n / 2, "{} values are kept", half.len());
        for (other, other_half) in sparse.iter().zip(&halves) {
            let expected: f64 = other.iter().map(|&(i, c)| c * x[i]).sum();
            let found = half.dot(other_half);
            assert!((found - expected).abs() < 1e-14, "{found} instead of {expected}");
        }
    }
    let rhs: Vec<f64> = (0..n * n).map(|i| (i as f64).sin()).collect();
    let mut half = factor.half_solve(&rhs).unwrap();
    assert_eq!(factor.complete(&half).unwrap(), factor.solve(&rhs).unwrap());
    half.add(2.0, &halves[3]);
    let sum: Vec<f64> = rhs.iter().zip(dense(&sparse[3])).map(|(a, b)| a + 2.0 * b).collect();
    let expected = factor.solve(&sum).unwrap();
    assert!(factor.complete(&half).unwrap().iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-13));
    let missing: &[(usize, f64)] = &[(n * n, 1.0)];
    let fault = NumericError::WrongLength { found: n * n + 1, expected: n * n };
    assert_eq!(factor.half_solve_sparse(&[missing]).unwrap_err(), fault);
    assert_eq!(factor.complete(&Default::default()).unwrap(), vec![0.0; n * n]);
}

#[test]
fn solve_many_equals_solve_bit_for_bit() {
    let (graph, matrix, positions) = grid(30, 0.2);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let symbolic = Symbolic::new(&graph, Ordering::Given(&order)).unwrap();
    let factor = Cholesky::new(symbolic.into(), &matrix).unwrap();
    let column = |c: usize| (0..graph.unknowns).map(|i| noise(i + 1000 * c)).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> = (0..5).map(column).collect();
    let solutions = factor.solve_many(&columns).unwrap();
    assert_eq!(solutions.len(), 5);
    for (solution, column) in solutions.iter().zip(&columns) {
        assert_eq!(*solution, factor.solve(column).unwrap());
    }
    assert!(factor.solve_many(&[[0.0; 3]]).is_err());
}

/// Factors dense matrices of every small size, to cover all tails of the blocked kernels.
#[test]
fn dense_matrices_of_all_small_sizes() {
    fn check<T: Scalar>(n: usize, value: impl Fn(usize) -> T) {
        let pairs: Vec<[u32; 2]> = (0..n as u32).flat_map(|j| (0..j).map(move |i| [j, i])).collect();
        let matrix = SymmetricMatrix {
            diagonal: vec![n as f64; n],
            off_diagonal: (0..pairs.len()).map(value).collect(),
        };
        let graph = Graph { unknowns: n, pairs };
        let factor =
            Cholesky::new(Symbolic::new(&graph, Ordering::MinimumDegree).unwrap().into(), &matrix).unwrap();
        let x: Vec<T> = (0..n)
            .map(|i| T::real(noise(i)) + matrix.off_diagonal.first().copied().unwrap_or_default())
            .collect();
        let found = factor.solve(&product(&graph, &matrix, &x)).unwrap();
        for (x, y) in x.iter().zip(&found) {
            assert!((*x - *y).abs_sq().sqrt() < 1e-13, "size {n}: {x:?} {y:?}");
        }
    }
    for n in 1..80 {
        check(n, noise);
        check(n, |k| Complex { re: noise(2 * k), im: noise(2 * k + 1) }.scale(0.7));
    }
}

/// Positions affect the size of the factor only, and neither outliers nor coincident positions
/// spoil it.
#[test]
fn factor_size_does_not_depend_on_scale_or_outliers() {
    let n = 120;
    let (graph, _, positions) = grid(n, 0.1);
    let entries = |graph: &Graph, positions: &[[f64; 3]]| {
        let order = nested_dissection_order(graph, positions, 1).unwrap();
        Symbolic::new(graph, Ordering::Given(&order)).unwrap().factor_entries()
    };
    let plain = entries(&graph, &positions);
    let placed = |scale: f64, move_by: f64| -> Vec<[f64; 3]> {
        positions.iter().map(|p| p.map(|x| scale * x + move_by)).collect()
    };
    for (scale, move_by) in [(1e-300, 0.0), (1e300, -1e302), (1.0, 1e9), (1e-3, 1e6)] {
        let found = entries(&graph, &placed(scale, move_by));
        assert!(found.abs_diff(plain) < plain / 100, "{scale}, {move_by}: {found} and {plain}");
    }
    // One isolated unknown far away; then ten, at decreasing distances.
    for far in [vec![-1e9], vec![1e300], (0..10).map(|k| 10f64.powi(30 - 3 * k)).collect()] {
        let with = Graph { unknowns: n * n + far.len(), pairs: graph.pairs.clone() };
        let mut all = positions.clone();
        all.extend(far.iter().map(|&x| [x; 3]));
        let found = entries(&with, &all);
        assert!(found.abs_diff(plain) < plain / 100, "{far:?}: {found} and {plain}");
    }
    // Part of the grid, or all of it, at one position: breadth-first levels are wider than planes.
    let squeezed: Vec<[f64; 3]> = positions.iter().map(|p| if p[0] < 60.0 { [0.0; 3] } else { *p }).collect();
    for positions in [squeezed, vec![[3.0; 3]; n * n], vec![[f64::NAN; 3]; n * n]] {
        let found = entries(&graph, &positions);
        assert!(found < 2 * plain, "{found} and {plain}");
    }
}

#[test]
fn invalid_pairs_are_rejected() {
    for pair in [[0, 3], [7, 1], [2, 2]] {
        let graph = Graph { unknowns: 3, pairs: vec![[0, 1], pair] };
        let fault = NumericError::NotAPair { contribution: 1, pair, unknowns: 3 };
        assert_eq!(Symbolic::new(&graph, Ordering::MinimumDegree).unwrap_err(), fault);
        assert_eq!(nested_dissection_order(&graph, &[[0.0; 3]; 3], 1).unwrap_err(), fault);
    }
}

/// A hub with two rings of many unknowns, whose triangles are far longer than wide: planes across
/// them cut off whole rings.
#[test]
fn hubs_and_thin_triangles_have_little_fill_in() {
    let n = 4000;
    let around = |i: usize, r: f64| {
        let a = std::f64::consts::TAU * i as f64 / n as f64;
        [r * a.cos(), r * a.sin(), 0.0]
    };
    let rings = [1.0, 2.0].into_iter().flat_map(|r| (0..n).map(move |i| around(i, r)));
    let positions: Vec<[f64; 3]> = std::iter::once([0.0; 3]).chain(rings).collect();
    let mut pairs = Vec::new();
    for i in 0..n as u32 {
        let next = (i + 1) % n as u32;
        let (a, b, c, d) = (1 + i, 1 + next, 1 + n as u32 + i, 1 + n as u32 + next);
        pairs.extend([[0, a], [a, b], [a, c], [a, d], [c, d]]);
    }
    let graph = Graph { unknowns: positions.len(), pairs };
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let [dissected, least] = [Ordering::Given(&order), Ordering::MinimumDegree]
        .map(|ordering| Symbolic::new(&graph, ordering).unwrap().factor_entries());
    assert!(2 * dissected < 3 * least, "{dissected} entries, minimum degree has {least}");
}

/// Unknowns coupled to all others within three steps: a plane cuts more of them than on a mesh, and
/// a breadth-first level still more. Planes must be used, recomputed for each piece.
#[test]
fn wide_neighbourhoods_are_cut_by_planes() {
    let (nx, ny) = (70i32, 50i32);
    let mut pairs = Vec::new();
    for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
        let ahead = (-3..=3).flat_map(|b| (0..=3).map(move |a| (a, b))).filter(|&(a, b)| a > 0 || b > 0);
        let inside = ahead.map(|(a, b)| (i + a, j + b)).filter(|&(i, j)| i < nx && (0..ny).contains(&j));
        pairs.extend(inside.map(|(k, l)| [(i * ny + j) as u32, (k * ny + l) as u32]));
    }
    let graph = Graph { unknowns: (nx * ny) as usize, pairs };
    let positions: Vec<[f64; 3]> =
        (0..nx * ny).map(|n| [f64::from(n / ny), f64::from(n % ny), 0.0]).collect();
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let [dissected, least] = [Ordering::Given(&order), Ordering::MinimumDegree]
        .map(|ordering| Symbolic::new(&graph, ordering).unwrap().factor_entries());
    assert!(20 * dissected < 19 * least, "{dissected} entries, minimum degree has {least}");
}

/// Random positive definite system on a grid, large enough for several subtrees.
fn random_grid<T: Scalar>(n: usize, value: impl Fn(usize) -> T) -> (Graph, SymmetricMatrix<T>) {
    let (graph, _, _) = grid(n, 1.0);
    let off_diagonal: Vec<T> = (0..graph.pairs.len()).map(value).collect();
    let mut diagonal: Vec<f64> = (0..n * n).map(|i| 0.1 + noise(i).abs()).collect();
    for (pair, value) in graph.pairs.iter().zip(&off_diagonal) {
        pair.iter().for_each(|&i| diagonal[i as usize] += value.abs_sq().sqrt());
    }
    (graph, SymmetricMatrix { diagonal, off_diagonal })
}

fn same_digits_on_threads<T: Scalar>(value: impl Fn(usize) -> T) {
    let n = 200;
    let (graph, matrix) = random_grid(n, &value);
    let (_, _, positions) = grid(n, 1.0);
    let order = nested_dissection_order(&graph, &positions, 1).unwrap();
    let symbolic: std::sync::Arc<_> = Symbolic::new(&graph, Ordering::Given(&order)).unwrap().into();
    let rhs: Vec<T> = (0..n * n).map(value).collect();
    let expected = Cholesky::new(symbolic.clone(), &matrix).unwrap().solve(&rhs).unwrap();
    for threads in [2, 3, 8, 100] {
        let factor = Cholesky::on_threads(symbolic.clone(), &matrix, threads).unwrap();
        assert!(factor.solve(&rhs).unwrap() == expected, "{threads} threads");
        for count in [0, 1, 2, 8, 13] {
            let solutions = factor.solve_many(&vec![&rhs; count]).unwrap();
            assert_eq!(solutions.len(), count);
            assert!(solutions.iter().all(|x| *x == expected), "{count} columns, {threads} threads");
        }
    }
    // Two unknowns that are not positive definite, in different subtrees: always the same one.
    let mut bad = matrix;
    for i in [n * n / 3, 2 * n * n / 3] {
        bad.diagonal[i] = -1.0;
    }
    let expected = Cholesky::new(symbolic.clone(), &bad).unwrap_err();
    for threads in [2, 3, 8] {
        assert_eq!(Cholesky::on_threads(symbolic.clone(), &bad, threads).unwrap_err(), expected);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_digits_and_the_same_failure() {
    same_digits_on_threads(noise);
    same_digits_on_threads(|i| Complex { re: noise(2 * i), im: noise(2 * i + 1) });
}

/// The positions lead through all of the dissection: planes, a far outlier, one place for all.
#[test]
fn any_number_of_threads_gives_the_same_order() {
    let n = 200;
    let (graph, _, positions) = grid(n, 1.0);
    let mut outlier = positions.clone();
    outlier[n * n / 2] = [1e9, 0.0, -1e9];
    for positions in [positions, outlier, vec![[0.0; 3]; n * n]] {
        let expected = nested_dissection_order(&graph, &positions, 1).unwrap();
        for threads in [2, 3, 8, 100] {
            assert!(nested_dissection_order(&graph, &positions, threads).unwrap() == expected);
        }
    }
}

/// The backend also has functions that take their number of threads from a setting of the process;
/// with the setting disabled, they panic.
#[test]
fn nothing_depends_on_the_global_parallelism_of_the_backend() {
    let n = 200;
    let (graph, matrix) = random_grid(n, noise);
    let rhs: Vec<f64> = (0..n * n).map(noise).collect();
    let solution = || {
        let symbolic = Symbolic::new(&graph, Ordering::MinimumDegree).unwrap();
        let factor = Cholesky::on_threads(symbolic.into(), &matrix, 2).unwrap();
        (factor.symbolic().factor_entries(), factor.solve_many(&[&rhs, &rhs]).unwrap())
    };
    let expected = solution();
    faer::disable_global_parallelism();
    assert!(solution() == expected);
}
