//! Labels of level sets of which half is missing at random (SHM section 9.5.3), compared with those
//! of the whole curve and with other rules for the level on the same winding number. Every test
//! prints its table.

#[path = "../examples/broken_curves/surfaces.rs"]
#[allow(dead_code)] // the surfaces are others here
mod broken_curves;
mod regions;

use broken_curves::eigenfunctions;
use eikona::geometry::vector::distance;
use eikona::mesh::random::Random;
use eikona::mesh::{Curve, Face, Halfedge, SurfaceCurves, TriangleMesh, Vertex, damage, io, shapes};
use eikona::winding::{Completion, Winding, WindingOptions, surface_winding_number};
use regions::{area, boundary_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::OnceLock;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// A surface with its name and its lowest eigenfunctions.
type Surface = (&'static str, TriangleMesh, Vec<(f64, Vec<f64>)>);

/// The surfaces, built once for all tests.
fn surfaces() -> &'static [Surface] {
    static SURFACES: OnceLock<Vec<Surface>> = OnceLock::new();
    SURFACES.get_or_init(|| {
        let with_functions = |(name, mesh)| {
            let functions = eigenfunctions(&mesh, FUNCTIONS);
            (name, mesh, functions)
        };
        meshes().into_iter().map(with_functions).collect()
    })
}

/// Six analytic surfaces, and three files if the data folder exists; a file missing from it is an
/// error.
fn meshes() -> Vec<(&'static str, TriangleMesh)> {
    let torus = shapes::torus(1.0, 0.4, 72, 36).unwrap();
    let cylinder = shapes::cylinder(0.5, 2.0, 48, 60, shapes::Ends::Open).unwrap();
    let mut surfaces = vec![
        ("bumpy sphere", shapes::bumpy_sphere(20, 0.3, 4.0).unwrap()),
        ("clay animal", shapes::clay_animal(3).unwrap()),
        ("torus", damage::jitter(&torus, 0.15, 5).unwrap()),
        ("open cylinder", damage::jitter(&cylinder, 0.15, 6).unwrap()),
        ("chain of genus 2", shapes::chain_of_genus(2, 3).unwrap()),
        ("chain of genus 3", shapes::chain_of_genus(3, 3).unwrap()),
    ];
    if Path::new(DATA).exists() {
        for file in ["closed/spot.obj", "closed/bunny.obj", "closed/double-torus.obj"] {
            let mesh = io::read_mesh(Path::new(DATA).join(file)).unwrap().mesh.triangulate().unwrap().0;
            surfaces.push((file, mesh));
        }
    }
    println!("{} files run", surfaces.len() - 6);
    surfaces
}

#[test]
fn the_lowest_eigenfunctions_of_the_sphere_have_its_eigenvalues() {
    let sphere = shapes::geodesic_sphere(16).unwrap();
    let functions = eigenfunctions(&sphere, 5);
    for ((value, _), exact) in functions.iter().zip([2.0, 2.0, 2.0, 6.0, 6.0]) {
        assert!((value / exact - 1.0).abs() < 0.01, "{value} for {exact}");
    }
}

/// Returns the faces with the largest values, up to a share of the area.
fn upper_part(mesh: &TriangleMesh, values: &[f64], share: f64) -> Vec<bool> {
    let sum = |f: Face| mesh.face_vertices(f).iter().map(|v| values[v.index()]).sum::<f64>();
    let mut order: Vec<Face> = mesh.faces().collect();
    order.sort_by(|&a, &b| sum(b).total_cmp(&sum(a)));
    let mut left = share * mesh.faces().map(|f| area(mesh, f)).sum::<f64>();
    let mut inside = vec![false; mesh.face_count()];
    for f in order {
        left -= area(mesh, f);
        inside[f.index()] = left >= 0.0;
    }
    inside
}

/// Returns the region and a strip of triangles around it.
fn grown(mesh: &TriangleMesh, inside: &[bool]) -> Vec<bool> {
    let mut result = inside.to_vec();
    for v in mesh.vertices() {
        let corners = mesh.vertex_corners(v);
        if corners.iter().any(|c| inside[c.face().index()]) {
            corners.iter().for_each(|c| result[c.face().index()] = true);
        }
    }
    result
}

/// Returns the boundary of a region, with the region on its left, as walks along vertices: loops,
/// or from boundary to boundary.
fn walks_around(mesh: &TriangleMesh, inside: &[bool]) -> Vec<Vec<Vertex>> {
    let mut leaving: BTreeMap<Vertex, Vec<Vertex>> = BTreeMap::new();
    let mut entered = BTreeSet::new();
    for side in boundary_of(mesh, |f| inside[f.index()]) {
        let [from, to] = [0, 1].map(|k| side.nodes[k].locate(mesh).unwrap());
        let (eikona::mesh::Located::Vertex(from), eikona::mesh::Located::Vertex(to)) = (from, to) else {
            panic!("sides run from vertex to vertex")
        };
        leaving.entry(from).or_default().push(to);
        entered.insert(to);
    }
    // Start with vertices that nothing leads to.
    let mut starts: Vec<Vertex> = leaving.keys().copied().collect();
    starts.sort_by_key(|v| entered.contains(v));
    let mut walks = Vec::new();
    for start in starts {
        loop {
            let mut walk = vec![start];
            while let Some(to) = leaving.get_mut(walk.last().unwrap()).and_then(Vec::pop) {
                walk.push(to);
            }
            if walk.len() == 1 {
                break;
            }
            walks.push(walk);
        }
    }
    walks
}

/// Deletes half of a walk: leaves pieces of random length, about `mean` edges, between gaps of
/// random length.
fn halved(walk: &[Vertex], mean: f64, random: &mut Random) -> Vec<Vec<Vertex>> {
    let edges = walk.len() - 1;
    let is_closed = walk[0] == walk[edges];
    let turn = if is_closed { random.below(edges) } else { 0 };
    let at = |i: usize| if is_closed { walk[(i + turn) % edges] } else { walk[i] };
    let count = ((edges as f64 / (2.0 * mean)).round() as usize).max(1);
    let mut lengths = || -> Vec<f64> {
        let lengths: Vec<f64> = (0..count).map(|_| random.range(0.25, 1.75)).collect();
        let total: f64 = lengths.iter().sum();
        lengths.iter().map(|l| 0.5 * edges as f64 * l / total).collect()
    };
    let (pieces, gaps) = (lengths(), lengths());
    let mut place: f64 = 0.0;
    let mut kept = Vec::new();
    for (piece, gap) in pieces.into_iter().zip(gaps) {
        let (first, last) = (place.round() as usize, (place + piece).round() as usize);
        if last > first {
            kept.push((first..=last).map(at).collect());
        }
        place += piece + gap;
    }
    kept
}

fn curves(walks: &[Vec<Vertex>]) -> SurfaceCurves {
    let curves = walks.iter().map(|walk| Curve::signed(walk.iter().copied())).collect();
    SurfaceCurves { curves, points: Vec::new() }
}

fn solve(mesh: &TriangleMesh, walks: &[Vec<Vertex>]) -> Winding {
    surface_winding_number(mesh, &curves(walks), &WindingOptions::default()).unwrap()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|x| !x.is_nan()).fold((0.0, 0), |(s, n), x| (s + x, n + 1));
    sum / f64::from(count)
}

/// Other rules for the level, on the values of a solve.
struct Rules {
    /// The mean value of each face.
    faces: Vec<f64>,
    /// Value on the left of the curve, and length, per edge.
    left: Vec<(f64, f64)>,
    /// The mean of the values. In the public program it is zero, since its Laplacian has 1e-8 added
    /// on the diagonal.
    mean: f64,
}

impl Rules {
    fn of(w: &Winding) -> Rules {
        let values = w.values.as_slice();
        let mut left = Vec::new();
        for e in w.mesh.edges().filter(|&e| w.jump[e] != 0) {
            let &[first, second] = w.mesh.edge_halfedges(e) else { panic!("a jump has two sides") };
            let h: Halfedge = if w.jump[e] > 0 { first } else { second };
            let tip = 3 * h.face().index() + (h.index() + 1) % 3;
            let value = mean([values[h.index()], values[tip]].into_iter());
            let [p, q] = w.mesh.edge_vertices(e).map(|v| w.mesh.position(v));
            if !value.is_nan() {
                left.push((value, distance(p, q)));
            }
        }
        let faces = values.chunks_exact(3).map(|c| mean(c.iter().copied())).collect();
        Rules { faces, left, mean: mean(values.iter().copied()) }
    }

    fn rounded(&self, shift: f64) -> Vec<i32> {
        self.faces.iter().map(|x| if x.is_nan() { 0 } else { (x + shift).round() as i32 }).collect()
    }

    /// The shift of the public program if this constant was added to the values before.
    fn public_shift(&self, constant: f64) -> f64 {
        let off = |(a, _): &(f64, f64)| ((a + constant).round() - (a + constant)).abs();
        constant + mean(self.left.iter().map(off))
    }

    fn public(&self) -> Vec<i32> {
        self.rounded(self.public_shift(-self.mean))
    }

    /// SHM section 9.5.3: inside starts at the most frequent rounded value on the left of the
    /// curve.
    fn most_often(&self) -> Vec<i32> {
        let shift = self.public_shift(-self.mean);
        let mut lengths: BTreeMap<i32, f64> = BTreeMap::new();
        for (value, length) in &self.left {
            *lengths.entry((value + shift).round() as i32).or_default() += length;
        }
        let most = lengths.iter().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(&label, _)| label);
        self.public().iter().map(|&label| i32::from(label >= most)).collect()
    }
}

/// A region, for comparison with labels.
struct Truth {
    areas: Vec<f64>,
    label: Vec<i32>,
    /// Faces that count as right whatever the label.
    free: Vec<bool>,
}

impl Truth {
    /// On the mesh of a result, which may be cut, from label and freedom of the input faces.
    fn on(w: &Winding, of_input: impl Fn(usize) -> (i32, bool)) -> Truth {
        let parent = |f: Face| w.provenance.face_parent(f).index();
        let (label, free) = w.mesh.faces().map(|f| of_input(parent(f))).unzip();
        Truth { areas: w.mesh.faces().map(|f| area(&w.mesh, f)).collect(), label, free }
    }

    /// Returns the share of the area where the labels differ.
    fn strictly(&self, label: &[i32]) -> f64 {
        self.share(|f| label[f] != self.label[f])
    }

    /// The same, minimised over a constant added to the labels: the cost of the level alone.
    fn up_to_constant(&self, label: &[i32]) -> f64 {
        let with = |c: i32| self.share(|f| label[f] + c != self.label[f]);
        (-3..=3).map(with).fold(1.0, f64::min)
    }

    /// The same if all labels from one on are inside. Not all of the surface can be inside.
    fn in_or_out(&self, label: &[i32]) -> f64 {
        let from = |c: i32| self.share(|f| (label[f] >= c) != (self.label[f] > 0));
        let lowest = label.iter().min().unwrap();
        let highest = label.iter().max().unwrap();
        (lowest + 1..=*highest).map(from).reduce(f64::min).unwrap_or_else(|| from(1))
    }

    fn share(&self, wrong: impl Fn(usize) -> bool) -> f64 {
        let wrong = (0..self.areas.len()).filter(|&f| wrong(f) && !self.free[f]);
        let wrong = wrong.fold(0.0, |sum, f| sum + self.areas[f]);
        wrong / self.areas.iter().sum::<f64>()
    }

    /// Shifts labels so that the label of the largest area is 0.
    fn zeroed(&self, label: &[i32]) -> Vec<i32> {
        let mut areas: BTreeMap<i32, f64> = BTreeMap::new();
        label.iter().zip(&self.areas).for_each(|(&l, a)| *areas.entry(l).or_default() += a);
        let most = *areas.iter().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
        label.iter().map(|l| l - most).collect()
    }
}

/// A column of a table: shares of the area, in percent.
#[derive(Default)]
struct Column {
    sum: f64,
    count: usize,
    worst: f64,
    above_half: usize,
}

impl Column {
    fn add(&mut self, share: f64) {
        self.sum += 100.0 * share;
        self.count += 1;
        self.worst = self.worst.max(100.0 * share);
        self.above_half += usize::from(share > 0.5);
    }

    fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }
}

const FUNCTIONS: usize = 5;
const DRAWS: u64 = 3;

/// Runs every surface, function and draw; `case` returns the named shares for a region and a seeded
/// generator, and the number of endpoints of the curve.
fn table<const N: usize>(
    names: [&str; N],
    case: impl Fn(&TriangleMesh, Vec<bool>, &mut Random) -> (usize, f64, [f64; N]),
) -> [Column; N] {
    let mut columns: [Column; N] = std::array::from_fn(|_| Column::default());
    println!("surface, function, region %, missing %, endpoints; wrong %: {}", names.join(", "));
    for (name, mesh, functions) in surfaces() {
        for (k, (_, values)) in functions.iter().enumerate() {
            for draw in 0..DRAWS {
                let mut random = Random::from_seed(100 * draw + k as u64);
                let share = random.range(0.15, 0.85);
                let inside = upper_part(mesh, values, share);
                let (endpoints, missing, shares) = case(mesh, inside, &mut random);
                let percent: String = shares.iter().map(|s| format!("{:6.1}", 100.0 * s)).collect();
                println!(
                    "{name:24} {k} {:3.0} {:5.1} {endpoints:3}  {percent}",
                    100.0 * share,
                    100.0 * missing
                );
                columns.iter_mut().zip(shares).for_each(|(column, share)| column.add(share));
            }
        }
    }
    for (name, c) in names.iter().zip(&columns) {
        let mean = c.mean();
        println!(
            "{name:32} mean {mean:5.2}, worst {:5.1}, {} of {} above 50",
            c.worst, c.above_half, c.count
        );
    }
    columns
}

fn missing_of(whole: &[Vec<Vertex>], kept: &[Vec<Vertex>]) -> f64 {
    let edges = |walks: &[Vec<Vertex>]| walks.iter().map(|w| w.len() - 1).sum::<usize>() as f64;
    1.0 - edges(kept) / edges(whole)
}

/// Returns a row for a curve with pieces of about `mean` edges.
fn one_curve(
    mesh: &TriangleMesh,
    inside: Vec<bool>,
    mean: f64,
    random: &mut Random,
) -> (usize, f64, [f64; 7]) {
    let whole = walks_around(mesh, &inside);
    let truths = |w: &Winding| {
        let truth = Truth::on(w, |f| (i32::from(inside[f]), false));
        let label = truth.zeroed(&truth.label);
        let zeroed = Truth { label, areas: truth.areas.clone(), free: truth.free.clone() };
        (truth, zeroed)
    };
    // The whole curve yields the region itself.
    let w = solve(mesh, &whole);
    assert_eq!(truths(&w).1.strictly(w.labels.as_slice()), 0.0);
    let kept: Vec<Vec<Vertex>> = whole.iter().flat_map(|walk| halved(walk, mean, random)).collect();
    let w = solve(mesh, &kept);
    let (truth, zeroed) = truths(&w);
    let (rules, ours) = (Rules::of(&w), w.labels.as_slice());
    let public = rules.public();
    let any = |i: i32| truth.up_to_constant(&rules.rounded(rules.public_shift(f64::from(i) / 16.0)));
    let best = (0..20).map(|i| truth.up_to_constant(&rules.rounded(f64::from(i) / 20.0)));
    let shares = [
        zeroed.strictly(ours),
        truth.up_to_constant(ours),
        zeroed.strictly(&zeroed.zeroed(&public)),
        truth.up_to_constant(&public),
        (0..16).map(any).sum::<f64>() / 16.0,
        truth.up_to_constant(&rules.most_often()),
        best.fold(1.0, f64::min),
    ];
    (w.endpoints.len(), missing_of(&whole, &kept), shares)
}

const NAMES: [&str; 7] = [
    "ours with its zero",
    "ours",
    "public with our zero",
    "public",
    "public, mean over constants of w",
    "most often along the curve",
    "best level",
];

#[test]
fn half_of_a_level_set_labels_almost_all_of_the_surface_correctly() {
    let [ours_with_zero, ours, public_with_zero, public, any_constant, most_often, _] =
        table(NAMES, |mesh, inside, random| one_curve(mesh, inside, 8.0, random));
    assert_eq!(ours_with_zero.above_half, 0);
    assert!(ours_with_zero.mean() < 1.0 && ours_with_zero.worst < 5.0);
    assert!(ours_with_zero.mean() < 0.25 * public_with_zero.mean());
    for other in [public, any_constant, most_often] {
        assert!(ours.mean() < 0.25 * other.mean(), "{} and {}", ours.mean(), other.mean());
    }
}

/// Most loops keep one to three pieces here. Still, no zero lies on the wrong side.
#[test]
fn long_gaps_are_closed_better_than_by_the_public_rule() {
    let [ours_with_zero, ours, public_with_zero, public, any_constant, most_often, _] =
        table(NAMES, |mesh, inside, random| one_curve(mesh, inside, 20.0, random));
    assert_eq!(ours_with_zero.above_half, 0);
    assert!(ours_with_zero.mean() < 2.0 && ours_with_zero.worst < 12.0);
    assert!(ours_with_zero.mean() < 0.5 * public_with_zero.mean());
    for other in [public, any_constant, most_often] {
        assert!(ours.mean() < 0.5 * other.mean(), "{} and {}", ours.mean(), other.mean());
    }
}

/// As in the paper, the curve is joined by its offset, the boundary of the region grown by two
/// strips of triangles, before half of both is deleted. Faces inside one and outside the other may
/// have either label.
#[test]
fn half_of_a_curve_and_of_its_offset_separate_inside_from_outside() {
    let names = ["ours", "public", "most often along the curve"];
    let [ours, public, most_often] = table(names, |mesh, inside, random| {
        let outer = grown(mesh, &grown(mesh, &inside));
        let whole = [walks_around(mesh, &inside), walks_around(mesh, &outer)].concat();
        let kept: Vec<Vec<Vertex>> = whole.iter().flat_map(|walk| halved(walk, 8.0, random)).collect();
        let w = solve(mesh, &kept);
        let truth = Truth::on(&w, |f| (i32::from(inside[f]), inside[f] != outer[f]));
        let rules = Rules::of(&w);
        let shares = [w.labels.as_slice(), &rules.public(), &rules.most_often()].map(|l| truth.in_or_out(l));
        (w.endpoints.len(), missing_of(&whole, &kept), shares)
    });
    assert_eq!(ours.above_half, 0);
    assert!(ours.mean() < 0.2 && ours.worst < 2.0);
    for other in [public, most_often] {
        assert!(ours.mean() < 0.25 * other.mean(), "{} and {}", ours.mean(), other.mean());
    }
}

/// The less is missing of such a loop, the larger its nonbounding jump, which compensates for it in
/// the gaps.
#[test]
fn a_broken_loop_around_a_tube_separates_nothing() {
    let (nu, nv) = (40, 20);
    let torus = shapes::torus(1.0, 0.4, nu, nv).unwrap();
    let torus = damage::jitter(&torus, 0.15, 5).unwrap();
    for (gaps, kept) in [1, 2, 3].into_iter().flat_map(|gaps| [0.9, 0.8, 0.7, 0.6].map(|kept| (gaps, kept))) {
        let vertex = |j: usize| Vertex((7 * nv + j % nv) as u32);
        let is_kept = |j: &usize| ((j * gaps) as f64 / nv as f64).fract() < kept;
        let sides: Vec<Vec<Vertex>> =
            (0..nv).filter(is_kept).map(|j| vec![vertex(j), vertex(j + 1)]).collect();
        for completion in [Completion::Full, Completion::Curve] {
            let options = WindingOptions::default().with_completion(completion);
            let w = surface_winding_number(&torus, &curves(&sides), &options).unwrap();
            let wrong = Truth::on(&w, |_| (0, false)).strictly(w.labels.as_slice());
            println!("{gaps} gaps, {kept} kept, {completion:?}: {:.2} % wrong", 100.0 * wrong);
            assert!(wrong < 0.01, "{gaps} gaps, {kept} kept, {completion:?}: {wrong}");
        }
    }
}
