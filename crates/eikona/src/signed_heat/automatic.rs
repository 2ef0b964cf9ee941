//! Automatic choice of level sets for a source ([`LevelSets::Automatic`]).
//!
//! Closed curves bound a region, so their exact distance is zero along them. They are constrained
//! to zero unless the free fit shows levels that are far apart and costly to join (see
//! `replacement`). For curves with gaps, zero along the curve is an assumption, and its cost can be
//! measured from the fit. Let `sigma` be the root mean square deviation of the free fit from zero
//! along the curves, and `Delta E` the energy that the constraint adds to the fit. The *cost* per
//! length `L` of curve and unit of deviation is
//!
//! `2 Delta E / (L sigma)`,
//!
//! a dimensionless number: the share of the unit slope next to the curves that the constraint takes
//! away. It is near 0 where pieces of one curve have drifted apart across gaps, which the fit
//! corrects at little expense. It is near 1 where pieces run side by side, so that the constraint
//! would flatten the distance between them. In that case the fit minimises `E + lambda L rms(phi)`
//! instead, with the root mean square along the curve rather than its square, under which the force
//! on the curve never exceeds the share `lambda` of the unit slope. Its stationary point is that of
//! a quadratic penalty of weight `lambda / rms`.
//!
//! The thresholds are measured by `examples/broken_curves`, which prints the table.

use crate::geometry::{Triangle, mean_edge_length};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::integration::{Integrated, Integration};
use crate::signed_heat::level_sets::{Constraint, Row};
use crate::signed_heat::options::LevelSets;
use crate::signed_heat::source::Source;
use eikona_mesh::{CurveKind, TriangleMesh};
use eikona_numeric::check_stopped;

/// Curves with a cost up to this are constrained firmly.
const AFFORDABLE: f64 = 0.75;
/// Closed curves at several levels have at least this cost when constrained to one.
const COST_OF_LEVELS: f64 = 0.5;
/// Pieces of curve have different levels if their root mean square deviation is at least this many
/// mean edge lengths, ...
const LEVELS_APART_EDGES: f64 = 3.0;
/// ... and at least this share of the size of the surface (square root of the component's area).
/// Smaller deviations are noise.
const LEVELS_APART_SIZE: f64 = 0.03;
/// `lambda` in the module documentation.
const LARGEST_FORCE: f64 = 0.15;
/// Penalty weight for broken curves, times the mean edge length.
const FIRM: f64 = 10.0;

/// Level sets of a solve, and the reason for them.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenLevelSets {
    /// The constraint that was imposed. If [`LevelSets::Automatic`] chose differently per component
    /// of the mesh, the constraint of the component with the longest curves.
    pub level_sets: LevelSets,
    /// The reason, as a phrase for the user.
    pub reason: String,
}

impl ChosenLevelSets {
    pub(super) fn given(level_sets: LevelSets) -> Self {
        ChosenLevelSets { level_sets, reason: "as given".to_string() }
    }
}

/// Spread of the curves of one component about a common level.
#[derive(Clone, Copy, Debug, Default)]
struct Disagreement {
    /// Length of the curves.
    length: f64,
    /// Root mean square deviation of the free fit along the curves from its mean.
    spread: f64,
    /// The same for the means of the pieces.
    between_pieces: f64,
    /// Cost as defined in the module documentation.
    cost: f64,
}

impl Disagreement {
    /// Returns the constraint for curves that should not be constrained to zero. `apart` is the
    /// spread above which the levels of broken curves differ.
    fn replacement(&self, broken: bool, edge: f64, apart: f64) -> Option<Constraint> {
        // Noise does not displace closed curves: a spread of one edge already means different
        // levels.
        let (apart, affordable) = if broken { (apart, AFFORDABLE) } else { (edge, COST_OF_LEVELS) };
        if self.between_pieces > apart && self.cost > affordable {
            Some(Constraint::OwnLevels)
        } else if broken && self.cost > AFFORDABLE {
            // The weight at which the force equals lambda, assuming that the spread depends on the
            // weight as that of a single mode does.
            Some(Constraint::Soft(LARGEST_FORCE / (self.spread * (1.0 - LARGEST_FORCE / self.cost))))
        } else {
            None
        }
    }
}

impl Integration {
    /// Computes the fit with the level sets that suit the source.
    ///
    /// # Cost
    /// One factorisation if all curves are closed or can be constrained to zero at little cost;
    /// otherwise two.
    pub fn automatic(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        b: &[f64],
        source: &Source,
    ) -> Result<Integrated, SignedHeatError> {
        let edge = mean_edge_length(mesh, triangles);
        check_stopped()?;
        let broken = self.broken_components(mesh, source);
        let signed = self.has_signed(mesh, source);
        let at_first = |broken: &bool| if *broken { Constraint::Soft(FIRM / edge) } else { Constraint::Zero };
        let mut constraints: Vec<Constraint> = broken.iter().map(at_first).collect();
        let held = self.constrained(mesh, triangles, b, source, &constraints)?;

        check_stopped()?;
        let (along, pieces) =
            self.rows(mesh, triangles, source, &vec![Constraint::Soft(1.0); self.component_count]);
        check_stopped()?;
        let crossed = self.crossed_components(mesh, source);
        // A single closed piece can not contradict itself. Nor can closed curves that cross: near
        // each crossing the unit field turns between their normals, and the levels of the free fit
        // are not meaningful there.
        let judged: Vec<bool> = self
            .pieces_of_components(&along, pieces)
            .into_iter()
            .enumerate()
            .map(|(c, pieces)| signed[c] && (broken[c] || pieces > 1 && !crossed[c]))
            .collect();
        let free = if judged.contains(&true) { self.fit(b)?.values } else { held.values.clone() };
        check_stopped()?;
        let disagreements = self.disagreements(&along, pieces, b, &free, &held.values);
        let mut changed = false;
        for c in (0..self.component_count).filter(|&c| judged[c]) {
            let apart = (LEVELS_APART_EDGES * edge).max(LEVELS_APART_SIZE * self.size_of_component[c]);
            if let Some(constraint) = disagreements[c].replacement(broken[c], edge, apart) {
                constraints[c] = constraint;
                changed = true;
            }
        }
        let mut result =
            if changed { self.constrained(mesh, triangles, b, source, &constraints)? } else { held };
        result.chosen = self.chosen(&constraints, &disagreements);
        Ok(result)
    }

    fn chosen(&self, constraints: &[Constraint], disagreements: &[Disagreement]) -> ChosenLevelSets {
        let sourced = || disagreements.iter().enumerate().filter(|(_, d)| d.length > 0.0);
        let Some((c, d)) = sourced().max_by(|a, b| a.1.length.total_cmp(&b.1.length)) else {
            let reason = "automatic: the source has only points".to_string();
            return ChosenLevelSets { level_sets: LevelSets::Zero, reason };
        };
        let kind = |constraint: &Constraint| std::mem::discriminant(constraint);
        let others =
            sourced().filter(|(other, _)| kind(&constraints[*other]) != kind(&constraints[c])).count();
        let (level_sets, reason) = match constraints[c] {
            Constraint::Zero => (LevelSets::Zero, "no signed curve has gaps".to_string()),
            Constraint::OwnLevels => (
                LevelSets::PerComponent,
                format!(
                    "pieces of curve have different levels (root mean square deviation {:.3e})",
                    d.between_pieces
                ),
            ),
            Constraint::Soft(weight) => {
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
            1 => "; 1 other component has a different constraint".to_string(),
            n => format!("; {n} other components have different constraints"),
        };
        ChosenLevelSets { level_sets, reason: format!("automatic: {reason}{elsewhere}") }
    }

    /// Returns per component whether a signed curve has an open end inside the surface.
    fn broken_components(&self, mesh: &TriangleMesh, source: &Source) -> Vec<bool> {
        let mut broken = vec![false; self.component_count];
        for end in source.open_ends(mesh) {
            if let Some(c) = self.component_of(mesh, end) {
                broken[c] = true;
            }
        }
        broken
    }

    /// Returns per component whether signed curves cross in it.
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

    /// Returns the number of connected pieces of curve per component.
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
        // 2 Delta E = (b - C held) . (free - held): the constraint forces times the displacements
        // they cause.
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
