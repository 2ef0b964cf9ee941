//! Instances of `minimise_jumps`: graphs dual to triangulated tori, with curves on them.

use eikona_numeric::JumpTerm;
use std::collections::HashSet;

/// Deterministic pseudorandom sequence in [0, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
    /// Returns a number in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.next() - 1.0
    }
}

/// Number of nodes, and the terms.
pub type Instance = (usize, Vec<JumpTerm>);

/// Effect of curves on the edges along them.
#[derive(Clone, Copy)]
pub struct Curves {
    /// Jump across a meridian and across a longitude: 1 for closed curves, less for broken curves,
    /// which jump by their periods.
    pub periods: [f64; 2],
    /// Share of missing edges of the curves.
    pub broken: f64,
    /// Weight of an edge on a curve, relative to others.
    pub epsilon: f64,
}

/// Graph dual to a jittered `nu` by `nv` torus grid with random diagonals, with edge lengths as
/// weights and a meridian, a longitude and a disk as curves. Face `2 c` of cell `c` is adjacent to
/// its lower edge, face `2 c + 1` to its upper edge.
pub fn torus(nu: usize, nv: usize, curves: Curves, seed: u64) -> Instance {
    let mut noise = Noise(seed);
    let tau = std::f64::consts::TAU;
    let positions: Vec<[f64; 3]> = (0..nu * nv)
        .map(|c| {
            let u = tau * ((c / nv) as f64 + 0.3 * noise.signed()) / nu as f64;
            let v = tau * ((c % nv) as f64 + 0.3 * noise.signed()) / nv as f64;
            let r = 1.0 + 0.4 * v.cos();
            [r * u.cos(), r * u.sin(), 0.4 * v.sin()]
        })
        .collect();
    let vertex = |i: usize, j: usize| (i % nu) * nv + j % nv;
    let length = |a: usize, b: usize| {
        let d: f64 = (0..3).map(|k| (positions[a][k] - positions[b][k]).powi(2)).sum();
        d.sqrt()
    };
    // Whether the diagonal leads up (from corner i, j) or down; then the faces left and right of
    // it.
    let up: Vec<bool> = (0..nu * nv).map(|_| noise.next() < 0.5).collect();
    let cell = |i: usize, j: usize| (i % nu) * nv + j % nv;
    let left = |c: usize| 2 * c as u32 + u32::from(up[c]);
    let right = |c: usize| 2 * c as u32 + u32::from(!up[c]);
    let (low, high) = (|c: usize| 2 * c as u32, |c: usize| 2 * c as u32 + 1);
    let (at_i, at_j) = (nu / 3, nv / 4);
    let disk = |i: usize, j: usize| {
        let (x, y) = (i as f64 - 0.7 * nu as f64, j as f64 - 0.6 * nv as f64);
        (x / (0.15 * nu as f64)).powi(2) + (y / (0.2 * nv as f64)).powi(2) < 1.0
    };
    let mut terms = Vec::with_capacity(3 * nu * nv);
    let mut gap = Gaps { noise: Noise(seed ^ 0xABCD), broken: curves.broken, left: 0, missing: false };
    let mut add = |from: u32, to: u32, w: f64, shift: f64, gamma: f64, gap: &mut Gaps| {
        let (from, to, shift) = if gamma < 0.0 { (to, from, -shift) } else { (from, to, shift) };
        let key = terms.len() as u64;
        let boxed = gamma != 0.0 && !gap.missing();
        terms.push(JumpTerm {
            from,
            to,
            shift,
            weight: if boxed { curves.epsilon * w } else { w },
            limit: boxed.then_some(gamma.abs()),
            key,
        });
    };
    for i in 0..nu {
        for j in 0..nv {
            let c = cell(i, j);
            let diagonal = if up[c] {
                length(vertex(i, j), vertex(i + 1, j + 1))
            } else {
                length(vertex(i + 1, j), vertex(i, j + 1))
            };
            add(low(c), high(c), diagonal, 0.0, 0.0, &mut gap);
            let inside = |c: usize| f64::from(u8::from(disk(c / nv, c % nv)));
            // Across the edge between this cell and the next in direction i, and in direction j.
            let d = cell(i + 1, j);
            let on = f64::from(u8::from(i == at_i));
            let gamma = on + inside(c) - inside(d);
            let w = length(vertex(i + 1, j), vertex(i + 1, j + 1));
            add(right(c), left(d), w, on * curves.periods[0], gamma, &mut gap);
            let d = cell(i, j + 1);
            let on = f64::from(u8::from(j == at_j));
            let gamma = on + inside(c) - inside(d);
            let w = length(vertex(i, j + 1), vertex(i + 1, j + 1));
            add(high(c), low(d), w, on * curves.periods[1], gamma, &mut gap);
        }
    }
    (2 * nu * nv, terms)
}

/// Removes runs of a few edges from curves.
struct Gaps {
    noise: Noise,
    broken: f64,
    left: usize,
    missing: bool,
}

impl Gaps {
    fn missing(&mut self) -> bool {
        if self.left == 0 {
            self.missing = self.noise.next() < self.broken;
            self.left = 2 + self.noise.below(12);
        }
        self.left -= 1;
        self.missing
    }
}

/// Closed curves.
pub const CLOSED: Curves = Curves { periods: [1.0, 1.0], broken: 0.0, epsilon: 1e-2 };
/// Broken curves.
pub const BROKEN: Curves = Curves { periods: [0.7311, 0.8173], broken: 0.25, epsilon: 1e-2 };

/// Replaces all shifts by noise and removes the curves.
pub fn noisy(instance: Instance, seed: u64) -> Instance {
    let mut noise = Noise(seed);
    let (nodes, mut terms) = instance;
    for term in &mut terms {
        term.shift = 0.3 * noise.signed() + if noise.next() < 0.05 { 1.0 } else { 0.0 };
        term.weight *= (-3.0 * noise.next()).exp();
        term.limit = None;
    }
    (nodes, terms)
}

/// As `noisy`, with shifts rounded to multiples of `1 / steps`.
pub fn stepped(instance: Instance, steps: f64, seed: u64) -> Instance {
    let (nodes, mut terms) = noisy(instance, seed);
    for term in &mut terms {
        term.shift = (term.shift * steps).round() / steps;
    }
    (nodes, terms)
}

/// Two tori, joined at a square hole in each.
pub fn double_torus(nu: usize, nv: usize, curves: [Curves; 2], seed: u64) -> Instance {
    let parts = [torus(nu, nv, curves[0], seed), torus(nu, nv, curves[1], seed + 1)];
    let cells = 2 * nu * nv;
    let hole = |v: u32| {
        let c = v as usize / 2;
        let (i, j) = (c / nv, c % nv);
        (3 * nu / 8..nu / 2).contains(&i) && (nv / 2..3 * nv / 4).contains(&j)
    };
    let mut terms = Vec::new();
    let mut rims: Vec<Vec<(u32, f64)>> = Vec::new();
    for (k, (_, part)) in parts.iter().enumerate() {
        let mut rim = Vec::new();
        for term in part {
            let ends = [hole(term.from), hole(term.to)];
            let up = |v: u32| v + (k * cells) as u32;
            match ends {
                [false, false] => terms.push(JumpTerm {
                    from: up(term.from),
                    to: up(term.to),
                    key: terms.len() as u64,
                    ..*term
                }),
                [true, false] => rim.push((up(term.to), term.weight)),
                [false, true] => rim.push((up(term.from), term.weight)),
                _ => {}
            }
        }
        rims.push(rim);
    }
    for (a, b) in rims[0].iter().zip(&rims[1]) {
        let key = terms.len() as u64;
        terms.push(JumpTerm { from: a.0, to: b.0, shift: 0.0, weight: a.1.min(b.1), limit: None, key });
    }
    (2 * cells, terms)
}

/// Adds a random potential to the shifts, which does not change the attainable jumps.
pub fn gauged(instance: Instance, amount: f64, seed: u64) -> Instance {
    let mut noise = Noise(seed);
    let (nodes, mut terms) = instance;
    let gauge: Vec<f64> = (0..nodes).map(|_| amount * noise.signed()).collect();
    for term in &mut terms {
        term.shift += gauge[term.from as usize] - gauge[term.to as usize];
    }
    (nodes, terms)
}

/// Renumbers nodes and terms at random. Keys stay with their terms.
pub fn shuffled(instance: &Instance, seed: u64) -> Instance {
    let mut noise = Noise(seed);
    let mut shuffle = |n: usize| {
        let mut order: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            order.swap(i, noise.below(i + 1));
        }
        order
    };
    let (nodes, terms) = instance;
    let number = shuffle(*nodes);
    let place = |v: u32| number[v as usize] as u32;
    let terms = shuffle(terms.len())
        .into_iter()
        .map(|e| JumpTerm { from: place(terms[e].from), to: place(terms[e].to), ..terms[e] })
        .collect();
    (*nodes, terms)
}

/// Set of node degrees, to check that a graph is well-formed.
pub fn degrees(instance: &Instance) -> HashSet<usize> {
    let mut degree = vec![0usize; instance.0];
    for term in &instance.1 {
        degree[term.from as usize] += 1;
        degree[term.to as usize] += 1;
    }
    degree.into_iter().collect()
}
