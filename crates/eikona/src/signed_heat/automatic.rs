//! The choice of level sets for a source ([`LevelSets::Automatic`]).
//!
//! Closed curves bound a region, so zero along them is part of their exact distance, unless the
//! free fit shows them at levels that are far apart and that are costly to join (see `other_hold`).
//! For curves with gaps it is an assumption, and the fit itself tells what it costs. The free fit
//! disagrees with zero along the curves by a root mean square `sigma`; holding the curves raises
//! the energy of the fit by `Delta E`. Per length `L` of curve and unit of disagreement that is a
//! *cost*
//!
//! `2 Delta E / (L sigma)`,
//!
//! a number without unit: the share of the unit slope next to the curves that holding them takes
//! away. It is near 0 where pieces of one curve have drifted apart across gaps, which the fit
//! corrects at little expense, and near 1 where they run beside each other, so that holding them
//! would press flat what lies between. In the second case a curve is not held at all costs: the fit
//! minimises `E + lambda L rms(phi)`, with the root mean square along the curve itself instead of
//! its square, under which the force on the curve never exceeds the share `lambda` of the unit
//! slope. Its stationary point is that of a quadratic penalty of weight `lambda / rms`.
//!
//! The thresholds are measured by `examples/broken_curves`, which prints the table.

use crate::geometry::{Triangle, mean_edge_length};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::integration::{Integrated, Integration};
use crate::signed_heat::level_sets::{Hold, Row};
use crate::signed_heat::options::LevelSets;
use crate::signed_heat::source::Source;
use eikona_mesh::{CurveKind, TriangleMesh};

/// Curves whose cost is at most this are held firmly.
const AFFORDABLE: f64 = 0.75;
/// Closed curves at several levels cost at least this much to hold at one.
const COST_OF_LEVELS: f64 = 0.5;
/// Levels differ when pieces of curve are apart by so many mean edges, as a root mean square, ...
const LEVELS_APART_EDGES: f64 = 3.0;
/// ... and by this share of the size of the surface (square root of the component's area). Less is
/// noise.
const LEVELS_APART_SIZE: f64 = 0.03;
/// `lambda` above.
const LARGEST_FORCE: f64 = 0.15;
/// How firmly broken curves are held, times the mean edge length.
const FIRM: f64 = 10.0;

/// The level sets of a solve, and the reason for them.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenLevelSets {
    /// The constraint that was imposed. Where [`LevelSets::Automatic`] treats components of the
    /// mesh differently, that of the one with the longest curves.
    pub level_sets: LevelSets,
    /// Why, in a sentence.
    pub reason: String,
}

impl ChosenLevelSets {
    pub(super) fn given(level_sets: LevelSets) -> Self {
        ChosenLevelSets { level_sets, reason: "as given".to_string() }
    }
}

/// How far the curves of a component are from one level.
#[derive(Clone, Copy, Debug, Default)]
struct Disagreement {
    /// Length of the curves.
    length: f64,
    /// Root mean square of the free fit along the curves, about its mean.
    spread: f64,
    /// The same of the means of the pieces.
    between_pieces: f64,
    /// See above.
    cost: f64,
}

impl Disagreement {
    /// How to hold curves that should not be held at zero. `apart`: from which spread on the levels
    /// of broken curves differ.
    fn other_hold(&self, broken: bool, edge: f64, apart: f64) -> Option<Hold> {
        // Closed curves are not displaced by noise: an edge between their levels is meant.
        let (apart, affordable) = if broken { (apart, AFFORDABLE) } else { (edge, COST_OF_LEVELS) };
        if self.between_pieces > apart && self.cost > affordable {
            Some(Hold::OwnLevels)
        } else if broken && self.cost > AFFORDABLE {
            // The weight at which the force is lambda, if the spread falls with the weight as that
            // of one mode does.
            Some(Hold::Softly(LARGEST_FORCE / (self.spread * (1.0 - LARGEST_FORCE / self.cost))))
        } else {
            None
        }
    }
}

impl Integration {
    /// The fit with the level sets that suit the source.
    ///
    /// # Cost
    /// One factorisation where all curves are closed, or hold at zero at little cost; else two.
    pub fn automatic(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        b: &[f64],
        source: &Source,
    ) -> Result<Integrated, SignedHeatError> {
        let edge = mean_edge_length(mesh, triangles);
        let broken = self.broken_components(mesh, source);
        let signed = self.has_signed(mesh, source);
        let at_first = |broken: &bool| if *broken { Hold::Softly(FIRM / edge) } else { Hold::Zero };
        let mut holds: Vec<Hold> = broken.iter().map(at_first).collect();
        let held = self.constrained(mesh, triangles, b, source, &holds)?;

        let (along, pieces) =
            self.rows(mesh, triangles, source, &vec![Hold::Softly(1.0); self.component_count]);
        let crossed = self.crossed_components(mesh, source);
        // One whole piece of curve can contradict nothing. Nor can whole curves that cross: near
        // each crossing the unit field turns between their normals, and the free fit shows levels
        // that are none.
        let judged: Vec<bool> = self
            .pieces_of_components(&along, pieces)
            .into_iter()
            .enumerate()
            .map(|(c, pieces)| signed[c] && (broken[c] || pieces > 1 && !crossed[c]))
            .collect();
        let free = if judged.contains(&true) { self.fit(b)?.values } else { held.values.clone() };
        let disagreements = self.disagreements(&along, pieces, b, &free, &held.values);
        let mut changed = false;
        for c in (0..self.component_count).filter(|&c| judged[c]) {
            let apart = (LEVELS_APART_EDGES * edge).max(LEVELS_APART_SIZE * self.size_of_component[c]);
            if let Some(hold) = disagreements[c].other_hold(broken[c], edge, apart) {
                holds[c] = hold;
                changed = true;
            }
        }
        let mut result = if changed { self.constrained(mesh, triangles, b, source, &holds)? } else { held };
        result.chosen = self.chosen(&holds, &disagreements);
        Ok(result)
    }

    fn chosen(&self, holds: &[Hold], disagreements: &[Disagreement]) -> ChosenLevelSets {
        let sourced = || disagreements.iter().enumerate().filter(|(_, d)| d.length > 0.0);
        let Some((c, d)) = sourced().max_by(|a, b| a.1.length.total_cmp(&b.1.length)) else {
            let reason = "automatic: there are only points".to_string();
            return ChosenLevelSets { level_sets: LevelSets::Zero, reason };
        };
        let kind = |hold: &Hold| std::mem::discriminant(hold);
        let others = sourced().filter(|(other, _)| kind(&holds[*other]) != kind(&holds[c])).count();
        let (level_sets, reason) = match holds[c] {
            Hold::Zero => (LevelSets::Zero, "no signed curve has gaps".to_string()),
            Hold::OwnLevels => (
                LevelSets::PerComponent,
                format!("pieces of curve lie at different levels, {:.3e} apart on average", d.between_pieces),
            ),
            Hold::Softly(weight) => {
                let what = if d.cost > AFFORDABLE {
                    "the curves have gaps and contradict each other"
                } else {
                    "the curves have gaps and agree with each other"
                };
                (LevelSets::Soft(weight * self.size_of_component[c]), format!("{what} (cost {:.2})", d.cost))
            }
        };
        let elsewhere = match others {
            0 => String::new(),
            1 => "; 1 other component is held in another way".to_string(),
            n => format!("; {n} other components are held in other ways"),
        };
        ChosenLevelSets { level_sets, reason: format!("automatic: {reason}{elsewhere}") }
    }

    /// For each component, whether a curve has an end inside the surface that no other segment
    /// meets.
    fn broken_components(&self, mesh: &TriangleMesh, source: &Source) -> Vec<bool> {
        let mut broken = vec![false; self.component_count];
        for end in source.open_ends(mesh) {
            if let Some(c) = self.component_of(mesh, end) {
                broken[c] = true;
            }
        }
        broken
    }

    /// For each component, whether signed curves cross in it.
    fn crossed_components(&self, mesh: &TriangleMesh, source: &Source) -> Vec<bool> {
        let mut crossed = vec![false; self.component_count];
        let signed = |pair: &&[usize; 2]| pair.iter().all(|&s| source.kinds[s] == CurveKind::Signed);
        for [a, _] in source.crossings.iter().filter(signed) {
            if let Some(c) = self.component_of(mesh, source.segments[*a].ends[0]) {
                crossed[c] = true;
            }
        }
        crossed
    }

    /// How many connected pieces of curve each component has.
    fn pieces_of_components(&self, along: &[Row], pieces: usize) -> Vec<usize> {
        let mut seen = vec![false; pieces];
        let mut count = vec![0; self.component_count];
        for row in along {
            if let Some(c) = self.component_of_row(row)
                && !std::mem::replace(&mut seen[row.group as usize], true)
            {
                count[c] += 1;
            }
        }
        count
    }

    fn disagreements(
        &self,
        along: &[Row],
        pieces: usize,
        b: &[f64],
        free: &[f64],
        held: &[f64],
    ) -> Vec<Disagreement> {
        let mut result = vec![Disagreement::default(); self.component_count];
        let mut sums = vec![0.0; self.component_count];
        let mut of_piece = vec![(0, 0.0, 0.0); pieces];
        for row in along {
            let Some(c) = self.component_of_row(row) else { continue };
            let value = row.place.value(free);
            result[c].length += row.weight;
            sums[c] += row.weight * value;
            let (component, length, sum) = &mut of_piece[row.group as usize];
            *component = c;
            *length += row.weight;
            *sum += row.weight * value;
        }
        let mean: Vec<f64> = sums.iter().zip(&result).map(|(sum, d)| sum / d.length).collect();
        for row in along {
            if let Some(c) = self.component_of_row(row) {
                result[c].spread += row.weight * (row.place.value(free) - mean[c]).powi(2);
            }
        }
        for (c, length, sum) in of_piece.into_iter().filter(|(_, length, _)| *length > 0.0) {
            result[c].between_pieces += length * (sum / length - mean[c]).powi(2);
        }
        // 2 Delta E = (b - C held) . (free - held), the forces that hold the curves times what they
        // move.
        let applied = self.applied(held);
        let mut work = vec![0.0; self.component_count];
        for (v, component) in self.component_of_vertex.iter().enumerate() {
            if let Some(c) = component {
                work[*c as usize] += (b[v] - applied[v]) * (free[v] - held[v]);
            }
        }
        for (d, work) in result.iter_mut().zip(work).filter(|(d, _)| d.length > 0.0) {
            d.spread = (d.spread / d.length).sqrt();
            d.between_pieces = (d.between_pieces / d.length).sqrt();
            d.cost = if d.spread > 0.0 { work / (d.length * d.spread) } else { 0.0 };
        }
        result
    }
}
