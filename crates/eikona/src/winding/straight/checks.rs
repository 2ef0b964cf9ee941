//! Checks of the labels that follow from straightened pieces.

use super::layer::Layer;
use super::refined::{Refined, Wall};
use crate::geometry::face_in;
use crate::winding::labels::face_mean;
use crate::winding::solution::Winding;
use eikona_mesh::{Edge, Face, Halfedge, Neighbour, TriangleMesh};
use eikona_numeric::{NumericError, check_step};
use std::collections::{BTreeMap, BTreeSet};

/// Threshold of [`Winding::overreaching`]. At 0 regions may change label only if their values are
/// halfway; at 1 always.
const DOUBT: f64 = 0.3;

impl Winding {
    /// Returns the pieces beside which the labels changed: they cross others.
    pub(super) fn crossing(
        &self,
        refined: &Refined,
        walls: &[(usize, Vec<Wall>)],
        regions: &Layer,
        rest: &[f64],
        labels: &[f64],
    ) -> Vec<usize> {
        let mesh = refined.mesh();
        let uses = uses(mesh, walls);
        let is_wrong = |(i, walls): &&(usize, Vec<Wall>)| {
            let high_label = f64::from(self.labels[regions.strands[*i].piece.high_side.face()]);
            let mut alone = walls.iter().filter(|(high, _)| {
                let e = mesh.edge(*high).index();
                uses[e] == 1 && rest[e] == 0.0
            });
            alone.any(|(high, _)| labels[high.face().index()] != high_label)
        };
        walls.iter().filter(is_wrong).map(|(i, _)| *i).collect()
    }

    /// Whether labels are unchanged along those edges of the curve where no piece runs or ran.
    pub(super) fn keeps_labels_beside_the_curve(
        &self,
        refined: &Refined,
        walls: &[(usize, Vec<Wall>)],
        regions: &Layer,
        labels: &[f64],
    ) -> Result<bool, NumericError> {
        let mesh = refined.mesh();
        let uses = uses(mesh, walls);
        let mut ran = vec![false; self.mesh.edge_count()];
        for (_, piece, _) in regions.moved() {
            piece.steps.iter().for_each(|s| ran[self.mesh.edge(s.high).index()] = true);
        }
        let keeps = |h: Halfedge| {
            let Some(parent) = refined.parent(h) else { return true };
            let edge = self.mesh.edge(parent);
            let same = labels[h.face().index()] == f64::from(self.labels[parent.face()]);
            self.jump[edge] == 0 || ran[edge.index()] || same
        };
        for e in mesh.edges().filter(|e| uses[e.index()] == 0) {
            check_step(e.index())?;
            if !mesh.edge_halfedges(e).iter().all(|&h| keeps(h)) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns the pieces that take in regions whose label was hardly in doubt: a path around a
    /// limb may be pulled over its end.
    ///
    /// A region between the old and the new path of a piece is too certain if its values are nearer
    /// to the old label than to the new one by more than [`DOUBT`] on average. Regions narrower
    /// than an edge are always accepted.
    pub(super) fn overreaching(
        &self,
        refined: &Refined,
        walls: &[(usize, Vec<Wall>)],
        regions: &Layer,
        labels: &[f64],
        values: &[f64],
        unit: f64,
    ) -> Result<Vec<usize>, NumericError> {
        let mesh = refined.mesh();
        let mut at_wall: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
        for (i, walls) in walls {
            walls.iter().for_each(|(high, _)| at_wall.entry(mesh.edge(*high)).or_default().push(*i));
        }
        let mut at_step: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
        for (i, piece, _) in regions.moved() {
            let edges = piece.steps.iter().map(|s| self.mesh.edge(s.high));
            edges.for_each(|e| at_step.entry(e).or_default().push(i));
        }
        let old = |f: Face| f64::from(self.labels[refined.cut.provenance.face_parent(f)]);
        let mut open: Vec<bool> = mesh.faces().map(|f| labels[f.index()] != old(f)).collect();
        let mut found = BTreeSet::new();
        for first in mesh.faces() {
            if !std::mem::take(&mut open[first.index()]) {
                continue;
            }
            let (mut area, mut certainty) = (0.0, 0.0);
            let mut around: BTreeSet<usize> = BTreeSet::new();
            let mut waiting = vec![first];
            while let Some(f) = waiting.pop() {
                check_step(f.index())?;
                let parent = refined.cut.provenance.face_parent(f);
                let a = face_in(mesh, f, unit).area;
                area += a;
                if let Some(mean) = face_mean(values, f) {
                    let value = mean + self.shift[self.island[parent] as usize];
                    certainty += a * ((value - labels[f.index()]).abs() - (value - old(f)).abs());
                }
                for h in (0..3).map(|k| f.halfedge(k)) {
                    let step = refined.parent(h).and_then(|h| at_step.get(&self.mesh.edge(h)));
                    around.extend(step.into_iter().chain(at_wall.get(&mesh.edge(h))).flatten());
                    if let Neighbour::Twin(other) = mesh.neighbour(h)
                        && std::mem::take(&mut open[other.face().index()])
                    {
                        waiting.push(other.face());
                    }
                }
            }
            // A piece may sweep a strip of the width of its edges, whatever lies there.
            let strip = |i: &usize| {
                let strand = &regions.strands[*i];
                let length = strand.pulled.as_ref().map_or(0.0, |p| p.before / unit);
                length * length / strand.piece.steps.len() as f64
            };
            if certainty > DOUBT * area && area > around.iter().map(strip).sum() {
                found.extend(around);
            }
        }
        Ok(found.into_iter().collect())
    }
}

/// Returns the number of walls on each edge.
fn uses(mesh: &TriangleMesh, walls: &[(usize, Vec<Wall>)]) -> Vec<u32> {
    let mut uses = vec![0u32; mesh.edge_count()];
    walls.iter().flat_map(|(_, walls)| walls).for_each(|(high, _)| uses[mesh.edge(*high).index()] += 1);
    uses
}
