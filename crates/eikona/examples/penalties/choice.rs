//! Choices of level sets and diffusion time, and how each is solved.

use crate::gaps::gaps;
use crate::penalty::{Fits, Nodes, Penalty};
use eikona::geometry::lay_out;
use eikona::mesh::{SurfaceCurves, TriangleMesh};
use eikona::signed_heat::{DiffusionTime, LevelSets, Solution, SolveOptions, Solver, SolverOptions};
use std::collections::BTreeMap;
use std::fmt;

/// Choice of level sets and diffusion time. Unless it says otherwise, the time is the default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    Default,
    /// Level sets of the library, with the default time or a given coefficient.
    LevelSets(LevelSets, Option<f64>),
    /// A penalty after so many reweighted solves, the first of which starts from the free fit.
    Reweighted(Penalty, usize),
    /// The same where the default finds that the curves contradict each other; elsewhere the
    /// default.
    WhereContradicting(Penalty, usize),
    /// The penalty of the default, with weights multiplied by this power of the length of each
    /// curve; the default where that has no penalty.
    DefaultByLength(f64),
    /// [`LevelSets::Soft`], with weights multiplied by the power of the length of each curve.
    SoftByLength {
        weight: f64,
        power: f64,
    },
    /// Diffusion time of this multiple of the squared mean gap, at least the paper's; the default
    /// for curves without gaps.
    TimeByMeanGap(f64),
    /// The same with the median of the gaps.
    TimeByMedianGap(f64),
}

/// Threshold, in mean edge lengths, at which Huber's function stands for the absolute value.
const SMALL: f64 = 0.02;

const fn absolute(force: f64) -> Penalty {
    Penalty::Huber { force, threshold: SMALL }
}

/// Rows of the table; the first is the default.
pub const CHOICES: [Choice; 28] = [
    Choice::Default,
    Choice::LevelSets(LevelSets::Zero, None),
    Choice::LevelSets(LevelSets::Free, None),
    Choice::LevelSets(LevelSets::Soft(10.0), None),
    Choice::LevelSets(LevelSets::Soft(3.0), Some(3.0)),
    Choice::LevelSets(LevelSets::Soft(10.0), Some(3.0)),
    Choice::Reweighted(absolute(0.15), 2),
    Choice::Reweighted(absolute(0.15), 4),
    Choice::Reweighted(absolute(0.15), 8),
    Choice::Reweighted(absolute(0.3), 2),
    Choice::Reweighted(absolute(0.3), 4),
    Choice::Reweighted(absolute(0.3), 8),
    Choice::Reweighted(absolute(1.0), 2),
    Choice::Reweighted(absolute(1.0), 4),
    Choice::Reweighted(absolute(1.0), 8),
    Choice::Reweighted(Penalty::Huber { force: 0.3, threshold: 0.3 }, 8),
    Choice::Reweighted(Penalty::Huber { force: 0.3, threshold: 1.0 }, 8),
    Choice::Reweighted(Penalty::HuberOfCurves { force: 0.3, threshold: SMALL }, 8),
    Choice::WhereContradicting(absolute(0.3), 8),
    Choice::WhereContradicting(Penalty::Huber { force: 0.3, threshold: 1.0 }, 8),
    Choice::DefaultByLength(1.0),
    Choice::DefaultByLength(-1.0),
    Choice::SoftByLength { weight: 10.0, power: 1.0 },
    Choice::SoftByLength { weight: 10.0, power: -1.0 },
    Choice::TimeByMeanGap(0.001),
    Choice::TimeByMeanGap(0.01),
    Choice::TimeByMeanGap(0.1),
    Choice::TimeByMedianGap(0.01),
];

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Choice::Default => write!(f, "default"),
            Choice::LevelSets(level_sets, None) => write!(f, "{level_sets:?}"),
            Choice::LevelSets(level_sets, Some(time)) => write!(f, "{level_sets:?}, time {time}"),
            Choice::Reweighted(penalty, solves) => write!(f, "{penalty}, {solves} solves"),
            Choice::WhereContradicting(penalty, solves) => {
                write!(f, "contradicting: {penalty}, {solves} solves")
            }
            Choice::DefaultByLength(power) => write!(f, "default * length^{power}"),
            Choice::SoftByLength { weight, power } => write!(f, "Soft({weight:?}) * length^{power}"),
            Choice::TimeByMeanGap(share) => write!(f, "time {share} (mean gap)^2"),
            Choice::TimeByMedianGap(share) => write!(f, "time {share} (median gap)^2"),
        }
    }
}

impl fmt::Display for Penalty {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Penalty::Huber { force, threshold: SMALL } => write!(f, "{force:?} |phi|"),
            Penalty::Huber { force, threshold } => write!(f, "{force:?} Huber({threshold:?})"),
            Penalty::HuberOfCurves { force, threshold: SMALL } => write!(f, "{force:?} |rms of curve|"),
            Penalty::HuberOfCurves { force, threshold } => {
                write!(f, "{force:?} Huber({threshold:?}) of rms of curve")
            }
        }
    }
}

/// Solvers for one surface.
pub struct Solvers<'a> {
    mesh: &'a TriangleMesh,
    fits: Fits<'a>,
    /// Square root of the area.
    size: f64,
    automatic: Solver,
    /// Solvers with other diffusion times, see [`Solvers::near`].
    at_time: BTreeMap<i32, Solver>,
}

impl<'a> Solvers<'a> {
    pub fn new(mesh: &'a TriangleMesh) -> Solvers<'a> {
        Solvers {
            mesh,
            fits: Fits::new(mesh),
            size: lay_out(mesh).iter().map(|t| t.area).sum::<f64>().sqrt(),
            automatic: Solver::new(mesh, &SolverOptions::default()).unwrap(),
            at_time: BTreeMap::new(),
        }
    }

    /// Returns a solver whose time coefficient is this one, rounded to a multiple of 1 / 8 in its
    /// logarithm to base 3. Curves with similar gaps thus share a factorization.
    fn near(&mut self, coefficient: f64) -> &Solver {
        let step = (8.0 * coefficient.ln() / 3.0f64.ln()).round();
        let time = DiffusionTime::Coefficient(3.0f64.powf(step / 8.0));
        let make = || Solver::new(self.mesh, &SolverOptions::default().with_time(time)).unwrap();
        self.at_time.entry(step as i32).or_insert_with(make)
    }

    /// Prepares the choices for one source.
    pub fn on<'b>(&'b mut self, source: &'b SurfaceCurves) -> OnSource<'b, 'a> {
        let default = self.automatic.solve(source, &SolveOptions::default()).unwrap();
        OnSource {
            free: distance(&self.automatic, source, LevelSets::Free),
            rhs: self.fits.right_hand_side(default.gradient.as_slice()),
            nodes: Nodes::of(self.mesh, source),
            default,
            reweighted: Vec::new(),
            source,
            solvers: self,
        }
    }
}

fn distance(solver: &Solver, source: &SurfaceCurves, level_sets: LevelSets) -> Vec<f64> {
    let options = SolveOptions::default().with_level_sets(level_sets);
    solver.solve(source, &options).unwrap().distance.into_vec()
}

/// What the choices for one source have in common.
pub struct OnSource<'b, 'a> {
    solvers: &'b mut Solvers<'a>,
    source: &'b SurfaceCurves,
    default: Solution,
    free: Vec<f64>,
    rhs: Vec<f64>,
    nodes: Nodes,
    /// Reweighted fits so far, which later rows continue.
    reweighted: Vec<(Penalty, Vec<Vec<f64>>)>,
}

impl OnSource<'_, '_> {
    /// Returns the distance by a choice.
    pub fn solve(&mut self, choice: Choice) -> Vec<f64> {
        match choice {
            Choice::Default => self.default_distance(),
            Choice::LevelSets(level_sets, None) => distance(&self.solvers.automatic, self.source, level_sets),
            Choice::LevelSets(level_sets, Some(time)) => {
                distance(self.solvers.near(time), self.source, level_sets)
            }
            Choice::Reweighted(penalty, solves) => self.reweighted(penalty, solves),
            Choice::WhereContradicting(penalty, solves) => match self.contradicting() {
                true => self.reweighted(penalty, solves),
                false => self.default_distance(),
            },
            Choice::DefaultByLength(power) => match self.default.report.level_sets.level_sets {
                LevelSets::Soft(weight) => self.soft_by_length(weight, power),
                _ => self.default_distance(),
            },
            Choice::SoftByLength { weight, power } => self.soft_by_length(weight, power),
            Choice::TimeByMeanGap(share) => {
                self.time_by_gap(share, |gaps| gaps.iter().sum::<f64>() / gaps.len() as f64)
            }
            Choice::TimeByMedianGap(share) => self.time_by_gap(share, |gaps| gaps[gaps.len() / 2]),
        }
    }

    /// Returns the difference between the quadratic penalty of this program and the library's,
    /// relative to the largest distance.
    pub fn difference_from_library(&self) -> f64 {
        let ours = self.soft_by_length(10.0, 0.0);
        let library = distance(&self.solvers.automatic, self.source, LevelSets::Soft(10.0));
        let largest = library.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        ours.iter().zip(&library).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / largest
    }

    fn default_distance(&self) -> Vec<f64> {
        self.default.distance.as_slice().to_vec()
    }

    /// Returns whether the default bounds the force of a penalty, rather than holding the curves
    /// firmly.
    fn contradicting(&self) -> bool {
        self.default.report.level_sets.reason.contains("contradict")
    }

    fn soft_by_length(&self, weight: f64, power: f64) -> Vec<f64> {
        let Solvers { fits, size, .. } = &*self.solvers;
        fits.by_length(&self.rhs, &self.nodes, weight / size, power)
    }

    fn reweighted(&mut self, penalty: Penalty, solves: usize) -> Vec<f64> {
        let found = self.reweighted.iter().position(|(of, _)| *of == penalty);
        let index = found.unwrap_or_else(|| {
            self.reweighted.push((penalty, vec![self.free.clone()]));
            self.reweighted.len() - 1
        });
        let fits = &mut self.reweighted[index].1;
        while fits.len() <= solves {
            let before = &fits[fits.len() - 1];
            fits.push(self.solvers.fits.reweighted(&self.rhs, &self.nodes, penalty, before));
        }
        fits[solves].clone()
    }

    fn time_by_gap(&mut self, share: f64, typical: fn(&[f64]) -> f64) -> Vec<f64> {
        let gaps = gaps(self.solvers.mesh, self.source);
        if gaps.is_empty() {
            return self.default_distance();
        }
        let spacing = 0.5 * self.solvers.fits.edge;
        let coefficient = (share * (typical(&gaps) / spacing).powi(2)).max(1.0);
        distance(self.solvers.near(coefficient), self.source, LevelSets::Automatic)
    }
}
