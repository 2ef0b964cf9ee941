//! Trivial connections (Crane, Desbrun and Schröder 2010): the rotation from face to face with
//! prescribed indices and the least square sum, without rotation inside faces. The field is
//! constant in each face, and singular at vertices only.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::domain::Domain;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::homology::Step;
use crate::polar_field::problem::Problem;
use crate::polar_field::responses::Dense;
use crate::polar_field::singularity::{Prescribed, name};
use eikona_mesh::{Halfedge, Vertex};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, nested_dissection_order,
};

/// Returns the rotation of the trivial connection.
///
/// The one of least squares is a gradient on the vertices (a boundary loop counts as one vertex)
/// plus a combination of the generators.
///
/// # Cost
/// A factorisation on the vertices, and one solve per generator.
pub(crate) fn trivial_rotation(
    domain: &Domain,
    problem: &Problem<'_>,
    resources: Resources,
) -> Result<Rotation, PolarFieldError> {
    let Domain { bevel, homology, .. } = domain;
    let off_vertex = |s: &&Prescribed| matches!(s.cycle, Cycle::Face(_) | Cycle::Edge(_)) && s.turns != 0;
    if let Some(s) = problem.prescribed.iter().find(off_vertex) {
        return Err(PolarFieldError::NotAtVertex { element: name(s.cycle) });
    }
    let nodes = Nodes { bevel };
    let factor = nodes.laplacian(resources)?;
    let sums: Vec<f64> = nodes.sums_of(problem);
    let generators: Vec<Vec<(Halfedge, f64)>> =
        homology.generators.iter().map(|generator| crossings(bevel, &generator.walk)).collect();
    let divergences: Vec<Vec<f64>> = generators.iter().map(|g| nodes.divergence(g)).collect();
    let potential = factor.solve(&sums)?;
    let responses = factor.solve_many(&divergences)?;
    // The part of each generator that is no gradient, on every generator.
    let mut system = Dense::zeros(generators.len());
    let mut missing = Vec::with_capacity(generators.len());
    for (j, generator) in generators.iter().enumerate() {
        for i in 0..=j {
            let of_gradient: f64 = dot(&divergences[j], &responses[i]);
            system.set(i, j, product(generator, &generators[i]) - of_gradient);
        }
        missing.push(problem.along[j] - dot(&divergences[j], &potential));
    }
    let shares = if generators.is_empty() { Vec::new() } else { system.factor()?.solve(&missing)? };
    let value = |node: usize| {
        potential[node] - responses.iter().zip(&shares).map(|(r, share)| r[node] * share).sum::<f64>()
    };
    let mut theta = bevel.zero();
    for (h, twin) in bevel.edges() {
        let [from, to] = [h, twin].map(|h| nodes.of(bevel.mesh.origin(h)));
        let jump = value(from) - value(to);
        theta.jump[h] = jump;
        theta.jump[twin] = -jump;
    }
    for (generator, share) in generators.iter().zip(&shares) {
        for &(h, times) in generator {
            let twin = bevel.twin[h].expect("generators cross interior edges");
            theta.jump[h] += share * times;
            theta.jump[twin] -= share * times;
        }
    }
    Ok(theta)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns how often a walk crosses each edge, from the face of the twin of the edge's first
/// halfedge to its own.
fn crossings(bevel: &BeveledMesh, walk: &[Step]) -> Vec<(Halfedge, f64)> {
    let mut crossed: Vec<(Halfedge, f64)> = Vec::new();
    for step in walk {
        if let &Step::Jump(h) = step {
            let twin = bevel.twin[h].expect("generators cross interior edges");
            crossed.push(if h < twin { (h, 1.0) } else { (twin, -1.0) });
        }
    }
    crossed.sort_by_key(|(h, _)| *h);
    crossed
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| (same[0].0, same.iter().map(|(_, times)| times).sum()))
        .collect()
}

/// Returns the sum of products over the edges that both cross.
fn product(a: &[(Halfedge, f64)], b: &[(Halfedge, f64)]) -> f64 {
    let other = |h: Halfedge| b.binary_search_by_key(&h, |(h, _)| *h).map_or(0.0, |i| b[i].1);
    a.iter().map(|&(h, times)| times * other(h)).sum()
}

/// The vertices inside the surface, and one node per boundary loop.
struct Nodes<'a> {
    bevel: &'a BeveledMesh,
}

impl Nodes<'_> {
    fn of(&self, v: Vertex) -> usize {
        self.bevel.loop_of_vertex(v).map_or(v.index(), |b| self.bevel.mesh.vertex_count() + b as usize)
    }

    fn count(&self) -> usize {
        self.bevel.mesh.vertex_count() + self.bevel.topology.boundary_loops.len()
    }

    /// Factors the Laplacian of the graph of edges, with one node per component drawn to zero.
    fn laplacian(&self, resources: Resources) -> Result<Cholesky<f64>, NumericError> {
        let mesh = &self.bevel.mesh;
        let mut graph = Graph { unknowns: self.count(), pairs: Vec::new() };
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; self.count()], off_diagonal: Vec::new() };
        for (h, twin) in self.bevel.edges() {
            let [a, b] = [h, twin].map(|h| self.of(mesh.origin(h)));
            // An edge between two vertices of one loop is crossed without any sum changing.
            if a != b {
                matrix.diagonal[a] += 1.0;
                matrix.diagonal[b] += 1.0;
                graph.pairs.push([a as u32, b as u32]);
                matrix.off_diagonal.push(-1.0);
            }
        }
        for component in &self.bevel.topology.components {
            let [v, ..] = mesh.face_vertices(component.first_face);
            matrix.diagonal[self.of(v)] += 1.0;
        }
        // Nodes without edges, such as the vertices of boundary loops.
        matrix.diagonal.iter_mut().filter(|x| **x == 0.0).for_each(|x| *x = 1.0);
        let loops = self.bevel.topology.boundary_loops.iter();
        let positions: Vec<[f64; 3]> = mesh
            .positions()
            .iter()
            .copied()
            .chain(loops.map(|boundary| boundary.vertices.first().map_or([0.0; 3], |&v| mesh.position(v))))
            .collect();
        let order = nested_dissection_order(&graph, &positions, resources.threads)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        Cholesky::within(resources, symbolic.into(), &matrix)
    }

    /// Returns what the rotation must add up to around each node.
    fn sums_of(&self, problem: &Problem<'_>) -> Vec<f64> {
        let mut sums = vec![0.0; self.count()];
        for cycle in self.bevel.cycles() {
            match cycle {
                Cycle::Vertex(v) => sums[v.index()] = problem.around[cycle],
                Cycle::Boundary(b) => {
                    sums[self.bevel.mesh.vertex_count() + b as usize] = problem.around[cycle]
                }
                Cycle::Face(_) | Cycle::Edge(_) => {}
            }
        }
        sums
    }

    /// Returns the sums around the nodes of a rotation of these amounts at edges.
    fn divergence(&self, amounts: &[(Halfedge, f64)]) -> Vec<f64> {
        let mut sums = vec![0.0; self.count()];
        for &(h, times) in amounts {
            sums[self.of(self.bevel.mesh.origin(h))] += times;
            sums[self.of(self.bevel.mesh.tip(h))] -= times;
        }
        sums
    }
}
