//! Cases of the study: broken curves with known truth.
//!
//! A curve is a level set of a slowly varying function at a random level. The truth is the exact
//! distance to the undamaged curve, to the given curve itself if that is closed, or to the outline
//! of the union if closed curves cross. For nested curves it is determined up to a constant, since
//! any of them can be the zero.

use crate::breaking::{Damage, Whole};
use crate::surfaces;
use crate::truth::{Error, Fine, error, vertex_areas};
use eikona::geometry::{lay_out, mean_edge_length};
use eikona::mesh::random::Random;
use eikona::mesh::{SurfaceCurves, TriangleMesh};

pub const DAMAGES: [Damage; 25] = [
    Damage::None,
    Damage::Noise(0.1),
    Damage::Noise(0.3),
    Damage::Noise(1.0),
    Damage::EdgeWalk(None),
    Damage::NestedWhole(0.2),
    Damage::Crossing(0.3),
    Damage::OneGap(0.02),
    Damage::OneGap(0.1),
    Damage::OneGap(0.4),
    Damage::Halved(4.0),
    Damage::Halved(10.0),
    Damage::Halved(20.0),
    Damage::EdgeWalk(Some(8.0)),
    Damage::HalvedNoise(8.0, 0.3),
    Damage::HalvedNoise(8.0, 1.0),
    Damage::Displaced(6.0, 0.5),
    Damage::Displaced(10.0, 1.0),
    Damage::WithOffset(8.0, 1.5),
    Damage::WithOffsets(8.0, 1.0),
    Damage::WithOffsets(8.0, 2.0),
    Damage::WithOffsets(8.0, 4.0),
    Damage::WalkAndStrips(8.0, 2),
    Damage::Outliers(6.0, 5.0),
    Damage::Nested(8.0, 0.2),
];

/// Arguments of the command: number of functions on each surface, seed, and part of the names of
/// the surfaces.
pub struct Arguments {
    pub functions: usize,
    pub seed: u64,
    only: String,
}

impl Arguments {
    /// Reads the command line; `functions` is the default number.
    pub fn read(functions: usize) -> Arguments {
        let mut words = std::env::args().skip(1);
        Arguments {
            functions: words.next().map_or(functions, |word| {
                word.parse().expect("the first argument must be the number of functions")
            }),
            seed: words.next().map_or(0, |word| word.parse().expect("the second argument must be a seed")),
            only: words.next().unwrap_or_default(),
        }
    }

    /// Returns the surfaces that were asked for, with their names.
    pub fn surfaces(&self) -> Vec<(String, TriangleMesh)> {
        surfaces::surfaces().into_iter().filter(|(name, _)| name.contains(&self.only)).collect()
    }
}

/// A broken curve and its truth.
pub struct Case<'a> {
    /// Index of the damage in [`DAMAGES`].
    pub damage: usize,
    pub source: SurfaceCurves,
    truth: Vec<f64>,
    areas: &'a [f64],
}

impl Case<'_> {
    /// Returns the error of vertex values that should be the distance to the undamaged curve.
    pub fn error(&self, found: &[f64]) -> Error {
        let up_to_constant = matches!(DAMAGES[self.damage], Damage::Nested(..) | Damage::NestedWhole(..));
        error(self.areas, &self.truth, found, up_to_constant)
    }
}

/// Visits the curves of a surface: one per function and kind of damage, unless it has no truth.
pub fn visit_cases(mesh: &TriangleMesh, arguments: &Arguments, mut visit: impl FnMut(&Case)) {
    let edge = mean_edge_length(mesh, &lay_out(mesh));
    let areas = vertex_areas(mesh);
    let fine = Fine::new(mesh);
    for (k, (_, function)) in surfaces::eigenfunctions(mesh, arguments.functions).iter().enumerate() {
        let mut random = Random::from_seed(arguments.seed + k as u64);
        let mut sorted = function.clone();
        sorted.sort_by(f64::total_cmp);
        let share = random.range(0.2, 0.8);
        // Slightly off the values at vertices.
        let level = sorted[(share * sorted.len() as f64) as usize] + 1e-9;
        let distance = fine.distance(function, level);
        let whole = Whole { mesh, distance: &distance, edge };
        for (damage, kind) in DAMAGES.into_iter().enumerate() {
            let mut same = random.clone();
            let curves = whole.damaged(kind, &mut random);
            if curves.is_empty() {
                continue;
            }
            let source = SurfaceCurves { curves, points: Vec::new() };
            let own = match whole.union(kind, &mut same.clone()) {
                Some(union) => Some(fine.distance(&union, 0.0)),
                None => whole.side(kind, &mut same).map(|side| fine.distance_to_curves(mesh, &source, &side)),
            };
            let truth = own.unwrap_or_else(|| distance.clone());
            // Crossing curves around regions that together cover the surface outline nothing.
            if truth.iter().any(|distance| !distance.is_finite()) {
                continue;
            }
            visit(&Case { damage, source, truth, areas: &areas });
        }
    }
}

/// Errors of one method on several curves.
#[derive(Clone, Default)]
pub struct Errors(pub Vec<Error>);

impl Errors {
    /// Returns the mean in percent.
    pub fn mean(&self, of: fn(&Error) -> f64) -> f64 {
        100.0 * self.0.iter().map(of).sum::<f64>() / self.0.len() as f64
    }

    /// Returns the largest in percent.
    pub fn worst(&self, of: fn(&Error) -> f64) -> f64 {
        100.0 * self.0.iter().map(of).fold(0.0, f64::max)
    }
}
