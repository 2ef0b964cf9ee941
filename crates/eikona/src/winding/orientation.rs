//! Which stretches of a curve look reversed.
//!
//! The energy of the jump function is a quadratic form of the curve: E = s' K s, where s has +1 or -1 for each stretch, as it is
//! given or turned over. Stretches that belong together lower each other's part of it, since the ends of one cancel the ends of
//! the next; a stretch that raises that of the others looks reversed. Closed stretches are taken as they are given: either
//! orientation of a loop means something.

use crate::contour::{EmbeddedCurve, SegmentId};
use crate::geometry::Triangle;
use crate::winding::chain::Step;
use crate::winding::coordinates::Coordinates;
use crate::winding::error::WindingError;
use crate::winding::jump_laplace::{differences, right_hand_side};
use crate::winding::operators::Operators;
use eikona_mesh::{Components, Curve, SurfaceCurves, TriangleMesh, Vertex};
use std::collections::BTreeMap;

/// [`Diagnosis::Automatic`](super::Diagnosis::Automatic) looks at curves of up to so many stretches.
pub const MOST_STRETCHES: usize = 32;

/// A stretch is turned over if what it adds to the energy of the others is more than this share of its own.
const SHARE: f64 = 0.05;
/// Energies below this (jumps are whole numbers) are rounding: of closed curves that bound.
const NO_ENERGY: f64 = 1e-9;

/// What was found about the orientation of the curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Orientation {
    /// Stretches of the curve: what is walked in one go, from an end or a branching to the next.
    pub stretches: usize,
    /// The segments of the input that look reversed; empty if all looks well.
    pub reversed: Vec<SegmentId>,
    /// By which share of it the energy of the jump function falls when they are turned over.
    pub energy_saved: f64,
    /// The share of the area whose label changes when they are turned over.
    pub changed_area: f64,
    /// Their steps, by curve and step.
    steps: Vec<(usize, usize)>,
}

impl Orientation {
    /// The curves of the input with the segments that look reversed turned over. A curve of which only some do is parted.
    ///
    /// ```
    /// use eikona::mesh::{Curve, SurfaceCurves, Vertex, shapes};
    /// use eikona::winding::{WindingOptions, surface_winding_number};
    /// // Most of a ring of 36 vertices in a disk, in two pieces; the shorter one runs against the other.
    /// let disk = shapes::disk(12, 6, 1.0)?;
    /// let ring = |j: u32| Vertex(91 + j % 36);
    /// let (first, second) = (Curve::signed((0..=16).map(ring)), Curve::signed((19..=33).rev().map(ring)));
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

    /// The jumps with the reversed steps turned over.
    pub(super) fn turned_over(&self, steps: &[Step], jump: &[i32]) -> Vec<i32> {
        let mut jump = jump.to_vec();
        for step in steps.iter().filter(|s| self.steps.binary_search(&(s.curve, s.step)).is_ok()) {
            jump[step.edge.index()] -= 2 * step.jump;
        }
        jump
    }

    /// For the user.
    pub(super) fn sentence(&self) -> String {
        let first = self.reversed[0];
        let segments = crate::wording::counted(self.reversed.len(), "segment looks", "segments look");
        format!(
            "{segments} reversed, the first is curve {}, node {}: turned over the energy falls by {:.0} %, and labels change \
             on {:.1} % of the area",
            first.curve,
            first.node,
            100.0 * self.energy_saved,
            100.0 * self.changed_area
        )
    }
}

/// The share of the area on which two labellings differ.
pub(super) fn changed_area(triangles: &[Triangle], one: &[i32], other: &[i32]) -> f64 {
    let total: f64 = triangles.iter().map(|t| t.area).sum();
    let pairs = triangles.iter().zip(one.iter().zip(other));
    let changed: f64 = pairs.filter(|(_, (a, b))| a != b).map(|(t, _)| t.area).sum();
    if total > 0.0 { changed / total } else { 0.0 }
}

/// The steps of a curve by stretches.
pub(super) struct Stretches {
    of: Vec<Vec<Step>>,
}

impl Stretches {
    /// Steps follow each other within a curve; and where as many others arrive at a vertex as leave it, one the other.
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

    /// Turns over what lowers the energy, one stretch after the other, the one that lowers it most first.
    ///
    /// # Cost
    /// A factorisation, and for each stretch a solve for the values beside the curve.
    pub fn diagnose(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        on: &Operators,
        excluded: &[bool],
        curves: &[EmbeddedCurve],
    ) -> Result<Orientation, WindingError> {
        let mut report = Orientation { stretches: self.count(), ..Orientation::default() };
        if self.count() < 2 || !(0..self.count()).any(|p| self.has_ends(p)) {
            return Ok(report);
        }
        let interaction = self.interaction(mesh, on, excluded)?;
        let mut sign = vec![1.0; self.count()];
        let row =
            |p: usize, sign: &[f64]| -> f64 { interaction[p].iter().zip(sign).map(|(k, s)| k * s).sum() };
        let energy = |sign: &[f64]| -> f64 { (0..sign.len()).map(|p| sign[p] * row(p, sign)).sum() };
        let given = energy(&sign);
        // Every turn lowers the energy, so that no state comes back.
        loop {
            let raised = |p: usize| sign[p] * row(p, &sign) - interaction[p][p];
            let worst = (0..sign.len())
                .filter(|&p| self.has_ends(p) && raised(p) > SHARE * interaction[p][p])
                .filter(|&p| interaction[p][p] > NO_ENERGY)
                .max_by(|&p, &q| raised(p).total_cmp(&raised(q)));
            let Some(worst) = worst else { break };
            sign[worst] = -sign[worst];
        }
        report.energy_saved = if given > NO_ENERGY { 1.0 - energy(&sign) / given } else { 0.0 };
        self.turn_the_shorter_part(mesh, triangles, &mut sign);
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

    fn has_ends(&self, p: usize) -> bool {
        let stretch = &self.of[p];
        stretch[0].ends[0] != stretch[stretch.len() - 1].ends[1]
    }

    /// What each stretch adds to the energy beside each other one.
    fn interaction(
        &self,
        mesh: &TriangleMesh,
        on: &Operators,
        excluded: &[bool],
    ) -> Result<Vec<Vec<f64>>, WindingError> {
        let mut excluded = excluded.to_vec();
        let mut coordinates = Coordinates::none(mesh);
        let mut jump = vec![0.0; mesh.edge_count()];
        let mut alone = |stretch: &[Step], coordinates: &mut Coordinates| {
            stretch.iter().for_each(|s| jump[s.edge.index()] += f64::from(s.jump));
            coordinates.walk_around(mesh, &jump, vertices_of(stretch), 0.5);
            stretch.iter().for_each(|s| jump[s.edge.index()] = 0.0);
        };
        for stretch in &self.of {
            alone(stretch, &mut coordinates);
            coordinates.left_out().for_each(|v| excluded[v.index()] = true);
        }
        let factor = on.factor(mesh, &excluded)?;
        let triangulation = &on.triangulation;
        // The differences that each stretch makes along halfedges.
        let mut made: Vec<Vec<(usize, f64)>> = Vec::with_capacity(self.count());
        let mut beside = vec![false; mesh.vertex_count()];
        for stretch in &self.of {
            coordinates = Coordinates::none(mesh);
            alone(stretch, &mut coordinates);
            let all = differences(&coordinates.corner);
            let mut some = Vec::new();
            for (h, value) in all.into_iter().enumerate().filter(|(_, value)| *value != 0.0) {
                let ends = [triangulation.origin(h), triangulation.tip(h)];
                if ends.iter().all(|&v| !excluded[v as usize]) {
                    some.push((h, value));
                    ends.into_iter().for_each(|v| beside[v as usize] = true);
                }
            }
            made.push(some);
        }
        let mut interaction = vec![vec![0.0; self.count()]; self.count()];
        let mut own = vec![0.0; mesh.halfedge_count()];
        for (q, differences) in made.iter().enumerate() {
            differences.iter().for_each(|&(h, value)| own[h] = value);
            let rhs = right_hand_side(triangulation, &excluded, &own);
            let base = factor.solve_where(&rhs, |v| beside[v])?;
            for (p, others) in made.iter().enumerate() {
                interaction[p][q] = others
                    .iter()
                    .map(|&(h, value)| {
                        let [i, j] =
                            [triangulation.origin(h), triangulation.tip(h)].map(|v| base[v as usize]);
                        triangulation.weight[h] * value * (own[h] + j - i)
                    })
                    .sum();
            }
            differences.iter().for_each(|&(h, _)| own[h] = 0.0);
        }
        Ok(interaction)
    }

    /// Turning over all stretches of a component of the surface changes no energy: of what is turned over there and the rest, the
    /// shorter is what looks reversed.
    fn turn_the_shorter_part(&self, mesh: &TriangleMesh, triangles: &[Triangle], sign: &mut [f64]) {
        let components = Components::of(mesh);
        let component = |stretch: &[Step]| components.of_vertex[stretch[0].ends[0]].map_or(0, |c| c as usize);
        let length = |step: &Step| {
            let h = mesh.edge_halfedges(step.edge)[0];
            triangles[h.face().index()].lengths[h.index() % 3]
        };
        let mut balance = vec![0.0; components.count.max(1)];
        for (stretch, sign) in self.of.iter().zip(sign.iter()) {
            balance[component(stretch)] += sign * stretch.iter().map(length).sum::<f64>();
        }
        for (stretch, sign) in self.of.iter().zip(sign) {
            if balance[component(stretch)] < 0.0 {
                *sign = -*sign;
            }
        }
    }
}

fn vertices_of(stretch: &[Step]) -> Vec<Vertex> {
    let mut vertices: Vec<Vertex> = stretch.iter().flat_map(|s| s.ends).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
