//! A dense twin of the method, written from its definitions: beveled edges are pairs of corners,
//! cycles are closed walks of corners, the energy is integrated in space, and dense systems give
//! rotations, powers and scales. From the library it takes only the walks of the generators, which
//! give their indices a meaning. Fields are compared with it by their values (`compare.rs`).

mod compare;
mod dense;

use crate::polar_field::bevel::Cycle;
use crate::polar_field::{Place, Singularity};
use dense::{nonnegative_minimum, solved, tied};
use eikona_mesh::{Face, SurfacePoint, Topology, TriangleMesh, Vertex};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::{PI, TAU};

/// The weights of jumps and of targets (PLPF specification: `lam`, `lambda_S`).
const JUMP_WEIGHT: f64 = 10.0;
const TARGET_WEIGHT: f64 = 50.0;

type Vector = [f64; 3];
/// Coefficients of a linear form on beveled edges or corners.
type Form = Vec<(usize, f64)>;

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A beveled mesh of corners `3 f + k`.
struct Twin {
    mesh: TriangleMesh,
    topology: Topology,
    /// From corner, to corner.
    edges: Vec<[usize; 2]>,
    number: HashMap<[usize; 2], usize>,
    /// The face with each directed edge of the mesh, and the side.
    face_of: HashMap<[u32; 2], [usize; 2]>,
    cycles: Vec<(Cycle, Vec<usize>)>,
}

impl Twin {
    fn new(mesh: &TriangleMesh) -> Twin {
        let mut face_of = HashMap::new();
        for (f, face) in mesh.triangles().iter().enumerate() {
            (0..3).for_each(|k| assert!(face_of.insert([face[k], face[(k + 1) % 3]], [f, k]).is_none()));
        }
        let mut edges: Vec<[usize; 2]> = Vec::new();
        for f in 0..mesh.face_count() {
            edges.extend([0, 1, 2].map(|k| [3 * f + k, 3 * f + (k + 1) % 3]));
        }
        for (&[u, w], &[f, k]) in &face_of {
            if let Some(&[g, l]) = face_of.get(&[w, u]) {
                // Around `u`, from the face on the right of the edge to the face on its left.
                edges.push([3 * g + (l + 1) % 3, 3 * f + k]);
            }
        }
        let number = edges.iter().enumerate().map(|(i, &e)| (e, i)).collect();
        let (mesh, topology) = (mesh.clone(), Topology::of(mesh));
        let mut twin = Twin { mesh, topology, edges, number, face_of, cycles: Vec::new() };
        twin.cycles = twin.closed_walks();
        twin
    }

    fn vertex(&self, corner: usize) -> u32 {
        self.mesh.triangles()[corner / 3][corner % 3]
    }

    fn position(&self, corner: usize) -> Vector {
        self.mesh.positions()[self.vertex(corner) as usize]
    }

    /// The corners around a vertex, counter-clockwise from this one; until it comes again, or the
    /// boundary.
    fn fan(&self, first: usize) -> Vec<usize> {
        let v = self.vertex(first);
        let mut fan = vec![first];
        while let Some(&[f, k]) = self.face_of.get(&[v, self.vertex(previous(fan[fan.len() - 1]))]) {
            if 3 * f + k == first {
                break;
            }
            fan.push(3 * f + k);
        }
        fan
    }

    fn is_closed(&self, fan: &[usize]) -> bool {
        self.face_of.contains_key(&[self.vertex(fan[0]), self.vertex(previous(fan[fan.len() - 1]))])
    }

    /// The boundary of every cycle as a counter-clockwise walk of corners, without the first one
    /// again.
    fn closed_walks(&self) -> Vec<(Cycle, Vec<usize>)> {
        let mut walks = Vec::new();
        for f in 0..self.mesh.face_count() {
            walks.push((Cycle::Face(Face(f as u32)), vec![3 * f, 3 * f + 1, 3 * f + 2]));
        }
        for (&[u, w], &[f, k]) in self.face_of.iter().filter(|([u, w], _)| u < w) {
            if let Some(&[g, l]) = self.face_of.get(&[w, u]) {
                let edge = self.mesh.find_edge(Vertex(u), Vertex(w)).unwrap();
                let walk = vec![3 * f + (k + 1) % 3, 3 * f + k, 3 * g + (l + 1) % 3, 3 * g + l];
                walks.push((Cycle::Edge(edge), walk));
            }
        }
        let mut seen = vec![false; self.mesh.vertex_count()];
        for corner in 0..3 * self.mesh.face_count() {
            let fan = self.fan(corner);
            let v = self.vertex(corner) as usize;
            if self.is_closed(&fan) && !std::mem::replace(&mut seen[v], true) {
                walks.push((Cycle::Vertex(Vertex(v as u32)), fan));
            }
        }
        for (b, boundary) in self.topology.boundary_loops.iter().enumerate() {
            // With the surface on the right: against the faces' orientation.
            let mut walk = Vec::new();
            for (i, &v) in boundary.vertices.iter().enumerate().rev() {
                let next = boundary.vertices[(i + 1) % boundary.vertices.len()];
                let [f, k] = self.face_of[&[v.0, next.0]];
                walk.extend(self.fan(3 * f + k));
            }
            walks.push((Cycle::Boundary(b as u32), walk));
        }
        walks
    }

    /// The sum along a closed walk as a linear form on the beveled edges.
    fn sum(&self, walk: &[usize]) -> Form {
        let step = |i: usize| {
            let (from, to) = (walk[i], walk[(i + 1) % walk.len()]);
            match self.number.get(&[from, to]) {
                Some(&edge) => (edge, 1.0),
                None => (self.number[&[to, from]], -1.0),
            }
        };
        (0..walk.len()).map(step).collect()
    }

    /// The form on corners that is a form on edges, applied to differences.
    fn of_corners(&self, form: &Form) -> Form {
        form.iter().flat_map(|&(e, x)| [(self.edges[e][1], x), (self.edges[e][0], -x)]).collect()
    }

    fn angle(&self, corner: usize) -> f64 {
        let here = self.position(corner);
        let [a, b] = [next(corner), previous(corner)].map(|c| sub(self.position(c), here));
        dot(cross(a, b), cross(a, b)).sqrt().atan2(dot(a, b))
    }

    fn area(&self, f: usize) -> f64 {
        0.5 * dot(self.normal(f), self.normal(f)).sqrt()
    }

    /// The normal of a face, of twice its area.
    fn normal(&self, f: usize) -> Vector {
        let [a, b, c] = [0, 1, 2].map(|k| self.position(3 * f + k));
        cross(sub(b, a), sub(c, a))
    }

    /// The curvature of a cycle.
    fn curvature(&self, cycle: Cycle, walk: &[usize]) -> f64 {
        let angles: f64 = walk.iter().map(|&c| self.angle(c)).sum();
        match cycle {
            Cycle::Vertex(_) => TAU - angles,
            Cycle::Boundary(b) => {
                PI * self.topology.boundary_loops[b as usize].vertices.len() as f64 - angles
            }
            _ => 0.0,
        }
    }

    /// The curvature on the right of a walk through faces on its right: pi less the angles passed
    /// at each vertex.
    fn curvature_of_generator(&self, walk: &[usize]) -> f64 {
        let angles: f64 = walk.iter().map(|&c| self.angle(c)).sum();
        let from = |i: usize| walk[(i + walk.len() - 1) % walk.len()];
        let vertices = (0..walk.len()).filter(|&i| self.vertex(from(i)) != self.vertex(walk[i])).count();
        PI * vertices as f64 - angles
    }

    /// The mean of the gradient of a rotation in a face: Whitney forms at the centroid.
    fn face_term(&self, f: usize) -> Vec<(Form, f64)> {
        let normal = self.normal(f);
        let gradients = [0, 1, 2].map(|k| {
            let [p, q] = [1, 2].map(|i| self.position(3 * f + (k + i) % 3));
            cross(normal, sub(q, p)).map(|x| x / dot(normal, normal))
        });
        let along = |axis: usize| {
            let form = (0..3).map(|k| (3 * f + k, (gradients[(k + 1) % 3][axis] - gradients[k][axis]) / 3.0));
            (form.collect(), 3.0 * self.area(f))
        };
        (0..3).map(along).collect()
    }

    /// The jump across an edge, which is linear along it, at two Gauss points.
    fn edge_term(&self, [u, w]: [u32; 2]) -> Vec<(Form, f64)> {
        let ([f, k], [g, l]) = (self.face_of[&[u, w]], self.face_of[&[w, u]]);
        let [at_u, at_w] = [[3 * g + (l + 1) % 3, 3 * f + k], [3 * f + (k + 1) % 3, 3 * g + l]];
        let (at_u, at_w) = (self.number[&at_u], self.number[&at_w]);
        let side = sub(self.position(3 * f + k), self.position(3 * g + l));
        let weight = JUMP_WEIGHT * dot(side, side) / (self.area(f) + self.area(g));
        let at = |t: f64| (vec![(at_u, 1.0 - t), (at_w, -t)], 0.5 * weight);
        let off = 0.5 / 3f64.sqrt();
        vec![at(0.5 - off), at(0.5 + off)]
    }

    fn energy_terms(&self) -> Vec<(Form, f64)> {
        let faces = (0..self.mesh.face_count()).flat_map(|f| self.face_term(f));
        let inner = self.face_of.keys().filter(|[u, w]| u < w && self.face_of.contains_key(&[*w, *u]));
        faces.chain(inner.flat_map(|&edge| self.edge_term(edge))).collect()
    }

    /// The terms next to a singularity, each with the value of the target there.
    fn target_terms(&self, s: &Singularity, degree: u32) -> Vec<(Form, f64, f64)> {
        let turns = (s.index * f64::from(degree)).round();
        let mut target: HashMap<usize, f64> = HashMap::new();
        let mut terms = Vec::new();
        // The angle under which a point sees a side.
        let seen = |corner: usize, s: Vector| {
            let [a, b] = [corner, next(corner)].map(|c| sub(self.position(c), s));
            let normal = self.normal(corner / 3);
            (dot(cross(a, b), normal) / dot(normal, normal).sqrt()).atan2(dot(a, b))
        };
        match s.place {
            _ if turns == 0.0 => {}
            Place::Boundary(_) => {}
            Place::Point(SurfacePoint::Face { vertices, bary }) => {
                let f = self.mesh.find_face(vertices.map(Vertex)).unwrap().index();
                let s = self.mean(&vertices, &bary);
                target.extend((3 * f..3 * f + 3).map(|c| (c, turns * seen(c, s))));
                terms.extend(self.face_term(f));
            }
            Place::Point(SurfacePoint::Edge { vertices: [u, w], t }) => {
                let s = self.mean(&[u, w], &[1.0 - t, t]);
                for [f, k] in [[u, w], [w, u]].map(|edge| self.face_of[&edge]) {
                    let corner = 3 * f + k;
                    target.extend([next(corner), previous(corner)].map(|c| (c, turns * seen(c, s))));
                    target.insert(corner, -PI * turns);
                    terms.extend(self.face_term(f));
                }
                terms.extend(self.edge_term([u, w]));
            }
            Place::Point(SurfacePoint::Vertex { vertex }) => {
                let (cycle, fan) =
                    self.cycles.iter().find(|(c, _)| *c == Cycle::Vertex(Vertex(vertex))).unwrap();
                let whole = TAU * turns - f64::from(degree) * self.curvature(*cycle, fan);
                let angles: f64 = fan.iter().map(|&c| self.angle(c)).sum();
                for (i, &corner) in fan.iter().enumerate() {
                    let share = self.angle(corner) / angles * whole;
                    target.extend([(corner, -0.5 * share), (previous(corner), -0.5 * share)]);
                    target.insert(next(corner), share);
                    let before = fan[(i + fan.len() - 1) % fan.len()];
                    let jump = self.number[&[before, corner]];
                    target.insert(jump, 0.5 * (self.angle(before) + self.angle(corner)) / angles * whole);
                    terms.extend(self.face_term(corner / 3));
                    terms.extend(self.edge_term([vertex, self.vertex(next(corner))]));
                }
            }
        }
        let value = |form: &Form| form.iter().map(|(e, x)| x * target.get(e).unwrap_or(&0.0)).sum::<f64>();
        terms
            .into_iter()
            .map(|(form, weight)| (value(&form), form, weight))
            .map(|(v, f, w)| (f, w, v))
            .collect()
    }

    fn mean(&self, vertices: &[u32], weights: &[f64]) -> Vector {
        let mut sum = [0.0; 3];
        for (&v, weight) in vertices.iter().zip(weights) {
            (0..3).for_each(|k| sum[k] += weight * self.mesh.positions()[v as usize][k]);
        }
        sum
    }

    /// The rows and values of all constraints on the rotation, less one cycle per component.
    fn constraints(
        &self,
        singularities: &[Singularity],
        degree: u32,
        generators: &[(Vec<usize>, f64)],
    ) -> Vec<(Form, f64)> {
        let n = f64::from(degree);
        let mut index: BTreeMap<Cycle, f64> = BTreeMap::new();
        for s in singularities {
            index.insert(self.cycle_of(s.place), s.index);
        }
        let mut rows = Vec::new();
        let mut seen = vec![false; self.topology.components.len()];
        for (cycle, walk) in &self.cycles {
            let component = self.topology.component_of_face[Face((walk[0] / 3) as u32)] as usize;
            if std::mem::replace(&mut seen[component], true) {
                let index = index.get(cycle).unwrap_or(&0.0);
                rows.push((self.sum(walk), n * (TAU * index - self.curvature(*cycle, walk))));
            }
        }
        for (walk, index) in generators {
            rows.push((self.sum(walk), n * (TAU * index - self.curvature_of_generator(walk))));
        }
        rows
    }

    fn cycle_of(&self, place: Place) -> Cycle {
        match place {
            Place::Boundary(b) => Cycle::Boundary(b as u32),
            Place::Point(SurfacePoint::Vertex { vertex }) => Cycle::Vertex(Vertex(vertex)),
            Place::Point(SurfacePoint::Edge { vertices: [u, w], .. }) => {
                Cycle::Edge(self.mesh.find_edge(Vertex(u), Vertex(w)).unwrap())
            }
            Place::Point(SurfacePoint::Face { vertices, .. }) => {
                Cycle::Face(self.mesh.find_face(vertices.map(Vertex)).unwrap())
            }
        }
    }

    /// The smoothest rotation, by one dense system with a multiplier per constraint.
    fn rotation(
        &self,
        singularities: &[Singularity],
        degree: u32,
        generators: &[(Vec<usize>, f64)],
    ) -> Vec<f64> {
        let constraints = self.constraints(singularities, degree, generators);
        let unknowns = self.edges.len();
        let size = unknowns + constraints.len();
        let (mut matrix, mut rhs) = (vec![vec![0.0; size]; size], vec![0.0; size]);
        let free = self.energy_terms().into_iter().map(|(form, weight)| (form, weight, 0.0));
        let wanted = singularities.iter().flat_map(|s| self.target_terms(s, degree));
        for (form, weight, value) in free.chain(wanted.map(|(f, w, v)| (f, TARGET_WEIGHT * w, v))) {
            for &(i, x) in &form {
                form.iter().for_each(|&(j, y)| matrix[i][j] += weight * x * y);
                rhs[i] += weight * x * value;
            }
        }
        for (c, (form, value)) in constraints.iter().enumerate() {
            for &(i, x) in form {
                matrix[unknowns + c][i] += x;
                matrix[i][unknowns + c] += x;
            }
            rhs[unknowns + c] = *value;
        }
        let mut theta = solved(&matrix, &rhs);
        theta.truncate(unknowns);
        theta
    }

    /// The power of each face, from the rotation in it.
    fn powers(&self, singularities: &[Singularity], degree: u32, theta: &[f64]) -> Vec<u32> {
        let faces = self.mesh.face_count();
        let (mut fixed, mut singular) = (vec![0u32; faces], vec![false; faces]);
        for s in singularities {
            let power = (s.index * f64::from(degree)).round().abs() as u32;
            let around: Vec<usize> = match self.cycle_of(s.place) {
                _ if power == 0 => Vec::new(),
                Cycle::Boundary(_) => Vec::new(),
                Cycle::Face(f) => {
                    singular[f.index()] = true;
                    vec![f.index()]
                }
                cycle => {
                    let walk = &self.cycles.iter().find(|(c, _)| *c == cycle).unwrap().1;
                    walk.iter().map(|c| c / 3).collect()
                }
            };
            around.iter().for_each(|&f| fixed[f] = fixed[f].max(power));
        }
        for s in singularities {
            let power = (s.index * f64::from(degree)).round().abs() as u32;
            if let Cycle::Face(f) = self.cycle_of(s.place)
                && power != 0
            {
                fixed[f.index()] = power;
            }
        }
        let mut matrix = vec![vec![0.0; faces]; faces];
        let mut rhs = vec![0.0; faces];
        for (&[u, w], &[f, k]) in &self.face_of {
            if let Some(&[g, _]) = self.face_of.get(&[w, u]) {
                let side = sub(self.position(3 * f + k), self.position(next(3 * f + k)));
                let weight = 3.0 * dot(side, side) / (self.area(f) + self.area(g));
                matrix[f][f] += weight;
                matrix[f][g] -= weight;
            }
        }
        for f in 0..faces {
            let component = self.topology.component_of_face[Face(f as u32)];
            let here = |g: &usize| self.topology.component_of_face[Face(*g as u32)] == component;
            // Without a source, the power is 1.
            let free = (0..faces).filter(here).all(|g| fixed[g] == 0);
            if fixed[f] > 0 || free {
                matrix[f] = (0..faces).map(|g| f64::from(u8::from(f == g))).collect();
                rhs[f] = f64::from(fixed[f].max(1));
            }
        }
        let interpolated = solved(&matrix, &rhs);
        let power = |f: usize| {
            let largest = (0..3).map(|k| theta[3 * f + k].abs()).fold(0.0, f64::max);
            let least = if singular[f] { 1 } else { (largest / PI).floor() as u32 + 1 };
            (interpolated[f].round() as u32).max(1).max(least)
        };
        (0..faces).map(power).collect()
    }

    /// Ratios of the scales of two corners that place the singular points.
    fn ties(
        &self,
        singularities: &[Singularity],
        degree: u32,
        theta: &[f64],
        powers: &[u32],
    ) -> Vec<([usize; 2], f64)> {
        let mut ties = Vec::new();
        for s in singularities {
            let turns = (s.index * f64::from(degree)).round();
            match s.place {
                Place::Point(SurfacePoint::Face { vertices, bary }) if turns != 0.0 => {
                    let f = self.mesh.find_face(vertices.map(Vertex)).unwrap().index();
                    let m = f64::from(powers[f]);
                    let sign = turns.signum();
                    if (3 * f..3 * f + 3).any(|c| sign * theta[c] <= 0.0 || sign * theta[c] >= m * PI) {
                        continue;
                    }
                    let phases = [0.0, theta[3 * f], theta[3 * f] + theta[3 * f + 1]].map(|p| p / m);
                    let weights = [0, 1, 2].map(|k| {
                        let v = self.vertex(3 * f + k);
                        bary[vertices.iter().position(|w| *w == v).unwrap()]
                    });
                    // The magnitudes with which the linear field vanishes at the point.
                    let part = |of: fn(f64) -> f64| [0, 1, 2].map(|k| weights[k] * of(phases[k]));
                    let base = cross(part(f64::cos), part(f64::sin));
                    let ratio = |k: usize| (base[k] / base[0]).powf(m);
                    ties.extend([1, 2].map(|k| ([3 * f, 3 * f + k], ratio(k))));
                }
                Place::Point(SurfacePoint::Edge { vertices: [u, w], t }) if turns != 0.0 => {
                    let ([f, k], [g, l]) = (self.face_of[&[u, w]], self.face_of[&[w, u]]);
                    let (fu, fw, gw, gu) = (3 * f + k, next(3 * f + k), 3 * g + l, next(3 * g + l));
                    // Phases along the walk w in f, u in f, u in g, w in g; around the singular
                    // point the field has turned by half of the index from one face to the other.
                    let at_fu = -theta[fu];
                    let at_gu = at_fu - theta[self.number[&[gu, fu]]];
                    let at_gw = at_gu - theta[gw];
                    let half = PI * turns;
                    let (low, high) = (
                        f64::max(at_fu.min(0.0), at_gu.min(at_gw) - half),
                        f64::min(at_fu.max(0.0), at_gu.max(at_gw) - half),
                    );
                    if low >= high {
                        continue;
                    }
                    let middle = 0.5 * (low + high);
                    for (face, [at_u, at_w], [cu, cw]) in
                        [(f, [at_fu, 0.0], [fu, fw]), (g, [at_gu - half, at_gw - half], [gu, gw])]
                    {
                        let m = f64::from(powers[face]);
                        let [a, b] = [at_u, at_w].map(|phase| ((phase - middle) / m).sin());
                        // The component across the middle phase vanishes: (1 - t) x a + t y b = 0.
                        ties.push(([cu, cw], (-(1.0 - t) * a / (t * b)).powf(m)));
                    }
                }
                _ => {}
            }
        }
        ties
    }

    /// The smoothest scales of at least 1 with these ratios, by the active set of nonnegative least
    /// squares (Lawson and Hanson): one corner enters at a time.
    fn scales(&self, ties: &[([usize; 2], f64)]) -> Vec<f64> {
        let corners = 3 * self.mesh.face_count();
        let (group, factor) = tied(ties, corners);
        let energy = self.scale_energy();
        let mut reduced = vec![vec![0.0; corners]; corners];
        for i in 0..corners {
            for j in 0..corners {
                reduced[group[i]][group[j]] += factor[i] * factor[j] * energy[i][j];
            }
        }
        let above = nonnegative_minimum(&reduced, &group);
        (0..corners).map(|c| (1.0 + above[group[c]]) * factor[c]).collect()
    }

    /// The matrix of the energy of functions on corners.
    fn scale_energy(&self) -> Vec<Vec<f64>> {
        let corners = 3 * self.mesh.face_count();
        let mut energy = vec![vec![0.0; corners]; corners];
        for (form, weight) in self.energy_terms() {
            let form = self.of_corners(&form);
            for &(i, x) in &form {
                form.iter().for_each(|&(j, y)| energy[i][j] += weight * x * y);
            }
        }
        energy
    }
}

fn next(corner: usize) -> usize {
    corner - corner % 3 + (corner + 1) % 3
}

fn previous(corner: usize) -> usize {
    next(next(corner))
}
