//! The field as N vectors per face, on its own mesh or on one that is split at singular points.
//!
//! Formats with one vector set per face hold a singularity only at a vertex, and only if the field
//! turns by less than half a turn of its N-th power from each face around it to the next.
//! [`PolarField::split`] makes both true: singular points inside edges and faces become vertices,
//! and wide corners at singular points are divided into narrower ones.

use crate::cut::{Embedded, embed_curves};
use crate::geometry::vector::{dot, norm, sub};
use crate::polar_field::bevel::BeveledMesh;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::inspection::{FaceVectors, Match};
use crate::polar_field::solution::PolarField;
use eikona_mesh::{
    Curve, Edge, Face, Halfedge, Located, Neighbour, Provenance, SurfaceCurves, SurfacePoint, TriangleMesh,
    Vertex,
};
use eikona_numeric::check_step;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::{PI, TAU};

/// A field sampled once per face.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SampledField {
    /// The mesh of the samples.
    pub mesh: TriangleMesh,
    /// Where its vertices and faces lie on the mesh of the field.
    pub provenance: Provenance,
    /// The point of each face at which the field is sampled.
    pub places: Vec<[f64; 3]>,
    /// N unit vectors per face, counter-clockwise, and how they continue each other across edges.
    pub vectors: FaceVectors,
    /// The vertices with a prescribed index other than zero, with that index.
    pub singular_vertices: Vec<(Vertex, f64)>,
    /// Number of prescribed singular points that are not vertices of the mesh: zero once split.
    pub left_out: usize,
    /// Edges at which the N-th power turns by half a turn or more from face to face. Programs that
    /// match vectors by the smallest rotation see other indices at their ends: give them the
    /// matching, or refine the mesh there.
    pub steep_edges: Vec<Edge>,
}

/// Angle of a corner at a point of index 1/N beyond which it is divided; at a point of index k/N,
/// beyond a k-th of it. Vectors on the bisectors of two such corners are less than half a turn of
/// the N-th power apart, with room for fields that turn unevenly.
const WIDEST_CORNER: f64 = 0.7 * PI;

/// Turn of the N-th power from one sample to the next, at a singular point, beyond which both
/// corners are divided: half a turn is counted wrongly.
const STEEP: f64 = 0.9 * PI;

/// Most parts of a corner, and most times that a mesh is split again.
const MOST_PARTS: u32 = 32;
const MOST_ROUNDS: usize = 8;

impl PolarField {
    /// Samples the field at the centroid of each face.
    ///
    /// The matching follows the field through the middle of each edge, with the rotations that were
    /// solved for, so rotations are counted right however large they are.
    ///
    /// # Errors
    /// [`PolarFieldError::Numeric`] if an observer stops it.
    ///
    /// # Cost
    /// O(N F).
    pub fn per_face(&self) -> Result<SampledField, PolarFieldError> {
        let mesh = self.mesh().clone();
        let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count());
        let of_points = self.singular_points().map(|(located, _)| match located {
            Located::Vertex(v) => Some(v),
            _ => None,
        });
        Sampling::new(self, &mesh, &provenance, centroid).run(of_points.collect())
    }

    /// Samples the field on a mesh that has each singular point as a vertex.
    ///
    /// Singular faces are split into three around their point, the faces at a singular edge into
    /// two each, and corners at singular points that are too wide into several. Vectors are taken
    /// at the incenters: matched by the smallest rotation, as most programs do, they then show the
    /// prescribed indices, unless the field turns very unevenly around a point.
    ///
    /// # Errors
    /// [`PolarFieldError::Split`] if singular points are too close together to be separated;
    /// [`PolarFieldError::Numeric`] if an observer stops it.
    ///
    /// # Cost
    /// O(N F).
    ///
    /// ```
    /// use eikona::mesh::{SurfacePoint, Vertex, shapes};
    /// use eikona::polar_field::{FieldOptions, Place, Singularity, Solver, inspect_field};
    /// let disk = shapes::disk(6, 12, 1.0)?;
    /// let [i, j, k] = disk.triangles()[40];
    /// let point = SurfacePoint::Face { vertices: [i, j, k], bary: [0.2, 0.5, 0.3] };
    /// let singularities = [
    ///     Singularity { place: Place::Point(point), index: 0.25 },
    ///     Singularity { place: Place::Boundary(0), index: 0.75 },
    /// ];
    /// let solver = Solver::new(&disk, &Default::default())?;
    /// let split = solver.solve(&singularities, &FieldOptions::default())?.split()?;
    /// let [(vertex, index)] = split.singular_vertices[..] else { panic!() };
    /// assert!(vertex >= Vertex(disk.vertex_count() as u32) && index == 0.25);
    /// let seen = inspect_field(&split.mesh, &split.vectors)?;
    /// assert_eq!(seen.vertices, split.singular_vertices);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn split(&self) -> Result<SampledField, PolarFieldError> {
        let mut spokes = Spokes::new(&self.domain.bevel, self.singular_points());
        loop {
            let Embedded { mesh, provenance, points, .. } = embed_curves(self.mesh(), &spokes.curves())?;
            let sampling = Sampling::new(self, &mesh, &provenance, incenter);
            let of_points = &points[..spokes.hubs.len()];
            let steep = sampling.steep(of_points)?;
            if !spokes.refine(steep) {
                return sampling.run(of_points.iter().copied().map(Some).collect());
            }
        }
    }

    /// Returns the points with an index other than zero, with the index times N.
    pub(super) fn singular_points(&self) -> impl Iterator<Item = (Located, i64)> {
        let points = self.singular.iter().filter(|s| s.turns != 0);
        points.filter_map(|s| Some((s.point?, s.turns)))
    }
}

/// Segments from singular points (hubs) to the opposite sides of the faces around them.
struct Spokes<'a> {
    bevel: &'a BeveledMesh,
    hubs: Vec<Located>,
    /// Number of parts of each corner at a hub, which is given by the side opposite to it.
    parts: BTreeMap<(usize, Halfedge), u32>,
    /// More points at which the mesh is split.
    middles: Vec<SurfacePoint>,
    /// Number of steep edges that ended at no hub in the first round.
    steep_edges: Option<usize>,
    rounds: usize,
}

/// Where the power turns too far from sample to sample.
#[derive(Default)]
struct Steep {
    /// Corners at hubs: hub and opposite side.
    corners: BTreeSet<(usize, Halfedge)>,
    /// The middles of edges that end at no hub.
    middles: Vec<SurfacePoint>,
}

impl<'a> Spokes<'a> {
    /// Divides corners that are wider than [`WIDEST_CORNER`] over the index times N.
    fn new(bevel: &'a BeveledMesh, points: impl Iterator<Item = (Located, i64)>) -> Spokes<'a> {
        let mesh = &bevel.mesh;
        let mut spokes = Spokes {
            bevel,
            hubs: Vec::new(),
            parts: BTreeMap::new(),
            middles: Vec::new(),
            steep_edges: None,
            rounds: 0,
        };
        for (hub, (located, turns)) in points.enumerate() {
            spokes.hubs.push(located);
            // On a cone, the field turns faster or more slowly than its corners add up.
            let (sides, whole): (Vec<Halfedge>, f64) = match located {
                Located::Face(f, _) => ([0, 1, 2].map(|k| f.halfedge(k)).to_vec(), TAU),
                Located::Edge(e, _) => {
                    let at_edge = mesh.edge_halfedges(e).iter();
                    (at_edge.flat_map(|h| [h.next(), h.previous()]).collect(), TAU)
                }
                Located::Vertex(v) => {
                    let corners = mesh.vertex_corners(v).iter().map(|c| c.halfedge());
                    (corners.clone().map(|h| h.next()).collect(), corners.map(|h| bevel.angle(h)).sum())
                }
            };
            for side in sides {
                let angle = spokes.corner(hub, side).1 * TAU / whole;
                let parts = (turns.unsigned_abs() as f64 * angle / WIDEST_CORNER).ceil();
                spokes.parts.insert((hub, side), parts.clamp(1.0, f64::from(MOST_PARTS)) as u32);
            }
        }
        spokes
    }

    /// Returns the distances of a hub from the ends of a side, and the angle between them.
    fn corner(&self, hub: usize, side: Halfedge) -> ([f64; 2], f64) {
        let mesh = &self.bevel.mesh;
        let centre = self.hubs[hub].position(mesh);
        let [p, q] = [mesh.origin(side), mesh.tip(side)].map(|v| sub(mesh.position(v), centre));
        let lengths = [norm(p), norm(q)];
        (lengths, (dot(p, q) / (lengths[0] * lengths[1])).clamp(-1.0, 1.0).acos())
    }

    /// Returns the hubs as points, and the spokes.
    fn curves(&self) -> SurfaceCurves {
        let mesh = &self.bevel.mesh;
        let hubs: Vec<SurfacePoint> = self.hubs.iter().map(|hub| hub.to_surface_point(mesh)).collect();
        let mut curves = Vec::new();
        for (&(hub, side), &parts) in &self.parts {
            let (lengths, angle) = self.corner(hub, side);
            for part in 1..parts {
                let ahead = angle * f64::from(part) / f64::from(parts);
                let [x, y] = [lengths[0] * ahead.sin(), lengths[1] * (angle - ahead).sin()];
                let vertices = [mesh.origin(side).0, mesh.tip(side).0];
                let end = SurfacePoint::Edge { vertices, t: x / (x + y) };
                curves.push(Curve::unsigned([hubs[hub], end]));
            }
        }
        SurfaceCurves { curves, points: hubs.into_iter().chain(self.middles.iter().copied()).collect() }
    }

    /// Doubles the parts of steep corners, up to [`MOST_PARTS`], and splits steep edges. Returns
    /// whether the mesh has to be split again.
    fn refine(&mut self, steep: Steep) -> bool {
        // Where a power is too high for any mesh, halves of steep edges are as steep.
        let count = steep.middles.len();
        let at_first = *self.steep_edges.get_or_insert(count);
        let mut changed = (1..=2 * at_first).contains(&count);
        if changed {
            self.middles.extend(steep.middles);
        }
        for corner in steep.corners {
            if let Some(parts) = self.parts.get_mut(&corner).filter(|parts| **parts < MOST_PARTS) {
                *parts = (2 * *parts).min(MOST_PARTS);
                changed = true;
            }
        }
        self.rounds += 1;
        changed && self.rounds < MOST_ROUNDS
    }
}

/// Weights of the point at which a face is sampled.
fn centroid(_: [[f64; 3]; 3]) -> [f64; 3] {
    [1.0 / 3.0; 3]
}

/// The bisectors of all three corners meet here.
fn incenter([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let sides = [sub(c, b), sub(a, c), sub(b, a)].map(norm);
    let sum: f64 = sides.iter().sum();
    sides.map(|x| x / sum)
}

/// How far the power turns from a sample to the next.
struct Turn {
    whole: f64,
    /// Across the edge, between faces of the field's mesh.
    jump: f64,
    /// How far the layouts of these faces are turned against each other.
    layout: f64,
}

/// Samples a field on a mesh whose faces are parts of those of the field.
struct Sampling<'a> {
    field: &'a PolarField,
    mesh: &'a TriangleMesh,
    provenance: &'a Provenance,
    place: fn([[f64; 3]; 3]) -> [f64; 3],
    /// Parameters of the singular points on edges of the field's mesh.
    on_edges: HashMap<Edge, f64>,
}

impl<'a> Sampling<'a> {
    fn new(
        field: &'a PolarField,
        mesh: &'a TriangleMesh,
        provenance: &'a Provenance,
        place: fn([[f64; 3]; 3]) -> [f64; 3],
    ) -> Self {
        let on_edge = |(located, _)| match located {
            Located::Edge(e, t) => Some((e, t)),
            _ => None,
        };
        let on_edges = field.singular_points().filter_map(on_edge).collect();
        Sampling { field, mesh, provenance, place, on_edges }
    }

    /// Samples the field. `of_points` are the vertices at its singular points.
    fn run(self, of_points: Vec<Option<Vertex>>) -> Result<SampledField, PolarFieldError> {
        let Sampling { field, mesh, provenance, .. } = self;
        let degree = field.degree();
        let mut places = Vec::with_capacity(mesh.face_count());
        let mut vectors = Vec::with_capacity(degree as usize * mesh.face_count());
        for face in mesh.faces() {
            check_step(face.index())?;
            let corners = mesh.face_positions(face);
            let weights = (self.place)(corners);
            let along = |k: usize| corners.iter().zip(weights).map(|(p, w)| p[k] * w).sum();
            places.push([0, 1, 2].map(along));
            let (parent, weights) = self.in_parent(face, weights);
            vectors.extend(field.vectors_in(parent, weights));
        }
        let (matching, steep_edges) = self.matching()?;
        let left_out = of_points.iter().filter(|v| v.is_none()).count();
        let indices = field.singular_points().map(|(_, turns)| turns as f64 / f64::from(degree));
        let with_index = of_points.into_iter().zip(indices);
        let mut singular_vertices: Vec<(Vertex, f64)> =
            with_index.filter_map(|(v, index)| Some((v?, index))).collect();
        singular_vertices.sort_by_key(|(v, _)| *v);
        Ok(SampledField {
            left_out,
            steep_edges,
            places,
            mesh: mesh.clone(),
            provenance: provenance.clone(),
            vectors: FaceVectors { degree, vectors, matching },
            singular_vertices,
        })
    }

    /// Returns weights in the parent of a face.
    fn in_parent(&self, face: Face, weights: [f64; 3]) -> (Face, [f64; 3]) {
        let parent = self.provenance.face_parent(face);
        let corners = self.field.mesh().face_vertices(parent);
        let mut result = [0.0; 3];
        for (v, weight) in self.mesh.face_vertices(face).into_iter().zip(weights) {
            let place = self.provenance.weights_in(v, corners);
            result.iter_mut().zip(place).for_each(|(sum, x)| *sum += weight * x);
        }
        (parent, result)
    }

    /// Returns the point at which a face is sampled.
    fn sample(&self, face: Face) -> (Face, [f64; 3]) {
        self.in_parent(face, (self.place)(self.mesh.face_positions(face)))
    }

    /// Follows the field from each face to its neighbours through the middle of their edge. Returns
    /// also the edges at which the power turns too far.
    fn matching(&self) -> Result<(Vec<Match>, Vec<Edge>), PolarFieldError> {
        let degree = self.field.degree();
        let (mut matching, mut steep) = (Vec::new(), Vec::new());
        for (step, (h, twin)) in self.edges().enumerate() {
            check_step(step)?;
            let [from, to] = [h, twin].map(|h| self.sample(h.face()));
            let Turn { whole, layout, .. } = self.turn(h, twin);
            if whole.abs() >= PI {
                steep.push(self.mesh.edge(h));
            }
            let [before, after] = [from, to].map(|(face, weights)| self.field.power_at(face, weights).arg());
            let shift = ((before + whole - layout - after) / TAU).round() as i64;
            matching.push(Match {
                faces: [h.face(), twin.face()],
                vertices: Some([self.mesh.origin(h), self.mesh.tip(h)]),
                shift: shift.rem_euclid(i64::from(degree)),
            });
        }
        Ok((matching, steep))
    }

    /// Returns where the power turns too far from sample to sample.
    fn steep(&self, hubs: &[Vertex]) -> Result<Steep, PolarFieldError> {
        let hub_of: HashMap<Vertex, usize> = hubs.iter().enumerate().map(|(hub, &v)| (v, hub)).collect();
        let mut steep = Steep::default();
        for (step, (h, twin)) in self.edges().enumerate() {
            check_step(step)?;
            let Turn { whole, jump, .. } = self.turn(h, twin);
            if jump.abs() > STEEP {
                continue; // A finer mesh has the same jump.
            }
            let ends = [self.mesh.origin(h), self.mesh.tip(h)].map(|v| hub_of.get(&v).copied());
            if let [None, None] = ends {
                if whole.abs() >= PI {
                    let (side, middle) = self.on_parent(h);
                    let middle = Located::in_face(self.field.mesh(), side.face(), middle);
                    steep.middles.push(middle.to_surface_point(self.field.mesh()));
                }
            } else if whole.abs() > STEEP {
                let at = |hub: Option<usize>, opposite: [Halfedge; 2]| {
                    hub.into_iter().flat_map(move |hub| opposite.map(|h| (hub, self.on_parent(h).0)))
                };
                steep.corners.extend(at(ends[0], [h.next(), twin.previous()]));
                steep.corners.extend(at(ends[1], [h.previous(), twin.next()]));
            }
        }
        Ok(steep)
    }

    /// Returns the halfedges with a twin, one per edge, with their twins.
    fn edges(&self) -> impl Iterator<Item = (Halfedge, Halfedge)> {
        let halfedges = (0..self.mesh.halfedge_count() as u32).map(Halfedge);
        halfedges.filter_map(|h| match self.mesh.neighbour(h) {
            Neighbour::Twin(twin) if h < twin => Some((h, twin)),
            _ => None,
        })
    }

    /// Returns the side of the parent face on which a halfedge lies, and the weights of its middle
    /// in the parent.
    fn on_parent(&self, h: Halfedge) -> (Halfedge, [f64; 3]) {
        let mut weights = [0.5; 3];
        weights[(h.side() + 2) % 3] = 0.0;
        let (parent, middle) = self.in_parent(h.face(), weights);
        // The opposite corner has no weight.
        let opposite = (0..3).min_by(|&a, &b| middle[a].total_cmp(&middle[b])).unwrap_or(2);
        (parent.halfedge((opposite + 1) % 3), middle)
    }

    /// Follows the power from the sample of a face to that of its neighbour.
    fn turn(&self, h: Halfedge, twin: Halfedge) -> Turn {
        let values = &self.field.values;
        let [from, to] = [h, twin].map(|h| self.sample(h.face()));
        if from.0 == to.0 {
            let whole = values.turn_between(from.0, from.1, to.1);
            return Turn { whole, jump: 0.0, layout: 0.0 };
        }
        let (side, middle) = self.on_parent(h);
        let middles = [middle, self.on_parent(twin).1];
        let own = values.turn_between(from.0, from.1, middles[0]);
        let other = values.turn_between(to.0, middles[1], to.1);
        let layout = f64::from(self.field.degree()) * self.field.domain.connection.jump[side];
        let jump = self.across(side, middles);
        Turn { whole: own + jump + other, jump, layout }
    }

    /// Returns how far the power turns from the face of a halfedge of the field's mesh to that of
    /// its twin at a point of their edge, unwrapped from an end with no singular point in between.
    fn across(&self, side: Halfedge, middles: [[f64; 3]; 2]) -> f64 {
        let field = self.field;
        let mesh = field.mesh();
        let Some(twin) = field.domain.bevel.twin[side] else { return 0.0 };
        let along = middles[0][(side.side() + 1) % 3];
        let t = self.on_edges.get(&mesh.edge(side));
        let singular = t.map_or(0.5, |t| if mesh.follows_edge(side) { *t } else { 1.0 - t });
        let corner = |k: usize| {
            let mut weights = [0.0; 3];
            weights[k % 3] = 1.0;
            weights
        };
        let (solved, ends) = if along < singular {
            (-field.values.jump[side], [corner(side.side()), corner(twin.side() + 1)])
        } else {
            (field.values.jump[twin], [corner(side.side() + 1), corner(twin.side())])
        };
        let own = field.values.turn_between(side.face(), ends[0], middles[0]);
        let other = field.values.turn_between(twin.face(), ends[1], middles[1]);
        solved + other - own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polar_field::samples::{prescription, surfaces};
    use crate::polar_field::{FieldOptions, Solver, inspect_field};
    use eikona_mesh::random::Random;

    #[test]
    fn split_fields_hold_every_index_at_a_vertex() {
        let mut random = Random::from_seed(17);
        let (mut fields, mut without_steep_edges, mut hubs, mut wrong) = (0, 0, 0, 0);
        for (name, mesh) in surfaces() {
            let solver = Solver::new(&mesh, &Default::default()).unwrap();
            for degree in [1, 2, 3, 4, 6] {
                for round in 0..8 {
                    let given = prescription(&mesh, degree, false, &mut random);
                    let options = FieldOptions::default().with_degree(degree);
                    let Ok(field) = solver.solve(&given, &options) else { continue };
                    if !(field.report.aliased.is_empty() && field.report.unplaced.is_empty()) {
                        continue;
                    }
                    fields += 1;
                    let what = format!("{name}, N = {degree}, round {round}");
                    let split = field.split().unwrap();
                    assert_eq!(split.left_out, 0);
                    let unmatched = FaceVectors { matching: Vec::new(), ..split.vectors.clone() };
                    let seen = inspect_field(&split.mesh, &unmatched).unwrap();
                    // On the coarsest surfaces, the field turns too far elsewhere.
                    if split.steep_edges.is_empty() {
                        without_steep_edges += 1;
                        assert_eq!(seen.vertices, split.singular_vertices, "{what}");
                        let matched = inspect_field(&split.mesh, &split.vectors).unwrap();
                        assert_eq!(matched.vertices, split.singular_vertices, "{what}");
                    }
                    let at_steep = |v: Vertex| {
                        split.steep_edges.iter().any(|&e| split.mesh.edge_vertices(e).contains(&v))
                    };
                    for singular in &split.singular_vertices {
                        let is_seen = seen.vertices.contains(singular);
                        assert!(is_seen || at_steep(singular.0), "{what}: {singular:?}, {:?}", seen.vertices);
                        hubs += 1;
                        wrong += usize::from(!is_seen);
                    }
                }
            }
        }
        assert!(fields > 300 && 10 * without_steep_edges > 9 * fields, "{without_steep_edges} of {fields}");
        assert!(hubs > 600 && 200 * wrong < hubs, "{wrong} of {hubs}");
    }
}
