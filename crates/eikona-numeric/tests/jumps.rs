//! Tests `minimise_jumps` against hand-computed optima and an interior-point solver (Clarabel), and
//! its invariance under renumbering and scaling.

mod jump_instances;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT};
use eikona_numeric::{
    InfeasibleCycle, JumpError, JumpMethod, JumpOptions, JumpSolution, JumpTerm, minimise_jumps,
};
use jump_instances::*;

const METHODS: [JumpMethod; 2] = [JumpMethod::NetworkSimplex, JumpMethod::PrimalDual];

fn term(from: u32, to: u32, shift: f64, weight: f64, limit: Option<f64>) -> JumpTerm {
    JumpTerm { from, to, shift, weight, limit, key: 0 }
}

fn with(method: JumpMethod) -> JumpOptions {
    JumpOptions { method: Some(method), perturbation: 0.0, ..JumpOptions::default() }
}

/// Solves, and checks everything that needs no other solver.
fn solved((nodes, terms): &Instance, options: &JumpOptions) -> JumpSolution {
    let solution = minimise_jumps(*nodes, terms, options).unwrap();
    let c = solution.certificate;
    assert!(c.gap.abs() < 1e-9, "{c:?}");
    assert!(c.conservation < 1e-11 && c.overflow < 1e-11 && c.violation < 1e-11, "{c:?}");
    let scale = terms.iter().fold(1e-300f64, |m, t| m.max(t.shift.abs()).max(t.limit.unwrap_or(0.0)));
    for (term, &jump) in terms.iter().zip(&solution.jumps) {
        assert!((jump - term.jump(&solution.potentials)).abs() < 1e-11 * scale);
        assert!(jump == 0.0 || jump.abs() > 1e-9 * scale);
        assert!(term.limit.is_none_or(|limit| (0.0..=limit).contains(&jump)), "{jump} of {term:?}");
    }
    let slack = options.perturbation + 1e-9;
    assert!(solution.lower_bound <= solution.objective * (1.0 + 1e-9) + 1e-12);
    assert!(solution.objective <= solution.lower_bound * (1.0 + slack) + 1e-12 * scale);
    solution
}

/// Optimum by an interior-point method. Unknowns are potentials and absolute values of jumps, with
/// two constraints per term.
fn interior_point_optimum((nodes, terms): &Instance) -> f64 {
    let (n, m) = (*nodes, terms.len());
    // Fix the potential of the first node of each component.
    let mut leader: Vec<usize> = (0..n).collect();
    fn find(leader: &mut [usize], mut v: usize) -> usize {
        while leader[v] != v {
            leader[v] = leader[leader[v]];
            v = leader[v];
        }
        v
    }
    for term in terms {
        let a = find(&mut leader, term.from as usize);
        let b = find(&mut leader, term.to as usize);
        leader[a.max(b)] = a.min(b);
    }
    let fixed: Vec<usize> = (0..n).filter(|&v| leader[v] == v).collect();
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut right = vec![0.0; fixed.len()];
    let mut entry = |row: usize, column: usize, value: f64| {
        rows.push(row);
        columns.push(column);
        values.push(value);
    };
    for (row, &v) in fixed.iter().enumerate() {
        entry(row, v, 1.0);
    }
    let mut cost = vec![0.0; n + m];
    let mut constant = 0.0;
    for (e, term) in terms.iter().enumerate() {
        for (sign, bound) in [(1.0, term.limit.unwrap_or(0.0) - term.shift), (-1.0, term.shift)] {
            let row = right.len();
            right.push(bound);
            if term.from != term.to {
                entry(row, term.from as usize, sign);
                entry(row, term.to as usize, -sign);
            }
            if term.limit.is_none() {
                entry(row, n + e, -1.0);
            }
        }
        if term.limit.is_none() {
            cost[n + e] = term.weight;
        } else {
            constant += term.weight * term.shift;
            cost[term.from as usize] += term.weight;
            cost[term.to as usize] -= term.weight;
        }
    }
    let height = right.len();
    let matrix = CscMatrix::new_from_triplets(height, n + m, rows, columns, values);
    let cones = [ZeroConeT(fixed.len()), NonnegativeConeT(height - fixed.len())];
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        ..DefaultSettings::default()
    };
    let quadratic = CscMatrix::zeros((n + m, n + m));
    let mut solver = DefaultSolver::new(&quadratic, &cost, &matrix, &right, &cones, settings).unwrap();
    solver.solve();
    let status = solver.solution.status;
    assert!(
        matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved),
        "interior-point status {status:?}"
    );
    solver.solution.obj_val + constant
}

#[test]
fn a_cycle_jumps_on_its_cheapest_term() {
    let weights = [3.0, 1.0, 2.0];
    for method in METHODS {
        let terms: Vec<_> = (0..3)
            .map(|k| term(k, (k + 1) % 3, if k == 0 { 1.0 } else { 0.0 }, weights[k as usize], None))
            .collect();
        let solution = solved(&(3, terms.clone()), &with(method));
        assert_eq!(solution.jumps, [0.0, 1.0, 0.0]);
        assert_eq!(solution.objective, 1.0);
        assert_eq!(solution.potentials, [0.0, 1.0, 0.0]);
        assert_eq!(solution.flow, [1.0, 1.0, 1.0]);
        // With a limit on the cheapest term, the next one takes the rest.
        let mut limited = terms;
        limited[1].limit = Some(0.25);
        let solution = solved(&(3, limited), &with(method));
        assert_eq!(solution.jumps, [0.0, 0.25, 0.75]);
        assert_eq!(solution.objective, 0.25 + 2.0 * 0.75);
        // The flow of a term at its limit exceeds its weight by the value of relaxing the limit.
        assert_eq!(solution.flow, [2.0, 2.0, 2.0]);
    }
}

#[test]
fn a_boxed_jump_is_never_negative() {
    for method in METHODS {
        // The jumps add up to -1: the boxed term would be cheapest, but its jump cannot be
        // negative.
        let terms = vec![term(0, 1, -1.0, 5.0, None), term(1, 0, 0.0, 1.0, Some(1.0))];
        let solution = solved(&(2, terms), &with(method));
        assert_eq!(solution.jumps, [-1.0, 0.0]);
    }
}

#[test]
fn trivial_instances() {
    for method in METHODS {
        let empty = solved(&(0, vec![]), &with(method));
        assert_eq!((empty.objective, empty.certificate.gap), (0.0, 0.0));
        let lonely = solved(&(3, vec![]), &with(method));
        assert_eq!(lonely.potentials, [0.0; 3]);
        // Shifts that are potential differences vanish.
        let flat = gauged((4, (0..4).map(|k| term(k, (k + 1) % 4, 0.0, 1.0, None)).collect()), 1.0, 1);
        assert_eq!(solved(&flat, &with(method)).jumps, [0.0; 4]);
        let mut wide = torus(40, 30, CLOSED, 2);
        wide.1.iter_mut().for_each(|t| *t = JumpTerm { shift: 0.0, limit: None, ..*t });
        let solution = solved(&gauged(wide, 1e3, 3), &with(method));
        assert!(solution.jumps.iter().all(|jump| *jump == 0.0));
    }
}

#[test]
fn self_loops_parallel_terms_and_components() {
    for method in METHODS {
        let terms = vec![
            term(0, 0, -0.5, 2.0, None),
            term(0, 0, 0.25, 4.0, Some(0.25)),
            // Three parallel terms: the jump on which the heavier two agree.
            term(0, 2, 1.0, 1.0, None),
            term(0, 2, 2.0, 1.5, None),
            term(2, 0, -2.0, 1.0, None),
            // Another component, with a term of weight 0.
            term(4, 3, 7.0, 1.0, None),
            term(3, 4, 1.0, 0.0, None),
        ];
        let solution = solved(&(5, terms), &with(method));
        assert_eq!(solution.jumps, [-0.5, 0.25, -1.0, 0.0, 0.0, 0.0, 8.0]);
        assert_eq!(solution.objective, 1.0 + 1.0 + 1.0);
        assert_eq!(solution.potentials, [0.0, 0.0, 2.0, 0.0, -7.0]);
    }
}

#[test]
fn terms_of_weight_zero_constrain_by_their_limits() {
    for method in METHODS {
        let mut terms: Vec<_> = (0..6).map(|k| term(k, (k + 1) % 6, 0.0, 0.0, Some(1.0))).collect();
        terms[0].shift = 4.0;
        assert_eq!(solved(&(6, terms.clone()), &with(method)).objective, 0.0);
        terms.push(term(1, 4, 0.0, 1.0, None));
        terms.push(term(2, 5, 3.5, 1.0, None));
        let instance = (6, terms);
        assert!(
            (solved(&instance, &with(method)).objective - interior_point_optimum(&instance)).abs() < 1e-8
        );
    }
}

#[test]
fn errors_name_the_term() {
    let good = term(0, 1, 0.0, 1.0, None);
    let error_for = |bad: JumpTerm| minimise_jumps(2, &[good, bad], &JumpOptions::default()).unwrap_err();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = |what| JumpError::NonFinite { term: 1, what };
        assert_eq!(error_for(JumpTerm { shift: value, ..good }), error("shift"));
        assert_eq!(error_for(JumpTerm { weight: value, ..good }), error("weight"));
        assert_eq!(error_for(JumpTerm { limit: Some(value), ..good }), error("limit"));
    }
    assert_eq!(error_for(term(0, 1, 0.0, -1.0, None)), JumpError::NegativeWeight { term: 1, weight: -1.0 });
    assert_eq!(
        error_for(term(0, 1, 0.0, 1.0, Some(0.0))),
        JumpError::NonPositiveLimit { term: 1, limit: 0.0 }
    );
    assert_eq!(error_for(term(0, 2, 0.0, 1.0, None)), JumpError::NoSuchNode { term: 1, node: 2, nodes: 2 });
    let options = JumpOptions { perturbation: f64::NAN, ..JumpOptions::default() };
    assert!(matches!(minimise_jumps(2, &[good], &options), Err(JumpError::BadPerturbation { .. })));
}

#[test]
fn infeasible_limits_are_reported() {
    for method in METHODS {
        // A ring of boxed terms whose jumps add up to -0.5, with a tail and a free term beside it.
        let mut terms: Vec<_> = (0..5).map(|k| term(k, (k + 1) % 5, 0.0, 1.0, Some(1.0))).collect();
        terms[2].shift = -0.5;
        terms.push(term(5, 2, 0.0, 1.0, Some(1.0)));
        terms.push(term(0, 2, 0.0, 1.0, None));
        let [mut cycle] = infeasible_cycles(6, &terms, &with(method)).try_into().unwrap();
        cycle.terms.sort_unstable();
        assert_eq!(cycle.terms, [0, 1, 2, 3, 4]);
        assert!((cycle.excess - 0.5).abs() < 1e-15);
        // More than the sum of all limits.
        terms[2].shift = 5.25;
        let [cycle] = infeasible_cycles(6, &terms, &with(method)).try_into().unwrap();
        assert_eq!((cycle.terms.len(), cycle.excess), (5, 0.25));
        // Exactly the sum of all limits.
        terms[2].shift = 5.0;
        let jumps = solved(&(6, terms), &with(method)).jumps;
        assert_eq!(jumps[..5], [1.0; 5]);
    }
    let loops: Vec<_> = [0.5, 2.0, -3.0].map(|shift| term(0, 0, shift, 1.0, Some(1.0))).into();
    let named = |e, excess| InfeasibleCycle { terms: vec![e], excess };
    assert_eq!(infeasible_cycles(1, &loops, &JumpOptions::default()), [named(1, 1.0), named(2, 3.0)]);
}

fn infeasible_cycles(nodes: usize, terms: &[JumpTerm], options: &JumpOptions) -> Vec<InfeasibleCycle> {
    match minimise_jumps(nodes, terms, options) {
        Err(JumpError::Infeasible { cycles, .. }) => cycles,
        other => panic!("{other:?}"),
    }
}

/// Rings of 3 to 12 boxed terms, joined by free terms; two of every three rings are infeasible.
#[test]
fn all_infeasible_cycles_are_reported_at_once() {
    const RINGS: u32 = 2000;
    let (mut terms, mut wanted) = (Vec::new(), Vec::new());
    let mut nodes = 0;
    for ring in 0..RINGS {
        let length = 3 + ring % 10;
        let shift = [0.0, -0.5, f64::from(length) + 0.25][ring as usize % 3];
        if ring % 3 > 0 {
            wanted.push((terms.len()..terms.len() + length as usize).collect::<Vec<_>>());
        }
        let at = |k: u32| nodes + k % length;
        terms.extend((0..length).map(|k| {
            let shift = if k == 0 { shift } else { 0.0 };
            term(at(k), at(k + 1), shift, 1.0, Some(1.0))
        }));
        nodes += length;
    }
    // Add these after the rings, so that ring terms keep their indices.
    terms.extend((1..nodes).map(|v| term(v - 1, v, 0.0, 1.0, None)));
    let error = minimise_jumps(nodes as usize, &terms, &JumpOptions::default()).unwrap_err();
    let JumpError::Infeasible { cycles, work } = &error else { panic!("{error}") };
    let mut found: Vec<_> = cycles.iter().map(|cycle| cycle.terms.clone()).collect();
    found.iter_mut().for_each(|terms| terms.sort_unstable());
    found.sort();
    assert_eq!(found, wanted);
    // Each ring is traversed a few times, not once per other ring.
    assert!(*work < 100 * terms.len() as u64, "{work}");
    assert!(error.to_string().len() < 200, "{error}");

    let options = JumpOptions { work_limit: 10_000, ..JumpOptions::default() };
    let error = minimise_jumps(nodes as usize, &terms, &options).unwrap_err();
    assert_eq!(error, JumpError::WorkLimit { work: 10_000 });
}

#[test]
fn all_terms_boxed() {
    for seed in 0..3 {
        // Limits that some hidden potentials satisfy.
        let (nodes, mut terms) = torus(24, 16, CLOSED, seed);
        let mut noise = Noise(seed);
        for term in &mut terms {
            *term = JumpTerm { limit: Some(0.5), shift: 0.5 * noise.next(), ..*term };
        }
        let instance = gauged((nodes, terms), 3.0, seed);
        let objectives = METHODS.map(|method| solved(&instance, &with(method)).objective);
        assert!((objectives[0] - objectives[1]).abs() < 1e-9 * objectives[0]);
        // Make the limits along one line of cells infeasible.
        let (nodes, mut terms) = instance;
        for term in terms.iter_mut().filter(|t| t.key % 48 < 3) {
            term.shift -= 0.6;
        }
        let mut met = vec![false; nodes];
        for InfeasibleCycle { terms: cycle, excess } in
            infeasible_cycles(nodes, &terms, &JumpOptions::default())
        {
            // The terms form a cycle: every node occurs twice, and in no other cycle.
            let mut ends: Vec<u32> = cycle.iter().flat_map(|&e| [terms[e].from, terms[e].to]).collect();
            ends.sort_unstable();
            assert!(excess > 0.0 && ends.chunks(2).all(|pair| pair[0] == pair[1]));
            ends.dedup();
            assert!(ends.iter().all(|&v| !std::mem::replace(&mut met[v as usize], true)));
        }
    }
}

#[test]
fn jumps_far_below_the_largest_count_where_the_optimum_is_small() {
    // A jump of 1 at low cost, and cycles with a jump of 5e-10, which is cheaper on one term.
    let mut terms = vec![term(0, 1, 1.0, 1e-6, Some(1.0)), term(1, 0, 0.0, 1.0, None)];
    for (from, weights) in [(1, [1.0, 2.0]), (2, [2.0, 1.0])] {
        terms.push(term(from, from + 1, 5e-10, weights[0], None));
        terms.push(term(from + 1, from, 0.0, weights[1], None));
    }
    // A ring whose limits are infeasible by a rounding error.
    for (from, to, shift) in [(4, 5, 1.0 + 5e-13), (5, 6, 0.0), (6, 4, 0.0)] {
        terms.push(term(from, to, shift, 1e-6, Some(1.0 / 3.0)));
    }
    for method in METHODS {
        let solution = minimise_jumps(7, &terms, &with(method)).unwrap();
        assert!(solution.certificate.gap.abs() < 1e-9, "{:?}", solution.certificate);
        let third = 1.0 / 3.0;
        for (jump, right) in
            solution.jumps.iter().zip([1.0, 0.0, 5e-10, 0.0, 0.0, 5e-10, third, third, third])
        {
            let error = if right < 1e-9 && right > 0.0 { 1e-14 } else { 0.0 };
            assert!((jump - right).abs() <= error, "{:?}", solution.jumps);
        }
    }
}

/// Curves that cost little and shifts with rounding errors, on slopes with potentials far larger
/// than any shift, as well.
#[test]
fn small_optima_are_certified_despite_rounding_errors() {
    for seed in 0..40 {
        let mut noise = Noise(seed);
        let epsilon = 10f64.powf(-3.0 - 6.0 * noise.next());
        let curves = Curves { periods: [0.2 + 0.8 * noise.next(), noise.next()], broken: 0.0, epsilon };
        let (nu, nv) = if seed % 2 == 0 { (16, 10) } else { (120, 3) };
        let (nodes, mut terms) = torus(nu, nv, curves, seed);
        let slope = if seed % 4 < 2 { 0.0 } else { 0.5 };
        let height = |v: u32| slope * (v as usize / (2 * nv)).abs_diff(nu / 2) as f64;
        for term in &mut terms {
            term.shift += height(term.from) - height(term.to);
        }
        let optimum = minimise_jumps(nodes, &terms, &with(JumpMethod::PrimalDual)).unwrap().objective;
        let rounding = 10f64.powf(-12.0 + 2.0 * noise.next());
        for term in &mut terms {
            term.shift += rounding * noise.signed();
        }
        let most: f64 = terms.iter().map(|term| rounding * term.weight).sum();
        for method in [None, Some(JumpMethod::NetworkSimplex), Some(JumpMethod::PrimalDual)] {
            let options = JumpOptions { method, ..with(JumpMethod::PrimalDual) };
            let solution = minimise_jumps(nodes, &terms, &options).unwrap();
            let c = solution.certificate;
            assert!(c.gap < 1e-6 && c.overflow < 1e-11 && c.violation < 1e-9, "seed {seed}: {c:?}");
            assert!((solution.objective - optimum).abs() < most + 1e-6 * optimum, "seed {seed}");
        }
    }
}

#[test]
fn work_limit_is_respected() {
    let (nodes, terms) = noisy(torus(40, 20, CLOSED, 5), 6);
    for method in METHODS {
        let options = JumpOptions { work_limit: 20_000, ..with(method) };
        let result = minimise_jumps(nodes, &terms, &options);
        assert_eq!(result, Err(JumpError::WorkLimit { work: 20_000 }));
    }
}

/// Random graph with self-loops and parallel terms, some of them boxed with feasible limits.
fn random_graph(seed: u64) -> Instance {
    let mut noise = Noise(seed);
    let nodes = 2 + noise.below(60);
    let hidden: Vec<f64> = (0..nodes).map(|_| noise.signed()).collect();
    let terms = (0..nodes + noise.below(3 * nodes))
        .map(|k| {
            let (from, to) = (noise.below(nodes), noise.below(nodes));
            let boxed = noise.next() < 0.3;
            let limit = 0.1 + noise.next();
            // The hidden potentials satisfy all limits.
            let jump = if boxed { limit * noise.next() } else { noise.signed() };
            JumpTerm {
                from: from as u32,
                to: to as u32,
                shift: jump - hidden[from] + hidden[to],
                weight: if noise.next() < 0.1 { 0.0 } else { noise.next() },
                limit: boxed.then_some(limit),
                key: k as u64,
            }
        })
        .collect();
    (nodes, terms)
}

#[test]
fn both_methods_agree_with_an_interior_point_solver() {
    let mut instances: Vec<(String, Instance)> = Vec::new();
    for seed in 0..60 {
        instances.push((format!("graph {seed}"), random_graph(seed)));
    }
    for seed in 0..12 {
        let (nu, nv) = (8 + 3 * seed as usize % 13, 6 + 5 * seed as usize % 9);
        let broken = Curves { periods: [0.6 + 0.03 * seed as f64, 0.9], broken: 0.3, epsilon: 1e-2 };
        let grid = |curves| torus(nu, nv, curves, seed);
        instances.push((format!("closed {seed}"), grid(CLOSED)));
        instances.push((format!("broken {seed}"), grid(broken)));
        instances.push((format!("gauged {seed}"), gauged(grid(broken), 1.0, seed)));
        instances.push((format!("noisy {seed}"), noisy(grid(CLOSED), seed)));
        instances.push((format!("stepped {seed}"), stepped(grid(CLOSED), 3.0, seed)));
    }
    for seed in 0..4 {
        let other = Curves { periods: [0.4, 0.75], ..BROKEN };
        instances.push((format!("double {seed}"), double_torus(24, 16, [BROKEN, other], seed)));
    }
    assert!(instances.len() > 120);
    for (name, instance) in &instances {
        let reference = interior_point_optimum(instance);
        for method in METHODS {
            let objective = solved(instance, &with(method)).objective;
            // The interior-point tolerance is relative to the data where the optimum is nearly 0.
            let off = (objective - reference).abs() / reference.abs().max(1e-2);
            assert!(off < 1e-8, "{name} by {method:?}: {objective} against {reference}");
        }
    }
}

#[test]
fn integer_shifts_give_integer_jumps() {
    for seed in 0..8 {
        for instance in [torus(30, 14, CLOSED, seed), stepped(torus(30, 14, CLOSED, seed), 1.0, seed)] {
            for method in METHODS {
                let solution = solved(&instance, &with(method));
                assert!(solution.jumps.iter().all(|j| j.fract() == 0.0));
                assert!(solution.potentials.iter().all(|p| p.fract() == 0.0));
                let exact = |(t, j): (&JumpTerm, &f64)| *j == t.jump(&solution.potentials);
                assert!(instance.1.iter().zip(&solution.jumps).all(exact));
            }
        }
    }
}

#[test]
fn perturbed_solutions_do_not_depend_on_numbering_or_method() {
    // Equal weights: without perturbation, countless optima.
    for seed in 0..6 {
        let (nodes, mut terms) = torus(24, 18, BROKEN, seed);
        for (k, term) in terms.iter_mut().enumerate() {
            term.weight = if term.limit.is_some() { 0.01 } else { 1.0 };
            term.key = k as u64;
        }
        let reference = (nodes, terms);
        let mut by_key = vec![0.0; reference.1.len()];
        for (k, jump) in solved(&reference, &JumpOptions::default()).jumps.iter().enumerate() {
            by_key[k] = *jump;
        }
        assert!(by_key.iter().filter(|j| **j != 0.0).count() > 10);
        for method in METHODS {
            let options = JumpOptions { method: Some(method), ..JumpOptions::default() };
            let instance = shuffled(&reference, seed + 100);
            for (term, jump) in instance.1.iter().zip(solved(&instance, &options).jumps) {
                assert!((jump - by_key[term.key as usize]).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn the_same_input_gives_the_same_digits() {
    let instance = torus(40, 20, BROKEN, 3);
    for method in METHODS {
        assert_eq!(solved(&instance, &with(method)), solved(&instance, &with(method)));
    }
}

#[test]
fn solutions_scale_with_units() {
    let (nodes, terms) = torus(20, 14, BROKEN, 9);
    let plain = solved(&(nodes, terms.clone()), &JumpOptions::default());
    for unit in [1e-9, 1e9] {
        let in_unit = |t: &JumpTerm| JumpTerm {
            shift: t.shift * unit,
            limit: t.limit.map(|limit| limit * unit),
            weight: t.weight / unit,
            ..*t
        };
        for method in METHODS {
            let options = JumpOptions { method: Some(method), ..JumpOptions::default() };
            let scaled =
                minimise_jumps(nodes, &terms.iter().map(in_unit).collect::<Vec<_>>(), &options).unwrap();
            assert!((scaled.objective - plain.objective).abs() < 1e-12 * plain.objective);
            assert!(scaled.certificate.gap.abs() < 1e-12);
        }
    }
}

#[test]
fn instances_are_dual_to_closed_surfaces() {
    for instance in [torus(12, 9, BROKEN, 1), double_torus(24, 16, [CLOSED; 2], 1)] {
        let used: Vec<usize> = degrees(&instance).into_iter().filter(|d| *d > 0).collect();
        assert_eq!(used, [3]);
    }
}
