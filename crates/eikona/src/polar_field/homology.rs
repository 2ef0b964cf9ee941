//! Generators of the homology of the beveled mesh, and the closed 1-forms dual to them.
//!
//! Tree and cotree: a spanning tree of the faces, to which each boundary loop is attached by one of
//! its edges, and a spanning tree of the vertices along the other edges. The remaining edges, two
//! per handle, close one generator each.

use crate::polar_field::bevel::{BeveledMesh, Rotation};
use eikona_mesh::{Edge, EdgeField, Face, Halfedge, UnionFind, Vertex};
use eikona_numeric::{NumericError, check_step, check_stopped};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// The spanning trees, and the generators that they leave.
#[derive(Debug)]
pub(crate) struct Homology {
    /// The faces in the order in which the tree of faces reached them, parents first.
    pub order: Vec<Face>,
    /// The halfedge through which each face was entered from its parent; `None` for roots.
    pub entry: Vec<Option<Halfedge>>,
    /// For each boundary loop, the halfedge by which it is attached to a face.
    pub attachment: Vec<Halfedge>,
    pub generators: Vec<Generator>,
}

/// A closed walk on the beveled mesh that bounds nothing.
#[derive(Clone, Debug)]
pub(crate) struct Generator {
    /// Its beveled edges, each with the direction in which the walk follows it.
    pub walk: Vec<Step>,
    /// The curvature on its right: the sum over the vertices it passes of pi less the angles there.
    pub curvature: f64,
    /// The closed 1-form dual to it, as jumps of one. Its sum over this walk is `period`, 1 or -1;
    /// over the others it is zero.
    dual: Vec<(Halfedge, f64)>,
    pub period: f64,
}

/// An edge of the beveled mesh in a walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Along the jump edge at the origin of this halfedge.
    Jump(Halfedge),
    /// Against the split edge of this halfedge.
    AgainstSplit(Halfedge),
}

impl Generator {
    /// Returns the sum of a 1-form along the walk.
    pub fn sum(&self, theta: &Rotation) -> f64 {
        let value = |step: &Step| match *step {
            Step::Jump(h) => theta.jump[h],
            Step::AgainstSplit(h) => -theta.split[h],
        };
        self.walk.iter().map(value).sum()
    }

    /// Adds a multiple of the dual 1-form.
    pub fn add_dual(&self, factor: f64, theta: &mut Rotation) {
        self.dual.iter().for_each(|&(h, value)| theta.jump[h] += factor * value);
    }
}

impl Homology {
    /// Finds two generators per handle.
    pub fn of(bevel: &BeveledMesh) -> Result<Homology, NumericError> {
        let mesh = &bevel.mesh;
        let mut crossed = EdgeField::constant(mesh.edge_count(), false);
        let (order, entry) = face_tree(bevel, &mut crossed)?;
        let attachment: Vec<Halfedge> =
            bevel.topology.boundary_loops.iter().map(|boundary| boundary.halfedges[0]).collect();
        attachment.iter().for_each(|&h| crossed[mesh.edge(h)] = true);
        let (tree, left) = vertex_tree(bevel, &crossed)?;
        let mut homology = Homology { order, entry, attachment, generators: Vec::new() };
        for e in left {
            check_stopped()?;
            let generator = homology.generator(bevel, &tree, e);
            homology.generators.push(generator);
        }
        Ok(homology)
    }

    /// Closes the generator of a remaining edge.
    fn generator(&self, bevel: &BeveledMesh, tree: &VertexTree, e: Edge) -> Generator {
        let mesh = &bevel.mesh;
        let &[first, second] = mesh.edge_halfedges(e) else {
            unreachable!("every boundary edge is in one of the trees")
        };
        // From the face of `second` through the tree to that of `first`, then across the edge.
        let mut entries = self.tree_path(bevel, second.face(), first.face());
        entries.push(second);
        let mut walk = Vec::with_capacity(2 * entries.len());
        let mut curvature = 0.0;
        for (i, &enter) in entries.iter().enumerate() {
            walk.push(Step::Jump(enter));
            curvature -= bevel.angle(enter);
            let next = entries[(i + 1) % entries.len()];
            if bevel.twin[next] == Some(enter.next()) {
                walk.push(Step::AgainstSplit(enter.previous()));
                curvature += PI - bevel.angle(enter.previous());
            }
        }
        // Along the edge from the face of `first`, and back through the tree of vertices.
        let mut path = vec![first];
        path.extend(tree.path(mesh.tip(first), mesh.origin(first), bevel));
        let mut dual = Vec::with_capacity(2 * path.len());
        for &y in &path {
            if let Some(twin) = bevel.twin[y] {
                dual.push((twin, 1.0));
                dual.push((y, -1.0));
            }
        }
        let mut generator = Generator { walk, curvature, dual, period: 0.0 };
        let mut form = bevel.zero();
        generator.add_dual(1.0, &mut form);
        generator.period = generator.sum(&form);
        generator
    }

    /// Returns the halfedges through which the path in the tree enters its faces after the first.
    fn tree_path(&self, bevel: &BeveledMesh, from: Face, to: Face) -> Vec<Halfedge> {
        let parent = |f: Face| self.entry[f.index()].map(|h| twin_of(bevel, h).face());
        let ancestors = |f: Face| std::iter::successors(Some(f), |f| parent(*f)).collect::<Vec<_>>();
        let (mut up, mut down) = (ancestors(from), ancestors(to));
        while up.len() > 1 && down.len() > 1 && up[up.len() - 2] == down[down.len() - 2] {
            up.pop();
            down.pop();
        }
        up.pop();
        down.pop();
        let entry = |f: &Face| self.entry[f.index()].expect("the face is below a common ancestor");
        let upwards = up.iter().map(|f| twin_of(bevel, entry(f)));
        upwards.chain(down.iter().rev().map(entry)).collect()
    }
}

fn twin_of(bevel: &BeveledMesh, h: Halfedge) -> Halfedge {
    bevel.twin[h].expect("the tree crosses interior edges only")
}

/// Grows a tree over the faces of each component, breadth first, and marks the edges it crosses.
fn face_tree(
    bevel: &BeveledMesh,
    crossed: &mut EdgeField<bool>,
) -> Result<(Vec<Face>, Vec<Option<Halfedge>>), NumericError> {
    let faces = bevel.mesh.face_count();
    let mut reached = vec![false; faces];
    let mut entry = vec![None; faces];
    let mut order = Vec::with_capacity(faces);
    for root in bevel.mesh.faces() {
        if std::mem::replace(&mut reached[root.index()], true) {
            continue;
        }
        let first = order.len();
        order.push(root);
        let mut at = first;
        while let Some(&face) = order.get(at) {
            check_step(at)?;
            at += 1;
            for h in [0, 1, 2].map(|k| face.halfedge(k)) {
                let Some(twin) = bevel.twin[h] else { continue };
                if !std::mem::replace(&mut reached[twin.face().index()], true) {
                    entry[twin.face().index()] = Some(twin);
                    crossed[bevel.mesh.edge(h)] = true;
                    order.push(twin.face());
                }
            }
        }
    }
    Ok((order, entry))
}

/// A spanning tree of the vertices: the edge to the parent and the distance from the root.
struct VertexTree {
    parent: Vec<Option<(Edge, Vertex)>>,
    depth: Vec<u32>,
}

/// Grows the tree of vertices along edges that the tree of faces does not cross, boundary edges
/// first. Also returns the edges in neither tree.
fn vertex_tree(
    bevel: &BeveledMesh,
    crossed: &EdgeField<bool>,
) -> Result<(VertexTree, Vec<Edge>), NumericError> {
    let mesh = &bevel.mesh;
    let mut sets = UnionFind::new(mesh.vertex_count());
    let mut neighbours: Vec<Vec<(Edge, Vertex)>> = vec![Vec::new(); mesh.vertex_count()];
    let mut left = Vec::new();
    let free = || mesh.edges().filter(|&e| !crossed[e]);
    let on_boundary = |e: &Edge| mesh.is_boundary_edge(*e);
    for e in free().filter(on_boundary).chain(free().filter(|e| !on_boundary(e))) {
        check_step(e.index())?;
        let [a, b] = mesh.edge_vertices(e);
        if sets.find(a.0) == sets.find(b.0) {
            left.push(e);
        } else {
            sets.join(a.0, b.0);
            neighbours[a.index()].push((e, b));
            neighbours[b.index()].push((e, a));
        }
    }
    let mut tree =
        VertexTree { parent: vec![None; mesh.vertex_count()], depth: vec![u32::MAX; mesh.vertex_count()] };
    for root in mesh.vertices() {
        if tree.depth[root.index()] != u32::MAX {
            continue;
        }
        tree.depth[root.index()] = 0;
        let mut queue = VecDeque::from([root]);
        while let Some(v) = queue.pop_front() {
            check_step(v.index())?;
            for &(e, w) in &neighbours[v.index()] {
                if tree.depth[w.index()] == u32::MAX {
                    tree.depth[w.index()] = tree.depth[v.index()] + 1;
                    tree.parent[w.index()] = Some((e, v));
                    queue.push_back(w);
                }
            }
        }
    }
    Ok((tree, left))
}

impl VertexTree {
    /// Returns the halfedges along the path between two vertices; of boundary edges passed against
    /// their halfedge, that halfedge.
    fn path(&self, mut from: Vertex, mut to: Vertex, bevel: &BeveledMesh) -> Vec<Halfedge> {
        let mesh = &bevel.mesh;
        let along = |e: Edge, start: Vertex| {
            let halfedges = mesh.edge_halfedges(e);
            halfedges.iter().copied().find(|h| mesh.origin(*h) == start).unwrap_or(halfedges[0])
        };
        let parent = |v: Vertex| self.parent[v.index()].expect("both ends lie in one tree");
        let (mut up, mut down) = (Vec::new(), Vec::new());
        while from != to {
            if self.depth[from.index()] >= self.depth[to.index()] {
                let (e, above) = parent(from);
                up.push(along(e, from));
                from = above;
            } else {
                let (e, above) = parent(to);
                down.push(along(e, above));
                to = above;
            }
        }
        up.extend(down.into_iter().rev());
        up
    }
}
