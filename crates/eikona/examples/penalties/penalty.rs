//! Step III of the signed heat method with penalties that the library does not have.
//!
//! The fit minimizes `E(phi) + P(phi)`. `E` is half the integral of `|grad phi - Y|^2` for the unit
//! field `Y` of a library solve, and `P` is the integral along the curves of a function of `phi`.
//! Penalties that are not quadratic are solved by reweighting (IRLS): each fit has the quadratic
//! penalty with the same derivative at the values of the fit before.

use eikona::geometry::vector::{distance, dot, normalize, scale, sub};
use eikona::geometry::{Triangle, lay_out, mean_edge_length};
use eikona::mesh::{Face, Located, SegmentHost, SurfaceCurves, TriangleMesh};
use eikona::numeric::{Cholesky, Complex, Ordering, Symbolic, nested_dissection_order};
use eikona::operators::{CotanLaplacian, divergence};
use std::collections::HashSet;
use std::sync::Arc;

/// Quadrature node on a curve.
struct Node {
    place: Located,
    /// Length of curve that the node stands for.
    length: f64,
    /// Curve of the source that the node belongs to.
    curve: usize,
}

/// Curves on a mesh, as nodes of Simpson's rule along each segment. The rule is exact for squares
/// of linear functions.
pub struct Nodes {
    nodes: Vec<Node>,
    curves: usize,
}

impl Nodes {
    /// Places the nodes of signed curves. Of segments that coincide, one counts.
    pub fn of(mesh: &TriangleMesh, source: &SurfaceCurves) -> Nodes {
        let mut nodes = Vec::new();
        let mut seen = HashSet::new();
        for segment in source.segments(mesh).unwrap() {
            let mut keys = segment.ends.map(|end| end.key());
            keys.sort_unstable();
            if !seen.insert(keys) {
                continue;
            }
            let [p, q] = segment.ends.map(|end| end.position(mesh));
            let length = distance(p, q);
            let middle = match segment.host {
                SegmentHost::Edge(edge, [s, t]) => Located::Edge(edge, 0.5 * (s + t)),
                SegmentHost::Face(face, [a, b]) => {
                    Located::in_face(mesh, face, [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
                }
            };
            let [from, to] = segment.ends;
            for (place, share) in [(from, 1.0 / 6.0), (middle, 4.0 / 6.0), (to, 1.0 / 6.0)] {
                nodes.push(Node { place, length: share * length, curve: segment.curve });
            }
        }
        Nodes { nodes, curves: source.curves.len() }
    }

    /// Returns the value of a function at each node.
    pub fn values(&self, mesh: &TriangleMesh, phi: &[f64]) -> Vec<f64> {
        self.nodes.iter().map(|node| node.place.interpolate(mesh, phi)).collect()
    }

    /// Returns the integral along all curves of a function with these values.
    pub fn integral(&self, values: &[f64]) -> f64 {
        self.nodes.iter().zip(values).map(|(node, value)| node.length * value).sum()
    }

    /// Returns for each node the integral along its curve of a function with these values.
    fn integral_of_curve(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.curves];
        for (node, value) in self.nodes.iter().zip(values) {
            sums[node.curve] += node.length * value;
        }
        self.nodes.iter().map(|node| sums[node.curve]).collect()
    }

    /// Returns for each node the length of its curve.
    fn length_of_curve(&self) -> Vec<f64> {
        self.integral_of_curve(&vec![1.0; self.nodes.len()])
    }
}

/// Penalty on the values along curves. Lengths are in mean edge lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Penalty {
    /// `force |phi|`, with the square below the threshold: Huber's function. With a threshold much
    /// smaller than the edges, it is the absolute value. A curve changes the slope across it by at
    /// most `force`.
    Huber { force: f64, threshold: f64 },
    /// The same function of each curve's root mean square, times its length: curves are held or
    /// given up as a whole.
    HuberOfCurves { force: f64, threshold: f64 },
}

impl Penalty {
    /// Returns the weight at each node, one over length, of the quadratic penalty with the same
    /// derivative at `values`.
    fn weights(self, nodes: &Nodes, edge: f64, values: &[f64]) -> Vec<f64> {
        match self {
            Penalty::Huber { force, threshold } => {
                values.iter().map(|value| force / value.abs().max(threshold * edge)).collect()
            }
            Penalty::HuberOfCurves { force, threshold } => {
                let squares: Vec<f64> = values.iter().map(|value| value * value).collect();
                let squares = nodes.integral_of_curve(&squares);
                let spread =
                    squares.iter().zip(nodes.length_of_curve()).map(|(s, length)| (s / length).sqrt());
                spread.map(|spread| force / spread.max(threshold * edge)).collect()
            }
        }
    }
}

/// Fits on one mesh, with one symbolic analysis.
pub struct Fits<'a> {
    mesh: &'a TriangleMesh,
    triangles: Vec<Triangle>,
    laplacian: CotanLaplacian,
    symbolic: Arc<Symbolic>,
    /// Mean edge length.
    pub edge: f64,
}

impl<'a> Fits<'a> {
    pub fn new(mesh: &'a TriangleMesh) -> Fits<'a> {
        let triangles = lay_out(mesh);
        let laplacian = CotanLaplacian::new(mesh, &triangles);
        let order = nested_dissection_order(&laplacian.graph, mesh.positions(), 1).unwrap();
        let symbolic = Symbolic::new(&laplacian.graph, Ordering::Given(&order)).unwrap().into();
        let edge = mean_edge_length(mesh, &triangles);
        Fits { mesh, triangles, laplacian, symbolic, edge }
    }

    /// Returns the right-hand side for a unit field with one vector in space per face.
    pub fn right_hand_side(&self, field: &[[f64; 3]]) -> Vec<f64> {
        let in_layout = |(face, y): (Face, &[f64; 3])| {
            let [a, b, c] = self.mesh.face_positions(face);
            let along = normalize(sub(b, a)).unwrap_or_default();
            let other = sub(c, a);
            let across = normalize(sub(other, scale(along, dot(other, along)))).unwrap_or_default();
            Complex { re: dot(*y, along), im: dot(*y, across) }
        };
        let field: Vec<Complex> = self.mesh.faces().zip(field).map(in_layout).collect();
        divergence(self.mesh, &self.triangles, &field).into_iter().map(|x| -x).collect()
    }

    /// Returns the fit with a quadratic penalty: half the integral of `weight phi^2`, with one
    /// weight per node.
    pub fn quadratic(&self, rhs: &[f64], nodes: &Nodes, weights: &[f64]) -> Vec<f64> {
        let mut matrix = self.laplacian.matrix.clone();
        for (node, weight) in nodes.nodes.iter().zip(weights) {
            let spanning: Vec<_> = node.place.weights(self.mesh).collect();
            for (m, &(i, wi)) in spanning.iter().enumerate() {
                matrix.diagonal[i.index()] += weight * node.length * wi * wi;
                for &(j, wj) in &spanning[m + 1..] {
                    let entry = self.laplacian.entry(self.mesh, i.0, j.0).unwrap();
                    matrix.off_diagonal[entry] += weight * node.length * wi * wj;
                }
            }
        }
        // Vertices without faces occur in no equation.
        matrix.diagonal.iter_mut().filter(|d| **d == 0.0).for_each(|d| *d = 1.0);
        Cholesky::new(self.symbolic.clone(), &matrix).unwrap().solve(rhs).unwrap()
    }

    /// Returns the fit with a quadratic penalty whose weight is multiplied by a power of the length
    /// of the curve, relative to the mean over the nodes.
    pub fn by_length(&self, rhs: &[f64], nodes: &Nodes, weight: f64, power: f64) -> Vec<f64> {
        let lengths = nodes.length_of_curve();
        let all = nodes.integral(&vec![1.0; lengths.len()]);
        let powers: Vec<f64> = lengths.iter().map(|length| length.powf(power)).collect();
        let mean = nodes.integral(&powers) / all;
        let weights: Vec<f64> = powers.iter().map(|p| weight * p / mean).collect();
        self.quadratic(rhs, nodes, &weights)
    }

    /// Returns the fit with the quadratic penalty that has the derivative of `penalty` at `values`,
    /// which are those of the fit before.
    pub fn reweighted(&self, rhs: &[f64], nodes: &Nodes, penalty: Penalty, values: &[f64]) -> Vec<f64> {
        let weights = penalty.weights(nodes, self.edge, &nodes.values(self.mesh, values));
        self.quadratic(rhs, nodes, &weights)
    }
}
