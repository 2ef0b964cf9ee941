//! Kinds of damage to the curve of a level set, applied before measuring (SHM section 9.5.3).

use crate::truth::level_set;
use eikona::mesh::random::Random;
use eikona::mesh::{Curve, Face, Neighbour, TriangleMesh, Vertex};
use std::collections::BTreeMap;

/// Kind of damage to a curve. Lengths are in mean edge lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damage {
    /// No damage.
    None,
    /// Noise only: the level set of the distance plus noise of this many edges at each vertex.
    Noise(f64),
    /// About half is missing, in pieces of about this many edges.
    Halved(f64),
    /// The same, with each piece displaced by a normal deviate of this many edges.
    Displaced(f64, f64),
    /// The curve and its offset by this many edges, with half of both missing.
    WithOffset(f64, f64),
    /// The same, with offsets to both sides.
    WithOffsets(f64, f64),
    /// The walk along edges around the inside, and around the inside grown by this many strips of
    /// triangles, with half of both missing.
    WalkAndStrips(f64, usize),
    /// Halved, with noise.
    HalvedNoise(f64, f64),
    /// Halved, with every seventh piece displaced by this many edges and every eleventh reversed.
    Outliers(f64, f64),
    /// The curve and the offsets by -share and +share of the distance range, with half of each
    /// missing.
    Nested(f64, f64),
    /// The same, without gaps.
    NestedWhole(f64),
    /// The curve and a closed curve around a point of it, without gaps: the outlines of two
    /// overlapping regions. The radius is this share of the distance range.
    Crossing(f64),
    /// A single gap of this share of each loop.
    OneGap(f64),
    /// Walks along edges next to the curve, without gaps or halved (in pieces of this many edges).
    EdgeWalk(Option<f64>),
}

/// A curve to damage, and its distance.
pub struct Whole<'a> {
    pub mesh: &'a TriangleMesh,
    pub distance: &'a [f64],
    /// Mean edge length.
    pub edge: f64,
}

impl Whole<'_> {
    /// Returns a function that is negative in the union of the regions that crossing curves
    /// outline.
    pub fn union(&self, damage: Damage, random: &mut Random) -> Option<Vec<f64>> {
        let Damage::Crossing(share) = damage else { return None };
        let range = self.distance.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        let disk = self.disk(share * range, random);
        Some(self.distance.iter().zip(disk).map(|(a, b)| a.min(b)).collect())
    }

    /// Returns a function that is negative within a ball around a vertex next to the curve.
    fn disk(&self, radius: f64, random: &mut Random) -> Vec<f64> {
        let near: Vec<Vertex> =
            self.mesh.vertices().filter(|v| self.distance[v.index()].abs() < self.edge).collect();
        let centre = self.mesh.position(near[random.below(near.len())]);
        let off = |p: &[f64; 3]| (0..3).map(|k| (p[k] - centre[k]).powi(2)).sum::<f64>().sqrt();
        self.mesh.positions().iter().map(|p| off(p) - radius).collect()
    }

    /// Returns a function that is negative at the vertices on the left of the damaged curve, if
    /// that is closed.
    pub fn side(&self, damage: Damage, random: &mut Random) -> Option<Vec<f64>> {
        match damage {
            Damage::None => Some(self.distance.to_vec()),
            Damage::Noise(sigma) => {
                Some(self.distance.iter().map(|d| d + sigma * self.edge * random.normal()).collect())
            }
            Damage::EdgeWalk(None) => {
                let inside = self.inside();
                let all = |v| self.mesh.vertex_corners(v).iter().all(|c| inside[c.face().index()]);
                Some(self.mesh.vertices().map(|v| if all(v) { -1.0 } else { 1.0 }).collect())
            }
            _ => None,
        }
    }

    /// Returns the damaged curves.
    pub fn damaged(&self, damage: Damage, random: &mut Random) -> Vec<Curve> {
        let range = self.distance.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        let at = |level: f64| level_set(self.mesh, self.distance, level);
        let halved = |curves: Vec<Curve>, piece: f64, random: &mut Random| -> Vec<Curve> {
            curves.iter().flat_map(|c| self.halved(c, piece, random)).collect()
        };
        match damage {
            Damage::None => at(0.0),
            Damage::Noise(sigma) => self.noisy(sigma, random),
            Damage::Halved(piece) => halved(at(0.0), piece, random),
            Damage::Displaced(piece, sigma) => {
                self.displaced(piece, random, |_, random| sigma * random.normal())
            }
            Damage::WithOffset(piece, edges) => {
                let mut curves = halved(at(0.0), piece, random);
                curves.extend(halved(at(edges * self.edge), piece, random));
                curves
            }
            Damage::WithOffsets(piece, edges) => {
                [-edges, edges].into_iter().flat_map(|e| halved(at(e * self.edge), piece, random)).collect()
            }
            Damage::WalkAndStrips(piece, strips) => {
                let mut inside = self.inside();
                let mut curves = halved(self.walks(&inside), piece, random);
                (0..strips).for_each(|_| inside = self.grown(&inside));
                curves.extend(halved(self.walks(&inside), piece, random));
                curves
            }
            Damage::HalvedNoise(piece, sigma) => halved(self.noisy(sigma, random), piece, random),
            Damage::Outliers(piece, edges) => {
                let offset = |i: usize, _: &mut Random| if i % 7 == 3 { edges } else { 0.0 };
                let mut curves = self.displaced(piece, random, offset);
                for (i, curve) in curves.iter_mut().enumerate() {
                    if i % 11 == 5 {
                        *curve = std::mem::take(curve).reversed();
                    }
                }
                curves
            }
            Damage::Nested(piece, share) => {
                [-share, 0.0, share].into_iter().flat_map(|s| halved(at(s * range), piece, random)).collect()
            }
            Damage::NestedWhole(share) => {
                [-share, 0.0, share].into_iter().flat_map(|s| at(s * range)).collect()
            }
            Damage::Crossing(share) => {
                let disk = self.disk(share * range, random);
                [at(0.0), level_set(self.mesh, &disk, 0.0)].concat()
            }
            Damage::OneGap(share) => at(0.0).iter().flat_map(|c| self.gap(c, share, random)).collect(),
            Damage::EdgeWalk(piece) => {
                let walks = self.walks(&self.inside());
                match piece {
                    Some(piece) => halved(walks, piece, random),
                    None => walks,
                }
            }
        }
    }

    fn noisy(&self, sigma: f64, random: &mut Random) -> Vec<Curve> {
        let noisy: Vec<f64> = self.distance.iter().map(|d| d + sigma * self.edge * random.normal()).collect();
        level_set(self.mesh, &noisy, 0.0)
    }

    fn positions(&self, curve: &Curve) -> Vec<[f64; 3]> {
        curve.nodes.iter().map(|p| p.locate(self.mesh).unwrap().position(self.mesh)).collect()
    }

    /// Returns the arc length at each node.
    fn arc(&self, curve: &Curve) -> Vec<f64> {
        let p = self.positions(curve);
        let mut arc = vec![0.0];
        for w in p.windows(2) {
            let step = (0..3).map(|k| (w[1][k] - w[0][k]).powi(2)).sum::<f64>().sqrt();
            arc.push(arc[arc.len() - 1] + step);
        }
        arc
    }

    /// Returns intervals of random length, about `piece` edges, between gaps of random length with
    /// the same total.
    fn intervals(&self, length: f64, piece: f64, random: &mut Random) -> Vec<[f64; 2]> {
        let count = ((length / self.edge / (2.0 * piece)).round() as usize).max(1);
        let mut lengths = || -> Vec<f64> {
            let lengths: Vec<f64> = (0..count).map(|_| random.range(0.25, 1.75)).collect();
            let total: f64 = lengths.iter().sum();
            lengths.iter().map(|l| 0.5 * length * l / total).collect()
        };
        let (pieces, gaps) = (lengths(), lengths());
        let mut at = 0.0;
        let mut intervals = Vec::new();
        for (piece, gap) in pieces.into_iter().zip(gaps) {
            intervals.push([at, at + piece]);
            at += piece + gap;
        }
        intervals
    }

    /// Returns a closed curve with a random first node.
    fn rotated(&self, curve: &Curve, random: &mut Random) -> Curve {
        if !curve.is_closed() {
            return curve.clone();
        }
        let n = curve.nodes.len() - 1;
        let start = random.below(n);
        Curve::signed((0..=n).map(|i| curve.nodes[(start + i) % n]))
    }

    fn between(&self, curve: &Curve, arc: &[f64], [from, to]: [f64; 2]) -> Option<Curve> {
        let nodes: Vec<_> =
            (0..arc.len()).filter(|&i| from <= arc[i] && arc[i] <= to).map(|i| curve.nodes[i]).collect();
        (nodes.len() > 1).then(|| Curve::signed(nodes))
    }

    fn halved(&self, curve: &Curve, piece: f64, random: &mut Random) -> Vec<Curve> {
        let curve = self.rotated(curve, random);
        let arc = self.arc(&curve);
        let intervals = self.intervals(arc[arc.len() - 1], piece, random);
        intervals.into_iter().filter_map(|interval| self.between(&curve, &arc, interval)).collect()
    }

    fn gap(&self, curve: &Curve, share: f64, random: &mut Random) -> Option<Curve> {
        let curve = self.rotated(curve, random);
        let arc = self.arc(&curve);
        self.between(&curve, &arc, [0.0, (1.0 - share) * arc[arc.len() - 1]])
    }

    /// Halves the curve and replaces every piece by the part of the level set at its own offset (in
    /// edges) that lies closest to it.
    fn displaced(
        &self,
        piece: f64,
        random: &mut Random,
        offset: impl Fn(usize, &mut Random) -> f64,
    ) -> Vec<Curve> {
        let whole: Vec<Curve> =
            level_set(self.mesh, self.distance, 0.0).iter().map(|c| self.rotated(c, random)).collect();
        let arcs: Vec<Vec<f64>> = whole.iter().map(|c| self.arc(c)).collect();
        let places: Vec<(usize, f64, [f64; 3])> = whole
            .iter()
            .enumerate()
            .flat_map(|(c, curve)| {
                let arc = &arcs[c];
                self.positions(curve)
                    .into_iter()
                    .enumerate()
                    .map(move |(i, p)| (c, arc[i], p))
                    .collect::<Vec<_>>()
            })
            .collect();
        let mut result = Vec::new();
        let mut number = 0;
        for (c, arc) in arcs.iter().enumerate() {
            for [from, to] in self.intervals(arc[arc.len() - 1], piece, random) {
                let level = offset(number, random) * self.edge;
                number += 1;
                if level == 0.0 {
                    result.extend(self.between(&whole[c], arc, [from, to]));
                    continue;
                }
                for curve in level_set(self.mesh, self.distance, level) {
                    let mut run = Vec::new();
                    for (node, p) in curve.nodes.iter().zip(self.positions(&curve)) {
                        let off = |q: [f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>();
                        let nearest = places.iter().min_by(|a, b| off(a.2).total_cmp(&off(b.2)));
                        let belongs = nearest.is_some_and(|&(d, s, q)| {
                            d == c && from <= s && s <= to && off(q).sqrt() < 1.5 * level.abs() + self.edge
                        });
                        if belongs {
                            run.push(*node);
                        } else if run.len() > 1 {
                            result.push(Curve::signed(std::mem::take(&mut run)));
                        } else {
                            run.clear();
                        }
                    }
                    if run.len() > 1 {
                        result.push(Curve::signed(run));
                    }
                }
            }
        }
        result
    }

    fn inside(&self) -> Vec<bool> {
        let sum = |f: Face| self.mesh.face_vertices(f).iter().map(|v| self.distance[v.index()]).sum::<f64>();
        self.mesh.faces().map(|f| sum(f) < 0.0).collect()
    }

    /// Returns the region with a strip of triangles around it.
    fn grown(&self, inside: &[bool]) -> Vec<bool> {
        let mut result = inside.to_vec();
        for v in self.mesh.vertices() {
            let corners = self.mesh.vertex_corners(v);
            if corners.iter().any(|c| inside[c.face().index()]) {
                corners.iter().for_each(|c| result[c.face().index()] = true);
            }
        }
        result
    }

    /// Returns the boundary of a region, as closed walks along edges with the region on the left.
    fn walks(&self, inside: &[bool]) -> Vec<Curve> {
        let mut leaving: BTreeMap<Vertex, Vec<Vertex>> = BTreeMap::new();
        for f in self.mesh.faces().filter(|f| inside[f.index()]) {
            let corners = self.mesh.face_vertices(f);
            for k in 0..3 {
                if let Neighbour::Twin(h) = self.mesh.neighbour(f.halfedge(k))
                    && !inside[h.face().index()]
                {
                    leaving.entry(corners[k]).or_default().push(corners[(k + 1) % 3]);
                }
            }
        }
        let starts: Vec<Vertex> = leaving.keys().copied().collect();
        let mut walks = Vec::new();
        for start in starts {
            loop {
                let mut walk = vec![start];
                while let Some(to) = leaving.get_mut(walk.last().unwrap()).and_then(Vec::pop) {
                    walk.push(to);
                }
                if walk.len() == 1 {
                    break;
                }
                walks.push(Curve::signed(walk));
            }
        }
        walks
    }
}
