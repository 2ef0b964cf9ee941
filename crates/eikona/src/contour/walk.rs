//! A walk over the faces along a plane.

use crate::geometry::vector::{Vec3, cross, distance, dot, norm, normalize, scale, sub};
use eikona_mesh::{Face, Located, TriangleMesh, Vertex, segment_host};

/// A walk may be this many times as long as the straight segment: half a circle is 1.57 times its diameter.
const LENGTH_LIMIT: f64 = 2.5;

/// A walk from one place on a mesh to another, along the plane through both that contains the mean of their normals.
pub(super) struct PlaneWalk<'a> {
    mesh: &'a TriangleMesh,
    from: Located,
    to: Located,
    origin: Vec3,
    /// Unit vector towards the goal, and the distance in space.
    direction: Vec3,
    length: f64,
    /// Unit normal of the plane.
    plane: Vec3,
    tolerance: f64,
}

impl<'a> PlaneWalk<'a> {
    /// `None` where the plane is not defined: the segment runs along the normals.
    pub fn between(mesh: &'a TriangleMesh, from: Located, to: Located, tolerance: f64) -> Option<Self> {
        let (origin, goal) = (from.position(mesh), to.position(mesh));
        let segment = sub(goal, origin);
        let direction = normalize(segment)?;
        let (a, mut b) = (normal_at(mesh, from)?, normal_at(mesh, to)?);
        if dot(a, b) < 0.0 {
            b = scale(-1.0, b); // a surface that is not oriented throughout may have it either way
        }
        let plane = cross(direction, [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        if norm(plane) < 1e-3 {
            return None; // within 0.03 degrees of the normal, the plane's direction is arbitrary
        }
        let plane = normalize(plane)?;
        Some(PlaneWalk { mesh, from, to, origin, direction, length: norm(segment), plane, tolerance })
    }

    /// The nodes after the start, the goal last, or `None` where the walk does not get there. Each step costs one of `budget`.
    pub fn run(&self, budget: &mut usize) -> Option<Vec<Located>> {
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
        Some(path)
    }

    /// The face to cross next and the place where the plane leaves it: of several, the most forward one.
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
        // Going on through an edge there is no choice; the surface may bend back for a while.
        let only_way = count == 1 && came_through.is_some() && matches!(here, Located::Edge(..));
        (forward > 0.0 || only_way).then_some((face, exit))
    }

    /// Where the plane leaves a face that it enters at this place: at most two places.
    fn exits(&self, here: Located, face: Face) -> [Option<Located>; 3] {
        let corners = self.mesh.face_vertices(face);
        let edges = self.mesh.face_edges(face);
        let height = corners.map(|v| self.height(v));
        // An edge in the plane is left at its ends.
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
            // Height 0 counts as above: a plane through a vertex crosses one of the edges there, and the exit snaps to it.
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

/// The unit normal at a place: the mean of its faces' normals by area, each turned to the side of the first.
fn normal_at(mesh: &TriangleMesh, place: Located) -> Option<Vec3> {
    let mut sum = [0.0; 3];
    for face in place.faces(mesh) {
        let [a, b, c] = mesh.face_positions(face);
        let n = cross(sub(b, a), sub(c, a));
        let sign = if dot(n, sum) < 0.0 { -1.0 } else { 1.0 };
        sum = [0, 1, 2].map(|k| sum[k] + sign * n[k]);
    }
    normalize(sum)
}
