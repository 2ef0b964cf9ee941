//! Right-hand side of step I: contributions of curves and points to the edges (SHM section 5.6 and
//! appendix A).

use crate::Warning;
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

/// Source located on the mesh.
pub(crate) struct Source {
    pub segments: Vec<Segment>,
    pub points: Vec<Located>,
    /// Kind of each segment.
    pub kinds: Vec<CurveKind>,
    /// Pairs of segments that cross.
    pub crossings: Vec<[usize; 2]>,
    pub warnings: Vec<Warning>,
    sides: SideOfSegments,
}

impl Source {
    /// Locates every node. `consistent` says whether the mesh is consistently oriented.
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

    /// Returns the open ends of the signed curves, at which gaps begin: places inside the surface
    /// where a signed curve ends and no other segment of a signed curve begins.
    pub fn open_ends(&self, mesh: &TriangleMesh) -> Vec<Located> {
        open_ends(
            mesh,
            self.segments.iter().zip(&self.kinds).filter(|(_, k)| **k == CurveKind::Signed).map(|(s, _)| s),
        )
    }

    /// Returns the mean along each of the first `curves` curves of a function with these vertex
    /// values.
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

    /// Returns the initial values `X_0` for diffusion time `t`.
    pub fn values<F: EdgeFrames>(
        &self,
        mesh: &TriangleMesh,
        frames: &F,
        triangles: &[Triangle],
        sign: SignConvention,
        time: f64,
    ) -> Vec<F::Value> {
        let mut deposit = Deposit::new(mesh, frames, triangles);
        // The gradient of a function of height 1 / sqrt(t) matches the normal of a signed curve: on
        // a flat surface both produce the same field.
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

/// Accumulates vectors on the edges.
pub(crate) struct Deposit<'a, F: EdgeFrames> {
    mesh: &'a TriangleMesh,
    frames: &'a F,
    triangles: &'a [Triangle],
    values: Vec<F::Value>,
    /// Largest single contribution to each edge.
    largest: Vec<f64>,
    /// Weight of the outward directions at each vertex. Summed first, so that a vertex where many
    /// segments meet is visited once and not once per segment.
    outward: BTreeMap<Vertex, f64>,
}

const I: Complex = Complex { re: 0.0, im: 1.0 };

/// Sums below this share of the largest contribution to their edge count as zero: they are rounding
/// errors of normals that cancel.
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
        self.add_at_halfedge(face.halfedge(side), along.conj() * vector);
    }

    /// Adds a vector in the frame of a halfedge.
    fn add_at_halfedge(&mut self, h: Halfedge, vector: Complex) {
        let largest = &mut self.largest[self.mesh.edge(h).index()];
        *largest = largest.max(vector.max_part());
        self.frames.add(self.mesh, &mut self.values, h, vector);
    }

    /// Returns the sums, with cancelled ones set to zero.
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

    /// Adds the normal of the `i`-th segment, which is oriented (eq. 11, without the factor
    /// phi_e(m), as the paper advises).
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
                    self.add_at_halfedge(*h, I * (along * length(h) * to_left * upside));
                    return;
                }
                // At a nonmanifold edge each face has its own vector, into it or out of it.
                // Deviation: the paper does not say which sheets are on the left; see `Seam::side`.
                for h in halfedges {
                    let into = (to - from).abs() * length(h) * sides.of_sheet(self.mesh, i, segment, *h);
                    self.add_at_halfedge(*h, I * (into * to_left));
                }
            }
        }
    }

    /// Adds the directions away from a point on all sides: minus the gradient of a unit mass at the
    /// point. Barycentric weights distribute the mass to the corners of the face, as multiples of
    /// their hat functions; integration by parts in each face then tests the gradient with the
    /// basis fields of the sides, through their divergence inside and along the boundary of the
    /// surface.
    ///
    /// On a flat surface diffusion commutes with the gradient, so the field is that of the unsigned
    /// heat method.
    ///
    /// Deviation: eq. 19 and appendix A.2 integrate unit normals over small circles and offset
    /// curves. Their first moments are not isotropic on a given mesh, and the resulting distances
    /// do not converge (tests `points_anywhere`, `unsigned_segment_across_faces`). They also need
    /// sources at vertices and edges.
    fn outward(&mut self, point: Located, weight: f64) {
        for (v, share) in point.weights(self.mesh) {
            *self.outward.entry(v).or_default() += weight * share;
        }
    }

    /// Adds the directions away from a vertex, in the faces around it for which `wanted` holds.
    pub fn outward_at_vertex(&mut self, v: Vertex, weight: f64, wanted: impl Fn(Face) -> bool) {
        outward_at_vertex(self.mesh, self.triangles, v, weight, wanted, |h, vector| {
            self.add_at_halfedge(h, vector);
        });
    }
}

/// Visits minus the gradient of the hat function of a vertex, scaled to integral `weight`: calls
/// `add` with halfedges of the faces around the vertex for which `wanted` holds, and with vectors
/// in the frames of these halfedges.
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
            // The divergence of the side's basis field is its outward normal (-i in the halfedge's
            // frame) times length / area.
            add(face.halfedge(side), Complex { re: 0.0, im: -share / 3.0 * t.lengths[side] });
        }
        // The boundary term: the integral of both functions along the boundary cancels the flux out
        // of the surface.
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
