//! Detection of reversed stretches of a curve.
//!
//! The energy of the jump function is a quadratic form of the curve: E = s' K s, where s has +1 (as
//! given) or -1 (reversed) per stretch. Stretches that belong together lower each other's
//! contribution, since the ends of one cancel the ends of the next; a stretch that raises that of
//! the others looks reversed.
//!
//! Two kinds of stretches are kept as given, even if reversing them would lower the energy: those
//! without ends (closed, or from boundary to boundary), since either orientation is meaningful; and
//! those that run alongside each other (copies, offsets), which would cancel.

use crate::Warning;
use crate::curves::SegmentId;
use crate::cut::EmbeddedCurve;
use crate::geometry::Triangle;
use crate::geometry::vector::distance;
use crate::operators::right_hand_side;
use crate::winding::chain::Step;
use crate::winding::coordinates::Coordinates;
use crate::winding::error::WindingError;
use crate::winding::labels::share_of_area;
use crate::winding::operators::Operators;
use eikona_mesh::{Curve, Face, Halfedge, SurfaceCurves, TriangleMesh, UnionFind, Vertex};
use std::collections::BTreeMap;

/// Largest number of stretches that [`Diagnosis::Automatic`](super::Diagnosis::Automatic) checks.
pub const AUTOMATIC_DIAGNOSIS_LIMIT: usize = 32;

/// Largest number of stretches that [`Diagnosis::Always`](super::Diagnosis::Always) checks: every
/// pair is compared.
pub(super) const DIAGNOSIS_LIMIT: usize = 2000;

/// A stretch is reversed if its contribution to the energy of the others exceeds this share of its
/// own energy.
const SHARE: f64 = 0.05;
/// Energies below this are rounding errors of closed curves that bound (jumps are integers).
const NO_ENERGY: f64 = 1e-9;

/// Result of the orientation check of the curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Orientation {
    /// Number of stretches: maximal runs of the curve between its ends and branch points.
    pub stretches: usize,
    /// The segments of the input that look reversed; empty if none does.
    pub reversed: Vec<SegmentId>,
    /// Relative decrease of the jump function's energy when they are reversed.
    pub energy_saved: f64,
    /// The share of the area whose label changes when they are reversed; `None` if the solve for
    /// the changed curve fails.
    pub changed_area: Option<f64>,
    /// Their steps, by curve and step.
    steps: Vec<(usize, usize)>,
}

impl Orientation {
    /// Returns the input curves with the suspect segments reversed. A curve that looks reversed in
    /// part only is split.
    ///
    /// ```
    /// use eikona::mesh::{Curve, SurfaceCurves, Vertex, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    ///
    /// // Most of a ring of 36 vertices in a disk, in two pieces; the shorter one is reversed.
    /// let disk = shapes::disk(12, 6, 1.0)?;
    /// let ring = |j: u32| Vertex(91 + j % 36);
    /// let first = Curve::signed((0..=16).map(ring));
    /// let second = Curve::signed((19..=33).rev().map(ring));
    /// let curves = SurfaceCurves { curves: vec![first, second], points: Vec::new() };
    /// let winding = surface_winding_number(&disk, &curves, &WindingOptions::default())?;
    /// let suggested = winding.report.orientation.unwrap().suggested(&curves);
    /// assert_eq!(suggested.curves[1], curves.curves[1].clone().reversed());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn suggested(&self, curves: &SurfaceCurves) -> SurfaceCurves {
        let mut suggested = SurfaceCurves { curves: Vec::new(), points: curves.points.clone() };
        for (c, curve) in curves.curves.iter().enumerate() {
            let looks_reversed =
                |node: usize| self.reversed.binary_search(&SegmentId { curve: c, node }).is_ok();
            let flags: Vec<bool> = (0..curve.nodes.len().saturating_sub(1)).map(looks_reversed).collect();
            let mut first = 0;
            for run in flags.chunk_by(|a, b| a == b) {
                let nodes = curve.nodes[first..=first + run.len()].to_vec();
                let part = Curve { kind: curve.kind, up: curve.up, nodes };
                suggested.curves.push(if run[0] { part.reversed() } else { part });
                first += run.len();
            }
        }
        suggested
    }

    /// Returns the jumps after reversing those steps.
    pub(super) fn with_reversed(&self, steps: &[Step], jump: &[i32]) -> Vec<i32> {
        let mut jump = jump.to_vec();
        for step in steps.iter().filter(|s| self.steps.binary_search(&(s.curve, s.step)).is_ok()) {
            jump[step.edge.index()] -= 2 * step.jump;
        }
        jump
    }

    /// Returns the result as a warning.
    pub(super) fn warning(&self) -> Warning {
        Warning::ReversedSegments {
            segments: self.reversed.clone(),
            energy_saved: self.energy_saved,
            changed_area: self.changed_area,
        }
    }
}

/// Returns the share of the area on which two labellings differ.
pub(super) fn changed_area(triangles: &[Triangle], one: &[i32], other: &[i32]) -> f64 {
    share_of_area(triangles, |f| one[f] != other[f])
}

/// The steps of a curve, grouped into stretches.
pub(super) struct Stretches {
    of: Vec<Vec<Step>>,
}

impl Stretches {
    /// Groups steps: they follow each other within a curve, and at a vertex where as many curves
    /// start as end, each end is followed by a start.
    pub fn of(steps: &[Step]) -> Stretches {
        let steps: Vec<Step> = steps.iter().copied().filter(|s| s.jump != 0).collect();
        let mut next: Vec<Option<usize>> = vec![None; steps.len()];
        let mut is_followed = vec![false; steps.len()];
        let mut loose: BTreeMap<Vertex, [Vec<usize>; 2]> = BTreeMap::new();
        for i in 0..steps.len() {
            let follows = |n: &Step| n.curve == steps[i].curve && n.step == steps[i].step + 1;
            if steps.get(i + 1).is_some_and(follows) {
                next[i] = Some(i + 1);
                is_followed[i + 1] = true;
            } else {
                loose.entry(steps[i].ends[1]).or_default()[0].push(i);
            }
        }
        for i in (0..steps.len()).filter(|&i| !is_followed[i]) {
            loose.entry(steps[i].ends[0]).or_default()[1].push(i);
        }
        for [arriving, leaving] in
            loose.into_values().filter(|[arriving, leaving]| arriving.len() == leaving.len())
        {
            for (a, b) in arriving.into_iter().zip(leaving) {
                next[a] = Some(b);
                is_followed[b] = true;
            }
        }
        let mut of = Vec::new();
        let mut taken = vec![false; steps.len()];
        let open_first = (0..steps.len()).filter(|&i| !is_followed[i]).chain(0..steps.len());
        for first in open_first {
            let mut stretch = Vec::new();
            let mut at = Some(first);
            while let Some(i) = at.filter(|&i| !taken[i]) {
                taken[i] = true;
                stretch.push(steps[i]);
                at = next[i];
            }
            if !stretch.is_empty() {
                of.push(stretch);
            }
        }
        Stretches { of }
    }

    pub fn count(&self) -> usize {
        self.of.len()
    }

    /// Reverses stretches as long as that lowers the energy, each time the one that lowers it most.
    ///
    /// # Cost
    /// One factorisation, and per stretch a solve for the values beside the curve.
    /// A factorisation, and for each stretch a solve for the values beside the curve.
    pub fn diagnose(
        &self,
        mesh: &TriangleMesh,
        (triangles, unit): (&[Triangle], f64),
        on: &Operators,
        excluded: &[bool],
        curves: &[EmbeddedCurve],
    ) -> Result<Orientation, WindingError> {
        let mut report = Orientation { stretches: self.count(), ..Orientation::default() };
        if self.count() < 2 {
            return Ok(report);
        }
        let Some(Interaction { mut energy, has_ends }) = self.interaction(mesh, on, excluded)? else {
            return Ok(report);
        };
        let given: f64 = energy.iter().flatten().sum();
        let lengths: Vec<f64> =
            self.of.iter().map(|s| s.iter().map(|step| length(mesh, triangles, step)).sum()).collect();
        let whole = energy.clone();
        self.clear_neighbours(mesh, unit, &lengths, &mut energy);
        let mut sign = vec![1.0; self.count()];
        let raised = |p: usize, sign: &[f64]| -> f64 {
            (0..sign.len()).filter(|&q| q != p).map(|q| sign[p] * sign[q] * energy[p][q]).sum()
        };
        // Every reversal lowers the energy, so no state recurs.
        loop {
            let worst = (0..sign.len())
                .filter(|&p| has_ends[p] && energy[p][p] > NO_ENERGY)
                .map(|p| (p, raised(p, &sign)))
                .filter(|&(p, raised)| raised > SHARE * energy[p][p])
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((worst, _)) = worst else { break };
            sign[worst] = -sign[worst];
        }
        let groups = groups(&energy, &has_ends);
        reverse_the_shorter_parts(&groups, &lengths, &mut sign);
        restore_what_saves_nothing(&groups, &whole, &mut sign);
        let pairs = (0..sign.len()).flat_map(|p| (0..sign.len()).map(move |q| (p, q)));
        let after: f64 = pairs.map(|(p, q)| sign[p] * sign[q] * whole[p][q]).sum();
        if given <= NO_ENERGY || after >= given {
            return Ok(report);
        }
        report.energy_saved = 1.0 - after / given;
        for step in self.of.iter().zip(&sign).filter(|(_, s)| **s < 0.0).flat_map(|(stretch, _)| stretch) {
            report.steps.push((step.curve, step.step));
        }
        report.steps.sort_unstable();
        report.reversed = report
            .steps
            .iter()
            .map(|&(curve, step)| SegmentId { curve, node: curves[curve].segments[step] })
            .collect();
        report.reversed.dedup();
        Ok(report)
    }

    /// Returns the pairwise energies of the stretches; `None` if none has ends.
    fn interaction(
        &self,
        mesh: &TriangleMesh,
        on: &Operators,
        excluded: &[bool],
    ) -> Result<Option<Interaction>, WindingError> {
        let mut excluded = excluded.to_vec();
        let mut coordinates = Coordinates::none(mesh);
        let mut jump = vec![0.0; mesh.edge_count()];
        let mut has_ends = Vec::with_capacity(self.count());
        // The differences along halfedges that each stretch causes.
        let mut made: Vec<Vec<(Halfedge, f64)>> = Vec::with_capacity(self.count());
        for stretch in &self.of {
            let endpoints = coordinates.endpoints.len();
            stretch.iter().for_each(|s| jump[s.edge.index()] += f64::from(s.jump));
            coordinates.walk_around(mesh, &jump, vertices_of(stretch), 0.5);
            stretch.iter().for_each(|s| jump[s.edge.index()] = 0.0);
            has_ends.push(coordinates.endpoints.len() > endpoints);
            let mut faces: Vec<Face> = vertices_of(stretch)
                .into_iter()
                .flat_map(|v| mesh.vertex_corners(v).iter().map(|c| c.face()))
                .collect();
            faces.sort_unstable();
            faces.dedup();
            let corner = &mut coordinates.corner;
            let halfedges = faces.iter().flat_map(|f| [0, 1, 2].map(|k| f.halfedge(k)));
            let difference = |h: Halfedge| corner[h.next().index()] - corner[h.index()];
            made.push(halfedges.map(|h| (h, difference(h))).filter(|(_, x)| *x != 0.0).collect());
            faces.iter().for_each(|f| corner[3 * f.index()..3 * f.index() + 3].fill(0.0));
        }
        if !has_ends.contains(&true) {
            return Ok(None);
        }
        coordinates.left_out().for_each(|v| excluded[v.index()] = true);
        let factor = on.factor(mesh, &excluded)?;
        let triangulation = &on.triangulation;
        let ends = |h: Halfedge| [triangulation.origin(h), triangulation.tip(h)].map(|v| v.index());
        let mut beside = vec![false; mesh.vertex_count()];
        for some in &mut made {
            some.retain(|&(h, _)| ends(h).iter().all(|&v| !excluded[v]));
            some.iter().for_each(|&(h, _)| ends(h).into_iter().for_each(|v| beside[v] = true));
        }
        let mut energy = vec![vec![0.0; self.count()]; self.count()];
        let mut own = vec![0.0; mesh.halfedge_count()];
        for (q, differences) in made.iter().enumerate() {
            differences.iter().for_each(|&(h, value)| own[h.index()] = value);
            let rhs = right_hand_side(triangulation, &excluded, &own);
            let base = factor.solve_where(&rhs, |v| beside[v])?;
            for (p, others) in made.iter().enumerate() {
                let part = |&(h, value): &(Halfedge, f64)| {
                    let [i, j] = ends(h).map(|v| base[v]);
                    triangulation.weight[h] * value * (own[h.index()] + j - i)
                };
                energy[p][q] = others.iter().map(part).sum();
            }
            differences.iter().for_each(|&(h, _)| own[h.index()] = 0.0);
        }
        Ok(Some(Interaction { energy, has_ends }))
    }

    /// Clears the mutual energy of stretches that run alongside each other: the middle third of one
    /// is nearer to the other than a quarter of its length.
    fn clear_neighbours(&self, mesh: &TriangleMesh, unit: f64, lengths: &[f64], energy: &mut [Vec<f64>]) {
        let position = |v: Vertex| mesh.position(v).map(|x| x / unit);
        let points: Vec<Vec<[f64; 3]>> =
            self.of.iter().map(|s| vertices_of(s).into_iter().map(position).collect()).collect();
        for (p, stretch) in self.of.iter().enumerate() {
            let third = stretch.len() / 3;
            let middle = &stretch[third..stretch.len() - third];
            let few = middle.iter().step_by(middle.len().div_ceil(MAX_POINTS).max(1));
            let few: Vec<[f64; 3]> = few.map(|step| position(step.ends[0])).collect();
            for q in (0..self.count()).filter(|&q| q != p) {
                let near = |a: &[f64; 3]| points[q].iter().any(|b| distance(*a, *b) < 0.25 * lengths[p]);
                if few.iter().all(near) {
                    energy[p][q] = 0.0;
                    energy[q][p] = 0.0;
                }
            }
        }
    }
}

/// Number of points of a stretch tested for running alongside another.
const MAX_POINTS: usize = 16;

struct Interaction {
    /// The energy contributed by each pair of stretches.
    energy: Vec<Vec<f64>>,
    /// Whether a stretch ends inside the surface.
    has_ends: Vec<bool>,
}

/// Returns the group number of each stretch; stretches that interact share a group.
fn groups(energy: &[Vec<f64>], has_ends: &[bool]) -> Vec<usize> {
    let mut groups = UnionFind::new(energy.len());
    for p in 0..energy.len() {
        for q in 0..p {
            let matters = energy[p][q].abs() > SHARE * energy[p][p].min(energy[q][q]);
            if has_ends[p] && has_ends[q] && matters {
                groups.join(p as u32, q as u32);
            }
        }
    }
    groups.numbers().0.into_iter().map(|g| g as usize).collect()
}

/// Keeps the longer side of each group: reversing a whole group hardly changes the energy, so of
/// its reversed and its other stretches the shorter set counts as reversed.
fn reverse_the_shorter_parts(groups: &[usize], lengths: &[f64], sign: &mut [f64]) {
    let mut kept = vec![0.0; groups.len()];
    (0..sign.len()).for_each(|p| kept[groups[p]] += sign[p] * lengths[p]);
    for p in (0..sign.len()).filter(|&p| kept[groups[p]] < 0.0) {
        sign[p] = -sign[p];
    }
}

/// Restores the reversed stretches of a group unless that raises the energy, this time including
/// stretches that run alongside each other.
fn restore_what_saves_nothing(groups: &[usize], whole: &[Vec<f64>], sign: &mut [f64]) {
    for g in 0..groups.len() {
        let is_reversed = |p: usize, sign: &[f64]| groups[p] == g && sign[p] < 0.0;
        let reversed: Vec<usize> = (0..sign.len()).filter(|&p| is_reversed(p, sign)).collect();
        let others = (0..sign.len()).filter(|&q| !is_reversed(q, sign));
        let between: f64 = others
            .flat_map(|q| reversed.iter().map(move |&p| (p, q)))
            .map(|(p, q)| sign[p] * sign[q] * (whole[p][q] + whole[q][p]))
            .sum();
        if between >= 0.0 {
            reversed.into_iter().for_each(|p| sign[p] = 1.0);
        }
    }
}

fn length(mesh: &TriangleMesh, triangles: &[Triangle], step: &Step) -> f64 {
    let h = mesh.edge_halfedges(step.edge)[0];
    triangles[h.face().index()].lengths[h.side()]
}

fn vertices_of(stretch: &[Step]) -> Vec<Vertex> {
    let mut vertices: Vec<Vertex> = stretch.iter().flat_map(|s| s.ends).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
