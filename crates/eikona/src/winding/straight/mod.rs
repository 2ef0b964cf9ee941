//! Straightens the completion of a curve.
//!
//! The completion of a curve runs along edges: regions are made of faces, and so are the jumps of
//! the linear program. On the surface such paths zigzag. Each piece of the completion (`pieces.rs`)
//! is therefore straightened (`pull.rs`) to a locally shortest path across faces between the same
//! ends, in its homotopy class relative to the curve, to the boundary and to the ends of other
//! pieces. The mesh is cut along the result (`refined.rs`). Labels and values between the old and
//! the new path change by the height of the jump. This is checked edge by edge; a piece that fails
//! the check stays on edges.
//!
//! Boundaries of regions and nonbounding loops are treated separately, as they may cross each
//! other.

mod checks;
mod layer;
mod pieces;
mod pull;
mod refined;
mod sides;

use crate::Warning;
use crate::cut::{EmbedError, Embedded, EmbeddedCurve, embed_curves};
use crate::winding::decomposition::THRESHOLD;
use crate::winding::labels::face_mean;
use crate::winding::loops::loops_of;
use crate::winding::options::Completion;
use crate::winding::solution::{CompletionReport, Winding};
use eikona_mesh::{Curve, Edge, Face, Located, SurfaceCurves, Vertex};
use eikona_numeric::{NumericError, check_stopped};
use layer::{Freedom, Layer};
use pieces::Jumps;
use refined::{Refined, Wall};

/// Rounds of restricting pieces that fail the checks before all stay on edges.
const ROUNDS: usize = 8;

/// Pieces that would take in too much may not enter faces whose label has at least this margin.
const CERTAIN: f64 = 0.25;

/// The result of straightening.
struct Straight {
    cut: Embedded,
    labels: Vec<f64>,
    /// Values at corners.
    values: Vec<f64>,
    /// Per face, what the move of the nonbounding part adds to the residual function and subtracts
    /// from the winding number.
    moved: Vec<f64>,
    /// The jump of `moved`.
    moved_jump: Vec<f64>,
}

impl Winding {
    /// Straightens the completion. `consistent`: whether all faces are consistently oriented.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    pub(super) fn straightened(
        mut self,
        consistent: bool,
        completion: Completion,
        unit: f64,
    ) -> Result<Winding, NumericError> {
        self.follows_labels = true;
        let mesh = self.mesh.clone();
        let is_curve: Vec<bool> = self.jump.iter().map(|(_, j)| *j != 0).collect();
        check_stopped()?;
        let label_jump = self.label_jumps();
        check_stopped()?;
        let jumps = Jumps { mesh: &mesh, jump: &label_jump, is_curve: &is_curve };
        let mut regions = Layer::of(jumps.pieces());
        let pieces = regions.strands.iter_mut().map(|s| &mut s.piece);
        jumps.extend_to_ends(pieces, |e| {
            let is_bounding = is_curve[e.index()] && self.nonbounding[e].abs() < THRESHOLD;
            is_bounding.then(|| f64::from(self.jump[e]))
        });
        check_stopped()?;
        let loop_jump = self.loop_jumps();
        check_stopped()?;
        let mut loops = Layer::of(Jumps { mesh: &mesh, jump: &loop_jump, is_curve: &is_curve }.pieces());
        let pieces = regions.strands.len() + loops.strands.len();
        if pieces == 0 {
            return Ok(self);
        }
        check_stopped()?;
        let is_certain = |f: Face| self.margin[f] >= CERTAIN;
        loops.pull(&mesh, &is_curve, is_certain, consistent, unit)?;
        let mut straight = None;
        for round in 0..=ROUNDS {
            if round == ROUNDS {
                regions.stay_all();
                loops.stay_all();
            }
            check_stopped()?;
            regions.pull(&mesh, &is_curve, is_certain, consistent, unit)?;
            check_stopped()?;
            if regions.moved().chain(loops.moved()).next().is_none() {
                break;
            }
            straight = self.try_out(&label_jump, &mut regions, &mut loops, completion, unit)?;
            if straight.is_some() {
                break;
            }
        }
        check_stopped()?;
        let mut report = CompletionReport { pieces, ..CompletionReport::default() };
        for layer in [&regions, &loops] {
            report.on_edges += layer.strands.iter().filter(|s| s.freedom == Freedom::OnEdges).count();
            for (_, _, pulled) in layer.moved() {
                report.straightened += 1;
                report.length_before += pulled.before;
                report.length_after += pulled.after;
            }
        }
        if report.on_edges > 0 {
            self.report.warnings.push(Warning::UnstraightenedPieces { count: report.on_edges, of: pieces });
        }
        self.report.completion = Some(report);
        match straight {
            Some(straight) => self.on_cut(straight),
            None => Ok(self),
        }
    }

    /// Returns the jumps of labels at edges of two faces.
    fn label_jumps(&self) -> Vec<f64> {
        let jump = |e| match self.mesh.edge_halfedges(e) {
            &[a, b] => f64::from(self.labels[a.face()]) - f64::from(self.labels[b.face()]),
            _ => 0.0,
        };
        self.mesh.edges().map(jump).collect()
    }

    /// Returns the jumps of the completed nonbounding loops at edges.
    fn loop_jumps(&self) -> Vec<f64> {
        let mut jump = vec![0.0; self.mesh.edge_count()];
        for l in &self.nonbounding_loops {
            for ends in l.vertices.windows(2) {
                if let Some(e) = self.mesh.find_edge(ends[0], ends[1]) {
                    jump[e.index()] += l.jump.copysign(self.nonbounding[e]);
                }
            }
        }
        jump
    }

    /// Cuts the mesh along the straightened pieces and computes labels and values there. `None` if
    /// they contradict a piece, which is then restricted.
    fn try_out(
        &self,
        label_jump: &[f64],
        regions: &mut Layer,
        loops: &mut Layer,
        completion: Completion,
        unit: f64,
    ) -> Result<Option<Straight>, NumericError> {
        let mesh = &self.mesh;
        let walks = self.curves.iter().filter(|c| c.vertices.len() > 1);
        let walks = walks.map(|c| Curve::signed(c.vertices.iter().copied()));
        let new = regions.moved().chain(loops.moved()).filter(|(_, _, p)| p.path.len() > 1);
        let place = |p: &Located| p.to_surface_point(mesh);
        let new = new.map(|(_, _, p)| Curve::signed(p.path.iter().map(place)));
        let curves: Vec<Curve> = walks.chain(new).collect();
        let cut = match embed_curves(mesh, &SurfaceCurves { curves, points: Vec::new() }) {
            Ok(cut) => cut,
            Err(EmbedError::Stopped(stopped)) => return Err(stopped),
            Err(_) => {
                regions.stay_all();
                loops.stay_all();
                return Ok(None);
            }
        };
        check_stopped()?;
        let refined = Refined { before: mesh, cut: &cut };
        let first = self.curves.iter().filter(|c| c.vertices.len() > 1).count();
        let mut paths = cut.curves[first..].iter().map(|c| c.vertices.as_slice());
        let region_walls = walls_of(&refined, regions, &mut paths);
        let loop_walls = walls_of(&refined, loops, &mut paths);
        let (Some(region_walls), Some(loop_walls)) = (region_walls, loop_walls) else {
            return Ok(None);
        };
        check_stopped()?;

        let mut jump = vec![0.0; mesh.edge_count()];
        loops.subtract_moved(mesh, &mut jump);
        let mut moved_jump = refined.jumps(&jump)?;
        check_stopped()?;
        loop_walls.iter().for_each(|(_, walls)| refined.add(walls, &mut moved_jump));
        let Some(moved) = refined.function(&moved_jump, |_| 0.0, unit)? else {
            loops.stay_all();
            return Ok(None);
        };
        check_stopped()?;
        let mut values = refined.values(self.values.as_slice())?;
        // With the nonbounding part subtracted along the curve only, the function is continuous off
        // the curve and does not change.
        if completion == Completion::Full {
            values.iter_mut().enumerate().for_each(|(c, x)| *x -= moved[c / 3]);
        }

        check_stopped()?;
        let mut jump = label_jump.to_vec();
        regions.subtract_moved(mesh, &mut jump);
        let rest = refined.jumps(&jump)?;
        check_stopped()?;
        let mut jump = rest.clone();
        region_walls.iter().for_each(|(_, walls)| refined.add(walls, &mut jump));
        let old_label = |f: Face| f64::from(self.labels[cut.provenance.face_parent(f)]);
        let Some(labels) = refined.function(&jump, old_label, unit)? else {
            regions.stay_all();
            return Ok(None);
        };
        check_stopped()?;
        let crossing = self.crossing(&refined, &region_walls, regions, &rest, &labels);
        check_stopped()?;
        let overreaching = self.overreaching(&refined, &region_walls, regions, &labels, &values, unit)?;
        check_stopped()?;
        if crossing.is_empty() && overreaching.is_empty() {
            if self.keeps_labels_beside_the_curve(&refined, &region_walls, regions, &labels)? {
                check_stopped()?;
                return Ok(Some(Straight { labels, values, moved, moved_jump, cut }));
            }
            regions.stay_all();
        }
        for i in overreaching {
            let strand = &mut regions.strands[i];
            match strand.freedom {
                Freedom::Free => strand.freedom = Freedom::Banded,
                Freedom::Banded | Freedom::OnEdges => strand.stay(),
            }
        }
        crossing.into_iter().for_each(|i| regions.strands[i].stay());
        Ok(None)
    }

    /// Returns the result on the mesh that was cut once more.
    fn on_cut(self, straight: Straight) -> Result<Winding, NumericError> {
        let Straight { cut, labels, values, moved, moved_jump } = straight;
        let before = &self.mesh;
        let refined = Refined { before, cut: &cut };
        let mesh = cut.mesh.clone();
        check_stopped()?;
        let mid_parent = |f: Face| cut.provenance.face_parent(f);
        let mut residual_function = refined.values(self.residual_function.as_slice())?;
        check_stopped()?;
        residual_function.iter_mut().enumerate().for_each(|(c, x)| *x += moved[c / 3]);
        check_stopped()?;
        let mut nonbounding = refined.jumps(self.nonbounding.as_slice())?;
        check_stopped()?;
        nonbounding.iter_mut().zip(&moved_jump).for_each(|(t, m)| *t += m);
        let labels: Vec<i32> = labels.iter().map(|l| l.round() as i32).collect();
        let margin = mesh.faces().map(|f| {
            let parent = mid_parent(f);
            let is_whole = cut.provenance.face_parts(parent).len() == 1 && moved[f.index()] == 0.0;
            if is_whole && labels[f.index()] == self.labels[parent] {
                return self.margin[parent];
            }
            let shift = self.shift[self.island[parent] as usize];
            let value = face_mean(&values, f).map_or(f64::NAN, |mean| mean + shift);
            (0.5 - (value - f64::from(labels[f.index()])).abs()).max(0.0)
        });
        let margin: Vec<f64> = margin.collect();
        check_stopped()?;
        let island: Vec<u32> = mesh.faces().map(|f| self.island[mid_parent(f)]).collect();
        let label_jump = |e: Edge| {
            let [a, b] = [0, 1].map(|i| mesh.edge_halfedges(e)[i].face().index());
            f64::from(labels[a] - labels[b])
        };
        check_stopped()?;
        let bounding_loops = loops_of(&mesh, label_jump);
        check_stopped()?;
        let nonbounding_loops = loops_of(&mesh, |e| nonbounding[e.index()]);
        check_stopped()?;
        let jump = refined.jumps(self.jump.as_slice())?;

        let mut walked = cut.curves.iter();
        let mut curves = Vec::with_capacity(self.curves.len());
        let mut parts = Vec::with_capacity(self.curves.len());
        for (curve, part) in self.curves.iter().zip(&self.parts) {
            let Some(walk) = (curve.vertices.len() > 1).then(|| walked.next()).flatten() else {
                curves.push(curve.clone());
                parts.push(part.clone());
                continue;
            };
            let segments = walk.segments.iter().map(|s| curve.segments[*s]).collect();
            parts.push(walk.segments.iter().map(|s| part[*s]).collect());
            curves.push(EmbeddedCurve { vertices: walk.vertices.clone(), segments, ..curve.clone() });
        }
        let uncut = self.uncut.or_else(|| Some(before.clone()));
        check_stopped()?;
        Ok(Winding {
            mesh,
            provenance: self.provenance.then(&cut.provenance),
            values: values.into(),
            labels: labels.into(),
            margin: margin.into(),
            island: island.into(),
            curves,
            jump: jump.into(),
            nonbounding: nonbounding.into(),
            residual_function: residual_function.into(),
            parts,
            bounding_loops,
            nonbounding_loops,
            uncut,
            follows_labels: self.follows_labels,
            shift: self.shift,
            endpoints: self.endpoints,
            report: self.report,
        })
    }
}

/// Returns the walls of all pieces that moved, from their paths on the cut mesh. `None` if the
/// sides of a piece cannot be determined; it then stays on edges.
fn walls_of<'a>(
    refined: &Refined,
    layer: &mut Layer,
    paths: &mut impl Iterator<Item = &'a [Vertex]>,
) -> Option<Vec<(usize, Vec<Wall>)>> {
    let mut walls = Vec::new();
    let mut lost = Vec::new();
    for (i, piece, pulled) in layer.moved() {
        let path = if pulled.path.len() > 1 { paths.next()? } else { &[] };
        match refined.walls(piece, path) {
            Some(found) => walls.push((i, found)),
            None => lost.push(i),
        }
    }
    lost.iter().for_each(|&i| layer.strands[i].stay());
    lost.is_empty().then_some(walls)
}
