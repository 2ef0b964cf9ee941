//! The completed curve made smooth.
//!
//! What completes a curve runs along edges: regions are made of faces, and so are the jumps of the linear program. That is right for the
//! mesh, but zigzags on the surface. Here each piece of the completion (`pieces.rs`) is pulled straight (`pull.rs`), its ends
//! fixed, to a shortest path across faces in its homotopy class relative to the curve, to the boundary and to the ends of other pieces.
//! The mesh is cut along the result (`refined.rs`), and labels and values follow: between the old path and the new one they change by the
//! height of the jump. That they do is checked edge by edge; a piece for which it fails stays on edges.
//!
//! Boundaries of regions and nonbounding loops are treated apart, as they may cross each other.

mod pieces;
mod pull;
mod refined;
mod sides;

use crate::contour::{Embedded, EmbeddedCurve, embed_curves, places_of_places};
use crate::winding::labels::face_mean;
use crate::winding::loops::loops_of;
use crate::winding::options::Completion;
use crate::winding::solution::{CompletionReport, Winding};
use crate::wording::counted;
use eikona_mesh::{Curve, Edge, Face, Located, SurfaceCurves, TriangleMesh, Vertex};
use pieces::{Jumps, Piece};
use pull::{Pulled, Slit};
use refined::{Refined, Wall};

/// Rounds in which pieces that cross others are put back on edges, before all are.
const ROUNDS: usize = 8;

/// Pieces of one kind: boundaries of regions, or nonbounding loops.
struct Layer {
    pieces: Vec<Piece>,
    fixed: Vec<Vertex>,
    /// Pieces that stay on edges as others would have to be crossed.
    stays: Vec<bool>,
    pulled: Vec<Option<Pulled>>,
}

impl Layer {
    fn of(mesh: &TriangleMesh, jump: &[f64], is_curve: &[bool]) -> Layer {
        let (pieces, fixed) = Jumps { mesh, jump, is_curve }.pieces();
        Layer { stays: vec![false; pieces.len()], pulled: vec![None; pieces.len()], pieces, fixed }
    }

    /// Pulls all pieces straight that may move; the others are in their way.
    fn pull(&mut self, mesh: &TriangleMesh, is_curve: &[bool], consistent: bool, unit: f64) {
        let mut closed = is_curve.to_vec();
        for (piece, _) in self.pieces.iter().zip(&self.stays).filter(|(_, stays)| **stays) {
            piece.steps.iter().for_each(|s| closed[mesh.edge(s.high).index()] = true);
        }
        self.pulled.fill(None);
        if self.stays.iter().all(|stays| *stays) {
            return;
        }
        let Ok(slit) = Slit::new(mesh, &closed, &self.fixed, unit) else {
            self.stays.fill(true);
            return;
        };
        for (i, piece) in self.pieces.iter().enumerate() {
            if self.stays[i] {
                continue;
            }
            match slit.pull(mesh, piece, !consistent) {
                Ok(pulled) => self.pulled[i] = pulled,
                Err(_) => self.stays[i] = true,
            }
        }
    }

    /// The pieces that moved.
    fn moved(&self) -> impl Iterator<Item = (usize, &Piece, &Pulled)> {
        let all = self.pieces.iter().zip(&self.pulled).enumerate();
        all.filter_map(|(i, (piece, pulled))| pulled.as_ref().map(|p| (i, piece, p)))
    }

    /// Takes the pieces that moved off jumps at edges.
    fn take_off(&self, mesh: &TriangleMesh, jump: &mut [f64]) {
        for (_, piece, _) in self.moved() {
            for step in &piece.steps {
                let e = mesh.edge(step.high);
                let is_first = mesh.edge_halfedges(e)[0] == step.high;
                jump[e.index()] -= if is_first { piece.height } else { -piece.height };
            }
        }
    }
}

/// What came of it.
struct Straight {
    cut: Embedded,
    labels: Vec<f64>,
    /// What is taken off the winding number in each face, as the nonbounding part moves.
    moved: Vec<f64>,
    /// The jump of `moved`.
    moved_jump: Vec<f64>,
}

impl Winding {
    /// With the completion pulled straight. `consistent`: whether all faces are wound alike.
    pub(super) fn straightened(mut self, consistent: bool, completion: Completion, unit: f64) -> Winding {
        self.parents.follows_labels = true;
        let mesh = self.mesh.clone();
        let is_curve: Vec<bool> = self.jump.iter().map(|(_, j)| *j != 0).collect();
        let label_jump = self.label_jumps();
        let mut regions = Layer::of(&mesh, &label_jump, &is_curve);
        let jumps = Jumps { mesh: &mesh, jump: &label_jump, is_curve: &is_curve };
        jumps.extend_to_ends(&mut regions.pieces, |e| {
            let is_bounding = is_curve[e.index()] && self.nonbounding[e].abs() < TAIL_BOUNDS;
            is_bounding.then(|| f64::from(self.jump[e]))
        });
        let mut loops = Layer::of(&mesh, &self.loop_jumps(), &is_curve);
        let pieces = regions.pieces.len() + loops.pieces.len();
        if pieces == 0 {
            return self;
        }
        loops.pull(&mesh, &is_curve, consistent, unit);
        let mut straight = None;
        for round in 0..=ROUNDS {
            if round == ROUNDS {
                regions.stays.fill(true);
                loops.stays.fill(true);
                loops.pulled.fill(None);
            }
            regions.pull(&mesh, &is_curve, consistent, unit);
            if regions.moved().chain(loops.moved()).next().is_none() {
                break;
            }
            straight = self.try_out(&label_jump, &mut regions, &mut loops, unit);
            if straight.is_some() {
                break;
            }
        }
        let mut report = CompletionReport { pieces, ..CompletionReport::default() };
        for layer in [&regions, &loops] {
            report.kept += layer.stays.iter().filter(|stays| **stays).count();
            for (_, _, pulled) in layer.moved() {
                report.straightened += 1;
                report.length_before += pulled.before;
                report.length_after += pulled.after;
            }
        }
        if report.kept > 0 {
            let kept = counted(report.kept, "piece", "pieces");
            self.report.warnings.push(format!(
                "{kept} of the completed curve (of {pieces}) stay on edges of the mesh: straight, they would cross other parts of it \
                 or vanish; refine the mesh there for a smoother boundary"
            ));
        }
        self.report.completion = Some(report);
        match straight {
            Some(straight) => self.on_cut(straight, completion, unit),
            None => self,
        }
    }

    /// The jumps of labels at edges of two faces.
    fn label_jumps(&self) -> Vec<f64> {
        let jump = |e| match self.mesh.edge_halfedges(e) {
            &[a, b] => f64::from(self.labels[a.face()]) - f64::from(self.labels[b.face()]),
            _ => 0.0,
        };
        self.mesh.edges().map(jump).collect()
    }

    /// The jumps of the completed nonbounding loops at edges.
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

    /// Cuts the mesh along the straightened pieces and finds labels and values there. `None` if they contradict a piece: that is
    /// marked as one that stays.
    fn try_out(
        &self,
        label_jump: &[f64],
        regions: &mut Layer,
        loops: &mut Layer,
        unit: f64,
    ) -> Option<Straight> {
        let mesh = &self.mesh;
        let keep_all = |layer: &mut Layer| {
            layer.stays.fill(true);
            layer.pulled.fill(None);
        };
        let walks = self.curves.iter().filter(|c| c.vertices.len() > 1);
        let walks = walks.map(|c| Curve::signed(c.vertices.iter().copied()));
        let new = regions.moved().chain(loops.moved()).filter(|(_, _, p)| p.path.len() > 1);
        let place = |p: &Located| p.to_surface_point(mesh);
        let new = new.map(|(_, _, p)| Curve::signed(p.path.iter().map(place)));
        let curves: Vec<Curve> = walks.chain(new).collect();
        let Ok(cut) = embed_curves(mesh, &SurfaceCurves { curves, points: Vec::new() }) else {
            keep_all(regions);
            keep_all(loops);
            return None;
        };
        let refined = Refined { before: mesh, cut: &cut };
        let mut next = self.curves.iter().filter(|c| c.vertices.len() > 1).count();
        let mut walls_of = |layer: &mut Layer| -> Vec<(usize, Vec<Wall>)> {
            let mut found = Vec::new();
            let mut lost = Vec::new();
            for (i, piece, pulled) in layer.moved() {
                let mut walls = Some(Vec::new());
                if pulled.path.len() > 1 {
                    walls = refined.walls(piece, &cut.curves[next].vertices);
                    next += 1;
                }
                match walls {
                    Some(walls) => found.push((i, walls)),
                    None => lost.push(i),
                }
            }
            lost.into_iter().for_each(|i| {
                layer.stays[i] = true;
                layer.pulled[i] = None;
            });
            found
        };
        let count = |layer: &Layer| layer.moved().count();
        let all = count(regions) + count(loops);
        let region_walls = walls_of(regions);
        let loop_walls = walls_of(loops);
        if count(regions) + count(loops) < all {
            return None;
        }

        let mut jump = label_jump.to_vec();
        regions.take_off(mesh, &mut jump);
        let rest = refined.jumps(&jump);
        let mut jump = rest.clone();
        region_walls.iter().for_each(|(_, walls)| refined.add(walls, &mut jump));
        let old_label = |f: Face| f64::from(self.labels[cut.face_parent[f.index()]]);
        let Some(labels) = refined.function(&jump, old_label, unit) else {
            keep_all(regions);
            return None;
        };
        let contradicted = self.contradicted(&refined, regions, &region_walls, &rest, &labels);
        match contradicted {
            Some(pieces) if pieces.is_empty() => {}
            Some(pieces) => {
                pieces.into_iter().for_each(|i| regions.stays[i] = true);
                return None;
            }
            None => {
                keep_all(regions);
                return None;
            }
        }

        let mut jump = vec![0.0; mesh.edge_count()];
        loops.take_off(mesh, &mut jump);
        let mut moved_jump = refined.jumps(&jump);
        loop_walls.iter().for_each(|(_, walls)| refined.add(walls, &mut moved_jump));
        let Some(moved) = refined.function(&moved_jump, |_| 0.0, unit) else {
            keep_all(loops);
            return None;
        };
        Some(Straight { labels, moved, moved_jump, cut })
    }

    /// The pieces on whose sides the labels are not what they were; `None` if the labels beside the curve changed, where no piece is.
    fn contradicted(
        &self,
        refined: &Refined,
        regions: &Layer,
        walls: &[(usize, Vec<Wall>)],
        rest: &[f64],
        labels: &[f64],
    ) -> Option<Vec<usize>> {
        let mesh = refined.mesh();
        let mut uses = vec![0u32; mesh.edge_count()];
        for (high, _) in walls.iter().flat_map(|(_, walls)| walls) {
            uses[mesh.edge(*high).index()] += 1;
        }
        let mut contradicted = Vec::new();
        for (i, walls) in walls {
            let high_label = f64::from(self.labels[regions.pieces[*i].high_side.face()]);
            let alone = |h: &Wall| {
                let e = mesh.edge(h.0).index();
                uses[e] == 1 && rest[e] == 0.0
            };
            if walls.iter().filter(|w| alone(w)).any(|(high, _)| labels[high.face().index()] != high_label) {
                contradicted.push(*i);
            }
        }
        if !contradicted.is_empty() {
            return Some(contradicted);
        }
        // Edges of the curve along which no piece runs, nor ran.
        let mut ran = vec![false; self.mesh.edge_count()];
        for (_, piece, _) in regions.moved() {
            piece.steps.iter().for_each(|s| ran[self.mesh.edge(s.high).index()] = true);
        }
        let is_fine = |e: Edge| {
            let halfedges = mesh.edge_halfedges(e);
            uses[e.index()] > 0
                || halfedges.iter().all(|&h| {
                    let Some(parent) = refined.parent(h) else { return true };
                    let edge = self.mesh.edge(parent);
                    let same = labels[h.face().index()] == f64::from(self.labels[parent.face()]);
                    self.jump[edge] == 0 || ran[edge.index()] || same
                })
        };
        mesh.edges().all(is_fine).then_some(contradicted)
    }

    /// The result on the mesh that was cut once more.
    fn on_cut(self, straight: Straight, completion: Completion, unit: f64) -> Winding {
        let Straight { cut, labels, moved, moved_jump } = straight;
        let before = &self.mesh;
        let refined = Refined { before, cut: &cut };
        let mesh = cut.mesh.clone();
        let mid_parent = |f: Face| cut.face_parent[f.index()];
        let shift_by = |values: Vec<f64>, sign: f64| -> Vec<f64> {
            values.into_iter().enumerate().map(|(c, x)| x + sign * moved[c / 3]).collect()
        };
        let mut values = refined.values(self.values.as_slice());
        // Off the curve the function is continuous there, so nothing moves.
        if completion == Completion::Full {
            values = shift_by(values, -1.0);
        }
        let residual_function = shift_by(refined.values(self.residual_function.as_slice()), 1.0);
        let mut nonbounding = refined.jumps(self.nonbounding.as_slice());
        nonbounding.iter_mut().zip(&moved_jump).for_each(|(t, m)| *t += m);
        let labels: Vec<i32> = labels.iter().map(|l| l.round() as i32).collect();
        let pieces_of = pieces_of_faces(before, &cut);
        let margin = mesh.faces().map(|f| {
            let parent = mid_parent(f);
            let is_whole = pieces_of[parent.index()] == 1 && moved[f.index()] == 0.0;
            if is_whole && labels[f.index()] == self.labels[parent] {
                return self.margin[parent];
            }
            let shift = self.shift[self.component[parent] as usize];
            let value = face_mean(&values, f).map_or(f64::NAN, |mean| mean + shift);
            (0.5 - (value - f64::from(labels[f.index()])).abs()).max(0.0)
        });
        let margin: Vec<f64> = margin.collect();
        let component: Vec<u32> = mesh.faces().map(|f| self.component[mid_parent(f)]).collect();
        let label_jump = |e: Edge| {
            let [a, b] = [0, 1].map(|i| mesh.edge_halfedges(e)[i].face().index());
            f64::from(labels[a] - labels[b])
        };
        let bounding_loops = loops_of(&mesh, label_jump);
        let nonbounding_loops = loops_of(&mesh, |e| nonbounding[e.index()]);
        let jump = refined.jumps(self.jump.as_slice());

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
        let mut parents = self.parents;
        parents.cut = Some(match parents.cut {
            Some((input, places)) => {
                let places = places_of_places(&input, &self.face_parent, &places, &cut);
                (input, places)
            }
            None => (before.clone(), cut.vertex_place.clone()),
        });
        let face_parent = cut.face_parent.iter().map(|f| self.face_parent[f.index()]).collect();
        let _ = unit;
        Winding {
            mesh,
            face_parent,
            values: values.into(),
            labels: labels.into(),
            margin: margin.into(),
            component: component.into(),
            curves,
            jump: jump.into(),
            nonbounding: nonbounding.into(),
            residual_function: residual_function.into(),
            parts,
            bounding_loops,
            nonbounding_loops,
            parents,
            shift: self.shift,
            endpoints: self.endpoints,
            report: self.report,
        }
    }
}

/// Tails of the curve may have this much of a nonbounding jump.
const TAIL_BOUNDS: f64 = 0.1;

fn pieces_of_faces(before: &TriangleMesh, cut: &Embedded) -> Vec<u32> {
    let mut count = vec![0; before.face_count()];
    cut.face_parent.iter().for_each(|f| count[f.index()] += 1);
    count
}
