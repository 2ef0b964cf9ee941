//! Walks across faces along a plane.
//!
//! The plane contains both ends and the mean of their normals. Whether two distant normals point to
//! the same side of the surface is known only along a path between them. Therefore both the sum and
//! the difference of the normals span a candidate plane, and each walk transports the orientation
//! of the faces to its goal. The result does not depend on how individual faces are oriented.

use super::side::Fans;
use super::straighten::path_length;
use crate::geometry::vector::{Vec3, add, cross, distance, dot, norm, normalize, scale, sub};
use eikona_mesh::{Face, Located, TriangleMesh, Vertex, segment_host};

/// Largest ratio of a walk's length to the straight segment's: half a circle is 1.57 times its
/// diameter.
const LENGTH_LIMIT: f64 = 2.5;

/// A walk at most this many times as long as the straight segment needs no comparison: no path is
/// shorter than the segment.
const NEARLY_STRAIGHT: f64 = 1.05;

/// A dot product of the normals beyond this (60 and 120 degrees) decides which plane to try first.
const DECISIVE: f64 = 0.5;

/// If the sum of the unit normals has a shorter component than this across the segment, the normals
/// nearly cancel or run along it, and the plane is mostly noise.
const DEFINED: f64 = 0.2;

/// A walk that has reached its goal.
pub(super) struct Walked {
    /// The nodes after the start, the goal last.
    pub path: Vec<Located>,
    pub length: f64,
    /// Whether the plane is well defined and the two normals that span it, transported along the
    /// walk, point to the same side of the surface.
    pub trusted: bool,
    /// Whether the walk is nearly straight in a well-defined plane, so that no path is much
    /// shorter.
    pub direct: bool,
}

impl Walked {
    /// Combines several walks into one path.
    pub fn new(mesh: &TriangleMesh, from: Located, path: Vec<Located>) -> Self {
        let first = distance(from.position(mesh), path.first().map_or(from, |&p| p).position(mesh));
        let length = first + path_length(mesh, &path);
        Walked { path, length, trusted: true, direct: false }
    }
}

/// Returns the walks between two places that arrive, at most two, the preferred one first. Each
/// step uses up one unit of `budget`.
pub(super) fn plane_walks(
    mesh: &TriangleMesh,
    fans: &mut Fans,
    (from, to): (Located, Located),
    tolerance: f64,
    budget: &mut usize,
) -> Vec<Walked> {
    let (Some(a), Some(b)) = (normal_at(mesh, fans, from), normal_at(mesh, fans, to)) else {
        return Vec::new();
    };
    let product = dot(a, b);
    let mut walks = Vec::new();
    for sign in if product < 0.0 { [-1.0, 1.0] } else { [1.0, -1.0] } {
        let Some(walk) = PlaneWalk::along(mesh, from, to, [a, scale(b, sign)], tolerance) else { continue };
        let Some((path, length)) = walk.run(budget) else { continue };
        let direct = walk.defined && length <= NEARLY_STRAIGHT * walk.length;
        if direct && product.abs() > DECISIVE {
            return vec![Walked { path, length, trusted: true, direct }];
        }
        let trusted = walk.defined && side_carried(mesh, fans, from, &path) == sign;
        walks.push(Walked { path, length, trusted, direct });
    }
    walks.sort_by(|v, w| {
        (!v.direct, !v.trusted).cmp(&(!w.direct, !w.trusted)).then(v.length.total_cmp(&w.length))
    });
    walks
}

/// A walk from one place on a mesh to another along a plane through both.
struct PlaneWalk<'a> {
    mesh: &'a TriangleMesh,
    from: Located,
    to: Located,
    origin: Vec3,
    /// Unit vector towards the goal, and the distance in space.
    direction: Vec3,
    length: f64,
    /// Unit normal of the plane, and whether it is well defined.
    plane: Vec3,
    defined: bool,
    tolerance: f64,
}

impl<'a> PlaneWalk<'a> {
    /// Creates a walk in the plane that contains the sum of these unit normals. `None` where the
    /// segment runs along the sum or the normals cancel.
    fn along(
        mesh: &'a TriangleMesh,
        from: Located,
        to: Located,
        normals: [Vec3; 2],
        tolerance: f64,
    ) -> Option<Self> {
        let (origin, goal) = (from.position(mesh), to.position(mesh));
        let segment = sub(goal, origin);
        let direction = normalize(segment)?;
        let plane = cross(direction, add(normals[0], normals[1]));
        if norm(plane) < 1e-3 {
            return None; // within 0.03 degrees of the normal the plane is arbitrary
        }
        let defined = norm(plane) >= DEFINED;
        let (plane, length) = (normalize(plane)?, norm(segment));
        Some(PlaneWalk { mesh, from, to, origin, direction, length, plane, defined, tolerance })
    }

    /// Returns the nodes after the start up to the goal, and the length. `None` if the walk does
    /// not arrive.
    fn run(&self, budget: &mut usize) -> Option<(Vec<Located>, f64)> {
        let mut path = Vec::new();
        let (mut here, mut came_through) = (self.from, None);
        let mut position = self.origin;
        let mut walked = 0.0;
        while segment_host(self.mesh, here, self.to).is_none() {
            *budget = budget.checked_sub(1)?;
            let (face, next) = self.step(here, position, came_through)?;
            let next_position = next.position(self.mesh);
            walked += distance(position, next_position);
            if walked > LENGTH_LIMIT * self.length {
                return None;
            }
            path.push(next);
            (here, came_through, position) = (next, Some(face), next_position);
        }
        path.push(self.to);
        Some((path, walked + distance(position, self.to.position(self.mesh))))
    }

    /// Returns the next face to cross and the place where the plane leaves it; of several, the most
    /// forward one.
    fn step(&self, here: Located, position: Vec3, came_through: Option<Face>) -> Option<(Face, Located)> {
        let mut best: Option<(f64, Face, Located)> = None;
        let mut count = 0;
        for face in here.faces(self.mesh) {
            if Some(face) == came_through {
                continue;
            }
            for exit in self.exits(here, face).into_iter().flatten() {
                let ahead = sub(exit.position(self.mesh), position);
                let forward = dot(ahead, self.direction) / norm(ahead);
                count += 1;
                if forward.is_finite() && best.is_none_or(|b| forward > b.0) {
                    best = Some((forward, face, exit));
                }
            }
        }
        let (forward, face, exit) = best?;
        // Through an edge there is only one way on; the surface may bend back for a while.
        let only_way = count == 1 && came_through.is_some() && matches!(here, Located::Edge(..));
        (forward > 0.0 || only_way).then_some((face, exit))
    }

    /// Returns where the plane leaves a face that it enters at this place: at most two places.
    fn exits(&self, here: Located, face: Face) -> [Option<Located>; 3] {
        let corners = self.mesh.face_vertices(face);
        let edges = self.mesh.face_edges(face);
        let height = corners.map(|v| self.height(v));
        // A walk along an edge in the plane leaves it at its ends.
        if let Located::Edge(edge, _) = here {
            let ends = self.mesh.edge_vertices(edge);
            let length = distance(self.mesh.position(ends[0]), self.mesh.position(ends[1]));
            if ends.iter().all(|&v| self.height(v).abs() <= self.tolerance * length) {
                return [Some(Located::Vertex(ends[0])), Some(Located::Vertex(ends[1])), None];
            }
        }
        [0, 1, 2].map(|k| {
            let (i, j) = (k, (k + 1) % 3);
            let on_this_side = match here {
                Located::Vertex(v) => v == corners[i] || v == corners[j],
                Located::Edge(e, _) => e == edges[k],
                Located::Face(..) => false,
            };
            // Height 0 counts as above: a plane through a vertex crosses one of the edges there,
            // and the exit snaps to the vertex.
            if on_this_side || (height[i] >= 0.0) == (height[j] >= 0.0) {
                return None;
            }
            let t = height[i] / (height[i] - height[j]);
            Some(if t <= self.tolerance {
                Located::Vertex(corners[i])
            } else if t >= 1.0 - self.tolerance {
                Located::Vertex(corners[j])
            } else {
                let along = self.mesh.edge_vertices(edges[k])[0] == corners[i];
                Located::Edge(edges[k], if along { t } else { 1.0 - t })
            })
        })
    }

    fn height(&self, v: Vertex) -> f64 {
        dot(sub(self.mesh.position(v), self.origin), self.plane)
    }
}

/// Returns the unit normal at a place: the area-weighted mean of its faces' normals, each flipped
/// to the side of the first.
fn normal_at(mesh: &TriangleMesh, fans: &mut Fans, place: Located) -> Option<Vec3> {
    let faces = place.faces(mesh);
    let mut sum = [0.0; 3];
    for &face in &faces {
        let [a, b, c] = mesh.face_positions(face);
        let n = cross(sub(b, a), sub(c, a));
        let by_normal = || if dot(n, sum) < 0.0 { -1.0 } else { 1.0 };
        let sign = fans.relative_orientation(faces[0], face, place).unwrap_or_else(by_normal);
        sum = add(sum, scale(n, sign));
    }
    normalize(sum)
}

/// Returns +1 if the first faces at both ends of a path are consistently oriented along it, else
/// -1. Faces that share only a vertex count as consistently oriented.
fn side_carried(mesh: &TriangleMesh, fans: &mut Fans, from: Located, path: &[Located]) -> f64 {
    let mut carried = 1.0;
    let mut here = from;
    let mut face = from.faces(mesh).first().copied();
    for &next in path {
        let host = here.faces(mesh).into_iter().find(|&f| next.weights_in_face(mesh, f).is_some());
        if let (Some(f), Some(g)) = (face, host) {
            carried *= fans.relative_orientation(f, g, here).unwrap_or(1.0);
            face = Some(g);
        }
        here = next;
    }
    if let (Some(f), Some(&g)) = (face, here.faces(mesh).first()) {
        carried *= fans.relative_orientation(f, g, here).unwrap_or(1.0);
    }
    carried
}
