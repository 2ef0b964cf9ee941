//! A triangle mesh that changes by local operations: edges are split, collapsed and flipped.
//!
//! Halfedge `3 f + k` is side `k` of face `f`, from its corner `k` to the next one; its *twin* is
//! the same edge on the other face. Twins may run in the same direction: no step needs a consistent
//! orientation. Faces and vertices that are gone stay as gaps until [`compact`](Changing::compact).

use crate::geometry::vector::{distance, lerp};
use eikona_mesh::{MeshError, Neighbour, TriangleMesh};

pub(super) type Vec3 = [f64; 3];

/// No halfedge: the boundary; no vertex: a face that is gone.
pub(super) const NONE: u32 = u32::MAX;

/// The mesh.
pub(super) struct Changing {
    pub positions: Vec<Vec3>,
    /// The edge length to aim for, per vertex.
    pub sizes: Vec<f64>,
    /// Vertices that stay where they are.
    pub fixed: Vec<bool>,
    /// A face of the original mesh at or near each vertex.
    pub near: Vec<u32>,
    /// Corners of the faces; [`NONE`] if the face is gone.
    pub faces: Vec<[u32; 3]>,
    twins: Vec<[u32; 3]>,
    /// A corner at each vertex, as `3 f + k`; [`NONE`] if there is none.
    spokes: Vec<u32>,
}

/// The faces around a vertex, in order.
#[derive(Default)]
pub(super) struct Fan {
    /// The corners at the vertex, as `3 f + k`.
    pub corners: Vec<u32>,
    /// The vertices around it: one more than there are faces if the fan is open.
    pub ring: Vec<u32>,
    /// Whether the vertex is at the boundary.
    pub is_open: bool,
}

/// An edge with the vertices opposite to it.
#[derive(Clone, Copy)]
pub(super) struct Hinge {
    /// The halfedge in the first face.
    pub halfedge: u32,
    /// The halfedge in the second face; [`NONE`] at the boundary.
    pub twin: u32,
    pub ends: [u32; 2],
    /// The opposite corner in the first face, and in the second, if there is one.
    pub opposite: [u32; 2],
}

impl Changing {
    pub fn new(mesh: &TriangleMesh, sizes: Vec<f64>, fixed: Vec<bool>, near: Vec<u32>) -> Changing {
        let faces = mesh.triangles().to_vec();
        let twin = |h| match mesh.neighbour(h) {
            Neighbour::Twin(twin) => twin.0,
            _ => NONE,
        };
        let twins = mesh.faces().map(|f| [0, 1, 2].map(|k| twin(f.halfedge(k)))).collect();
        let spoke = |v| mesh.vertex_corners(v).first().map_or(NONE, |c| c.0);
        Changing {
            positions: mesh.positions().to_vec(),
            sizes,
            fixed,
            near,
            spokes: mesh.vertices().map(spoke).collect(),
            faces,
            twins,
        }
    }

    pub fn is_alive(&self, face: u32) -> bool {
        self.faces[face as usize][0] != NONE
    }

    /// All halfedges, those of faces that are gone included.
    pub fn halfedges(&self) -> std::ops::Range<u32> {
        0..3 * self.faces.len() as u32
    }

    pub fn corner(&self, corner: u32) -> u32 {
        self.faces[(corner / 3) as usize][(corner % 3) as usize]
    }

    pub fn twin(&self, halfedge: u32) -> u32 {
        self.twins[(halfedge / 3) as usize][(halfedge % 3) as usize]
    }

    pub fn triangle(&self, face: u32) -> [Vec3; 3] {
        self.faces[face as usize].map(|v| self.positions[v as usize])
    }

    /// The edge of a halfedge.
    pub fn hinge(&self, halfedge: u32) -> Hinge {
        let [a, b, c] = self.corners_along(halfedge);
        let twin = self.twin(halfedge);
        let d = if twin == NONE { NONE } else { self.corners_along(twin)[2] };
        Hinge { halfedge, twin, ends: [a, b], opposite: [c, d] }
    }

    /// Each edge once: at the boundary, or by its lower halfedge.
    pub fn hinges(&self) -> impl Iterator<Item = Hinge> {
        let alive = self.halfedges().filter(|h| self.is_alive(h / 3));
        alive.filter(|h| *h < self.twin(*h)).map(|h| self.hinge(h))
    }

    pub fn length(&self, [a, b]: [u32; 2]) -> f64 {
        distance(self.positions[a as usize], self.positions[b as usize])
    }

    /// The length to aim for.
    pub fn size(&self, [a, b]: [u32; 2]) -> f64 {
        0.5 * (self.sizes[a as usize] + self.sizes[b as usize])
    }

    /// The corners of a face, from the start of a side.
    fn corners_along(&self, halfedge: u32) -> [u32; 3] {
        let k = halfedge as usize % 3;
        let corners = self.faces[halfedge as usize / 3];
        [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]]
    }

    /// The corner of a face at a vertex of it, as `3 f + k`.
    fn corner_at(&self, face: u32, vertex: u32) -> u32 {
        let corners = self.faces[face as usize];
        3 * face + u32::from(corners[1] == vertex) + 2 * u32::from(corners[2] == vertex)
    }

    fn link(&mut self, a: u32, b: u32) {
        for (from, to) in [(a, b), (b, a)] {
            if from != NONE {
                self.twins[from as usize / 3][from as usize % 3] = to;
            }
        }
    }

    /// Collects the fan of a vertex.
    pub fn fan(&self, vertex: u32, fan: &mut Fan) {
        fan.corners.clear();
        fan.ring.clear();
        let start = self.spokes[vertex as usize];
        if start == NONE {
            return;
        }
        // Back to the boundary, if there is one.
        let before = |corner: u32| corner - corner % 3 + (corner + 2) % 3;
        let (mut corner, mut side) = (start, before(start));
        fan.is_open = loop {
            match self.across(vertex, side) {
                None => break true,
                Some((next, exit)) => {
                    (corner, side) = (next, exit);
                    if corner == start {
                        break false;
                    }
                }
            }
        };
        if !fan.is_open {
            side = before(start);
        }
        // Forward from there, away from the side that was reached.
        let first = corner;
        let mut entry = side;
        loop {
            fan.corners.push(corner);
            fan.ring.push(self.other_end(vertex, entry));
            let exit = if entry == corner { before(corner) } else { corner };
            match self.across(vertex, exit) {
                None => {
                    fan.ring.push(self.other_end(vertex, exit));
                    return;
                }
                Some((next, _)) if next == first => return,
                Some((next, _)) => (corner, entry) = (next, self.twin(exit)),
            }
        }
    }

    /// The corner at the vertex in the face across a side, and the other side of that face there.
    fn across(&self, vertex: u32, side: u32) -> Option<(u32, u32)> {
        let twin = self.twin(side);
        (twin != NONE).then(|| {
            let corner = self.corner_at(twin / 3, vertex);
            let other = if corner == twin { corner - corner % 3 + (corner + 2) % 3 } else { corner };
            (corner, other)
        })
    }

    fn other_end(&self, vertex: u32, side: u32) -> u32 {
        let [a, b, _] = self.corners_along(side);
        if a == vertex { b } else { a }
    }

    /// Splits an edge at its midpoint, and returns the new vertex.
    pub fn split(&mut self, hinge: &Hinge) -> u32 {
        let [a, b] = hinge.ends;
        let middle = self.positions.len() as u32;
        self.positions.push(lerp(self.positions[a as usize], self.positions[b as usize], 0.5));
        self.sizes.push(self.size(hinge.ends));
        self.fixed.push(false);
        self.near.push(self.near[a as usize]);
        self.spokes.push(hinge.halfedge - hinge.halfedge % 3 + (hinge.halfedge + 1) % 3);
        let first = self.split_face(hinge.halfedge, middle);
        if hinge.twin != NONE {
            let second = self.split_face(hinge.twin, middle);
            // The halves at the same end belong together.
            let same = self.corner(hinge.twin) == a;
            let [with_a, with_b] = if same { [hinge.twin, second] } else { [second, hinge.twin] };
            self.link(hinge.halfedge, with_a);
            self.link(first, with_b);
        }
        middle
    }

    /// Splits a face at a vertex inside a side. The face keeps the start of the side; returns the
    /// rest of the side, in a new face.
    fn split_face(&mut self, halfedge: u32, middle: u32) -> u32 {
        let (face, i) = (halfedge / 3, halfedge as usize % 3);
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let rest = self.faces.len() as u32;
        let corners = self.faces[face as usize];
        let mut other = corners;
        other[i] = middle;
        self.faces.push(other);
        self.twins.push([NONE; 3]);
        self.link(3 * rest + j as u32, self.twins[face as usize][j]);
        self.link(3 * rest + k as u32, 3 * face + j as u32);
        self.faces[face as usize][j] = middle;
        self.spokes[corners[j] as usize] = 3 * rest + j as u32;
        3 * rest + i as u32
    }

    /// Flips an edge between two faces: it joins the opposite corners.
    pub fn flip(&mut self, hinge: &Hinge) {
        let ([a, b], [c, d]) = (hinge.ends, hinge.opposite);
        let (f, g) = (hinge.halfedge / 3, hinge.twin / 3);
        let side = |h: u32, by: u32| self.twin(h - h % 3 + (h + by) % 3);
        let (bc, ca) = (side(hinge.halfedge, 1), side(hinge.halfedge, 2));
        let (ad, db) = match self.corner(hinge.twin) == b {
            true => (side(hinge.twin, 1), side(hinge.twin, 2)),
            false => (side(hinge.twin, 2), side(hinge.twin, 1)),
        };
        self.faces[f as usize] = [a, d, c];
        self.faces[g as usize] = [d, b, c];
        for (own, other) in
            [(3 * f, ad), (3 * f + 2, ca), (3 * g, db), (3 * g + 1, bc), (3 * f + 1, 3 * g + 2)]
        {
            self.link(own, other);
        }
        for (vertex, corner) in [(a, 3 * f), (d, 3 * f + 1), (c, 3 * f + 2), (b, 3 * g + 1)] {
            self.spokes[vertex as usize] = corner;
        }
    }

    /// Collapses an edge to its first end, which keeps its position; `fan` is that of the second.
    pub fn collapse(&mut self, hinge: &Hinge, fan: &Fan) {
        let [a, b] = hinge.ends;
        let sides = [hinge.halfedge, hinge.twin].into_iter().filter(|h| *h != NONE);
        let outer = sides.map(|h| [1, 2].map(|by| self.twin(h - h % 3 + (h + by) % 3)));
        let outer: Vec<[u32; 2]> = outer.collect();
        for &corner in &fan.corners {
            self.faces[corner as usize / 3][corner as usize % 3] = a;
        }
        let gone = [hinge.halfedge, hinge.twin].map(|h| if h == NONE { NONE } else { h / 3 });
        for face in gone.into_iter().filter(|face| *face != NONE) {
            self.faces[face as usize] = [NONE; 3];
        }
        self.spokes[b as usize] = NONE;
        for ([one, two], opposite) in outer.into_iter().zip(hinge.opposite) {
            self.link(one, two);
            let kept = if one == NONE { two } else { one } / 3;
            self.spokes[opposite as usize] = self.corner_at(kept, opposite);
            self.spokes[a as usize] = self.corner_at(kept, a);
        }
    }

    /// The mesh without gaps, and the vertex that each of its vertices was.
    pub fn compact(&self) -> Result<(TriangleMesh, Vec<u32>), MeshError> {
        let mut number = vec![NONE; self.positions.len()];
        let kept: Vec<u32> =
            (0..self.positions.len() as u32).filter(|v| self.spokes[*v as usize] != NONE).collect();
        kept.iter().enumerate().for_each(|(new, old)| number[*old as usize] = new as u32);
        let alive = self.faces.iter().filter(|corners| corners[0] != NONE);
        let faces = alive.map(|corners| corners.map(|v| number[v as usize])).collect();
        let positions = kept.iter().map(|v| self.positions[*v as usize]).collect();
        Ok((TriangleMesh::new(positions, faces)?, kept))
    }
}
