//! Step I, right-hand side: what curves and points put on the edges (SHM section 5.6 and appendix
//! A).

use crate::curves::side::SideOfSegments;
use crate::geometry::Triangle;
use crate::geometry::vector::distance;
use crate::operators::EdgeFrames;
use crate::signed_heat::condition::open_ends;
use crate::signed_heat::crossings::crossing_segments;
use crate::signed_heat::options::SignConvention;
use eikona_mesh::{
    CurveError, CurveKind, Face, Halfedge, Located, Neighbour, Segment, SegmentHost, SurfaceCurves,
    TriangleMesh, Vertex,
};
use eikona_numeric::{Complex, Scalar};
use std::collections::BTreeMap;

/// A source looked up on the mesh.
pub(crate) struct Source {
    pub segments: Vec<Segment>,
    pub points: Vec<Located>,
    /// For each segment: its kind.
    pub kinds: Vec<CurveKind>,
    /// Pairs of segments that cross.
    pub crossings: Vec<[usize; 2]>,
    pub warnings: Vec<String>,
    sides: SideOfSegments,
}

impl Source {
    /// Looks up every node. `consistent`: the faces of the mesh are wound alike.
    pub fn new(mesh: &TriangleMesh, consistent: bool, input: &SurfaceCurves) -> Result<Source, CurveError> {
        if input.is_empty() {
            return Err(CurveError::Empty);
        }
        let segments = input.segments(mesh)?;
        let points = input.located_points(mesh)?;
        let kinds: Vec<CurveKind> = segments.iter().map(|s| input.curves[s.curve].kind).collect();
        let mut warnings = Vec::new();
        let sides = SideOfSegments::of(mesh, consistent, input, &segments, &mut warnings);
        let crossings = crossing_segments(&segments);
        Ok(Source { segments, points, kinds, crossings, warnings, sides })
    }

    /// The places inside the surface where a signed curve ends and no other segment begins: the
    /// ends of gaps.
    pub fn open_ends(&self, mesh: &TriangleMesh) -> Vec<Located> {
        open_ends(
            mesh,
            self.segments.iter().zip(&self.kinds).filter(|(_, k)| **k == CurveKind::Signed).map(|(s, _)| s),
        )
    }

    /// The mean along each of so many curves of a function with these values at vertices.
    pub fn means(&self, mesh: &TriangleMesh, curves: usize, values: &[f64]) -> Vec<f64> {
        let value = |end: Located| end.weights(mesh).map(|(v, w)| w * values[v.index()]).sum::<f64>();
        let mut sums = vec![[0.0; 2]; curves];
        for segment in &self.segments {
            let [p, q] = segment.ends.map(|end| end.position(mesh));
            let length = distance(p, q);
            let [sum, total] = &mut sums[segment.curve];
            *sum += 0.5 * length * (value(segment.ends[0]) + value(segment.ends[1]));
            *total += length;
        }
        sums.into_iter().map(|[sum, total]| sum / total).collect()
    }

    /// The values `X_0` for diffusion time `t`.
    pub fn values<F: EdgeFrames>(
        &self,
        mesh: &TriangleMesh,
        frames: &F,
        triangles: &[Triangle],
        sign: SignConvention,
        time: f64,
    ) -> Vec<F::Value> {
        let mut deposit = Deposit::new(mesh, frames, triangles);
        // A gradient of height 1 / sqrt(t) balances the normal of a signed curve: both leave the
        // same field on flat ground.
        let spread = time.sqrt();
        for (i, (segment, kind)) in self.segments.iter().zip(&self.kinds).enumerate() {
            match kind {
                CurveKind::Signed => deposit.signed_segment(segment, i, &self.sides, sign),
                CurveKind::Unsigned => {
                    let [p, q] = segment.ends.map(|end| end.position(mesh));
                    let weight = 0.5 * distance(p, q) * spread;
                    segment.ends.into_iter().for_each(|end| deposit.outward(end, weight));
                }
            }
        }
        // A point weighs as much as a curve of length sqrt(t).
        self.points.iter().for_each(|point| deposit.outward(*point, spread * spread));
        deposit.finish()
    }
}

/// Vectors added up on the edges.
pub(crate) struct Deposit<'a, F: EdgeFrames> {
    mesh: &'a TriangleMesh,
    frames: &'a F,
    triangles: &'a [Triangle],
    values: Vec<F::Value>,
    /// The largest single contribution to each edge.
    largest: Vec<f64>,
    /// How much points outward from each vertex. Summed first: a hub of a curve is visited once,
    /// not once a segment.
    outward: BTreeMap<Vertex, f64>,
}

const I: Complex = Complex { re: 0.0, im: 1.0 };

/// Sums below this share of the largest contribution to their edge are what rounding leaves of
/// normals that cancel.
const CANCELLED: f64 = 1e-13;

impl<'a, F: EdgeFrames> Deposit<'a, F> {
    pub fn new(mesh: &'a TriangleMesh, frames: &'a F, triangles: &'a [Triangle]) -> Self {
        Deposit {
            mesh,
            frames,
            triangles,
            values: frames.zeros(),
            largest: vec![0.0; mesh.edge_count()],
            outward: BTreeMap::new(),
        }
    }

    /// Adds a vector, given in the layout of a face, at one of its sides.
    fn add(&mut self, face: Face, side: usize, vector: Complex) {
        let along = self.triangles[face.index()].directions()[side];
        self.add_seen_from(face.halfedge(side), along.conj() * vector);
    }

    /// Adds a vector seen from a halfedge.
    fn add_seen_from(&mut self, h: Halfedge, vector: Complex) {
        let largest = &mut self.largest[self.mesh.edge(h).index()];
        *largest = largest.max(vector.max_part());
        self.frames.add(self.mesh, &mut self.values, h, vector);
    }

    /// The sums, with those that cancelled set to zero.
    pub fn finish(mut self) -> Vec<F::Value> {
        for (v, weight) in std::mem::take(&mut self.outward) {
            self.outward_at_vertex(v, weight, |_| true);
        }
        for (e, largest) in self.mesh.edges().zip(self.largest) {
            let sums = self.values[self.frames.of_edge(e)].iter_mut();
            sums.filter(|v| v.max_part() < CANCELLED * largest).for_each(|v| *v = F::Value::ZERO);
        }
        self.values
    }

    /// The normal of an oriented segment (eq. 11, without the factor phi_e(m), as the paper
    /// advises), the `i`-th one.
    fn signed_segment(&mut self, segment: &Segment, i: usize, sides: &SideOfSegments, sign: SignConvention) {
        let (reference, upside) = sides.of_segment(i);
        // The gradient points away from the negative side.
        let to_left = match sign {
            SignConvention::LeftNegative => -1.0,
            SignConvention::LeftPositive => 1.0,
        };
        match segment.host {
            SegmentHost::Face(face, [from, to]) => {
                let t = &self.triangles[face.index()];
                let normal = I * (t.point(to) - t.point(from)) * (to_left * upside);
                for side in 0..3 {
                    self.add(face, side, normal);
                }
            }
            SegmentHost::Edge(edge, [from, to]) => {
                let length = |h: &Halfedge| self.triangles[h.face().index()].lengths[h.side()];
                let halfedges = self.mesh.edge_halfedges(edge);
                if halfedges.len() <= 2 {
                    // Both faces share one vector.
                    let Some(h) = halfedges.iter().find(|h| h.face() == reference) else { return };
                    let along = if self.mesh.follows_edge(*h) { to - from } else { from - to };
                    self.add_seen_from(*h, I * (along * length(h) * to_left * upside));
                    return;
                }
                // Of more faces each has a vector for itself, into it or out of it. Deviation: the
                // paper does not say which sheets are left; see `Seam::side`.
                for h in halfedges {
                    let into = (to - from).abs() * length(h) * sides.of_sheet(self.mesh, i, segment, *h);
                    self.add_seen_from(*h, I * (into * to_left));
                }
            }
        }
    }

    /// The directions away from a point on all sides: minus the gradient of a unit mass there,
    /// spread by barycentric weights to the corners of its face as multiples of their hat
    /// functions, and tested with the fields of the sides after integrating by parts face by face:
    /// inside by their divergence, and along the boundary of the surface.
    ///
    /// Diffusion of a gradient is the gradient of diffusion (on flat ground), so the field is that
    /// of the unsigned heat method.
    ///
    /// Deviation: eq. 19 and appendix A.2 integrate unit normals over small circles and offset
    /// curves. Their first moments are not isotropic on a given mesh, and the distances they lead
    /// to do not converge (tests `points_anywhere`, `unsigned_segment_across_faces`); and they need
    /// vertices and edges as sources.
    fn outward(&mut self, point: Located, weight: f64) {
        for (v, share) in point.weights(self.mesh) {
            *self.outward.entry(v).or_default() += weight * share;
        }
    }

    /// The directions away from a vertex, in the faces around it that `wanted` lets through.
    pub fn outward_at_vertex(&mut self, v: Vertex, weight: f64, wanted: impl Fn(Face) -> bool) {
        outward_at_vertex(self.mesh, self.triangles, v, weight, wanted, |h, vector| {
            self.add_seen_from(h, vector);
        });
    }
}

/// Minus the gradient of the hat function of a vertex, of this integral: calls back with halfedges
/// of the faces around it (those that `wanted` lets through) and vectors seen from them.
fn outward_at_vertex(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    v: Vertex,
    weight: f64,
    wanted: impl Fn(Face) -> bool,
    mut add: impl FnMut(Halfedge, Complex),
) {
    let corners = || mesh.vertex_corners(v).iter().filter(|c| wanted(c.face()));
    let mass: f64 = corners().map(|c| triangles[c.face().index()].area / 3.0).sum();
    for corner in corners() {
        let (face, k) = (corner.face(), corner.halfedge().side());
        let t = &triangles[face.index()];
        let share = weight / mass;
        for side in 0..3 {
            // The divergence of the side's field is its outward normal (-i seen from it) times
            // length / area.
            add(face.halfedge(side), Complex { re: 0.0, im: -share / 3.0 * t.lengths[side] });
        }
        // What would leave the surface through its boundary stays: the integral of the two
        // functions along it.
        let directions = t.directions();
        for boundary in [k, (k + 2) % 3] {
            if mesh.neighbour(face.halfedge(boundary)) != Neighbour::Boundary {
                continue;
            }
            let inward = Complex { re: -directions[boundary].im, im: directions[boundary].re };
            for side in 0..3 {
                let integral = if side == boundary {
                    0.5
                } else if (side + 2) % 3 == k {
                    -1.0 / 6.0 // the vertex is opposite this side
                } else {
                    1.0 / 6.0
                };
                let vector = inward.scale(share * integral * t.lengths[boundary]);
                add(face.halfedge(side), directions[side].conj() * vector);
            }
        }
    }
}
