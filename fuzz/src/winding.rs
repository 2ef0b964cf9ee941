//! Surface winding numbers on small meshes of any shape, with any curves and options.

use crate::choices::Choices;
use crate::solve;
use eikona::Warning;
use eikona::curves::shortest_vertex_path;
use eikona::winding::{
    Completion, CompletionShape, Diagnosis, Part, Reference, Solver, Winding, WindingError, WindingOptions,
};
use eikona_mesh::{
    Curve, CurveKind, Edge, Face, Halfedge, MeshError, Neighbour, SurfaceCurves, SurfacePoint, TriangleMesh,
    Vertex, damage, shapes, weld,
};
use std::hint::black_box;

/// Largest accepted error of a solve, relative to the largest jump (jumps are integers).
const TOLERANCE: f64 = 1e-6;

/// Solves, and checks properties of every result.
///
/// # Panics
/// If a property is violated.
pub fn check(bytes: &[u8]) {
    let mut choices = Choices::new(bytes);
    let mut options = options(&mut choices);
    let Ok(mesh) = mesh(&mut choices) else { return };
    if choices.below(4) == 3 {
        options.reference = Reference::Face(Face(choices.below(mesh.face_count() + 1) as u32));
    }
    let curves = curves(&mut choices, &mesh);
    let solver = match Solver::new(&mesh, &Default::default()) {
        Ok(solver) => solver,
        Err(fault) => return assert!(!fault.to_string().is_empty()),
    };
    let winding = match solver.solve(&curves, &options) {
        Ok(winding) => winding,
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            let numbers = matches!(fault, WindingError::Numeric(_) | WindingError::Program(_));
            assert!(!numbers || !is_ordinary(&mesh), "an ordinary mesh is not solved: {fault}");
            return;
        }
    };
    check_fields(&winding);
    check_jumps(&winding, &options);
    check_parts(&winding, &curves);
    check_answers(&mesh, &winding, &mut choices);
    check_reversal(&solver, &curves, &options, &winding);
}

fn check_fields(w: &Winding) {
    let (mesh, scale) = (&w.mesh, scale(w));
    let (corners, faces, edges) = (mesh.halfedge_count(), mesh.face_count(), mesh.edge_count());
    assert_eq!((w.values.as_slice().len(), w.residual_function.as_slice().len()), (corners, corners));
    assert_eq!((w.labels.as_slice().len(), w.margin.as_slice().len()), (faces, faces));
    assert_eq!((w.jump.as_slice().len(), w.nonbounding.as_slice().len()), (edges, edges));
    assert_eq!(w.island.as_slice().len(), faces);
    let fans: Vec<Option<bool>> = mesh.vertices().map(|v| fan(mesh, v).map(|f| f.1)).collect();
    for v in &w.endpoints {
        assert_eq!(fans[v.index()], Some(true), "{v} is an endpoint but not an inner vertex");
    }
    let is_undefined = |v: Vertex| w.endpoints.contains(&v) || fans[v.index()].is_none();
    let may_be_nan = |v: Vertex| is_undefined(v) || corners_around(w, v).into_iter().all(is_undefined);
    for f in mesh.faces() {
        let corners = 3 * f.index()..3 * f.index() + 3;
        let values: Vec<f64> =
            w.values.as_slice()[corners.clone()].iter().copied().filter(|x| !x.is_nan()).collect();
        for (v, value) in mesh.face_vertices(f).iter().zip(&w.values.as_slice()[corners]) {
            assert!(!value.is_infinite(), "{f}: {value}");
            assert!(!value.is_nan() || may_be_nan(*v), "{v} has no value in {f}: {:?}", w.report);
        }
        assert!((0.0..=0.5).contains(&w.margin[f]), "{f}: {}", w.margin[f]);
        let shift = w.shift[w.island[f] as usize];
        assert!(shift.is_finite());
        // Between a completion on edges and the straight one, labels change but values do not.
        if !values.is_empty() && straightened(w) == 0 {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let off = (mean + shift - f64::from(w.labels[f])).abs();
            assert!(off <= 0.5 + 1e-9 * scale, "{f}: label {}, value {}", w.labels[f], mean + shift);
        }
    }
    assert!(w.residual_function.iter().all(|(_, v)| v.is_finite()));
    let most = if is_ordinary(&w.mesh) { 1e-6 } else { 1e-3 };
    assert!(w.report.residual < most, "{:?}", w.report);
    if let Some(program) = &w.report.program {
        let c = &program.certificate;
        // A sum of lengths may exceed the largest double.
        assert!(program.objective.is_finite() || (program.objective > 0.0 && !is_ordinary(&w.mesh)));
        assert!(c.gap < 1e-6 && c.overflow < 1e-6 && c.violation < 1e-6, "{:?}", w.report);
        assert!(program.lower_bound <= program.objective, "{:?}", w.report);
    }
}

/// Returns the number of straightened pieces of the completion.
fn straightened(w: &Winding) -> usize {
    w.report.completion.as_ref().map_or(0, |c| c.straightened)
}

/// Returns the largest multiplicity, at least 1.
fn scale(w: &Winding) -> f64 {
    w.jump.iter().fold(1.0, |m, (_, c)| f64::from(c.abs()).max(m))
}

fn check_jumps(w: &Winding, options: &WindingOptions) {
    // The edges around a vertex add up the residual of the solves.
    let (mesh, tolerance) = (&w.mesh, (TOLERANCE + 10.0 * w.report.residual) * scale(w));
    // Straightened loops may run along the curve, and add to its own jump there.
    let limits_kept = is_ordinary(mesh)
        && straightened(w) == 0
        && w.report.program.as_ref().is_none_or(|program| program.relaxed == 0);
    for e in mesh.edges() {
        let (c, t) = (f64::from(w.jump[e]), w.nonbounding[e]);
        assert!(t.is_finite(), "{e}: {t}");
        let &[a, b] = mesh.edge_halfedges(e) else {
            assert_eq!((c, t), (0.0, 0.0), "{e} does not have two faces");
            continue;
        };
        if c != 0.0 && limits_kept {
            let along = t * c.signum();
            assert!(
                (-tolerance..=c.abs() + tolerance).contains(&along),
                "{e}: {t} of {c}: {:?}",
                w.report.warnings
            );
        }
        for v in mesh.edge_vertices(e) {
            let at = |h: Halfedge| corner_at(mesh, h, v);
            let t_there = w.residual_function.as_slice()[at(a)] - w.residual_function.as_slice()[at(b)];
            assert!((t_there - t).abs() <= tolerance, "{e}: residual function jumps by {t_there}, not {t}");
            let jump = w.values.as_slice()[at(a)] - w.values.as_slice()[at(b)];
            // Small jumps fade out towards vertices with several fans.
            let has_fans = || corners_around(w, v).into_iter().chain([v]).all(|v| fan(mesh, v).is_some());
            if options.completion == Completion::Full && !jump.is_nan() && has_fans() {
                let wanted = w.bounding_jump(e);
                assert!((jump - wanted).abs() <= tolerance, "{e} at {v}: jumps by {jump}, not {wanted}");
            }
        }
    }
    for v in mesh.vertices() {
        if let Some((crossings, true)) = fan(mesh, v) {
            let around: f64 = crossings
                .iter()
                .map(|&(e, forward)| w.nonbounding[e] * if forward { -1.0 } else { 1.0 })
                .sum();
            assert!(around.abs() <= tolerance, "the nonbounding part ends at {v}: {around}");
        }
    }
}

/// Returns the vertices whose values a vertex of a cut interpolates; the vertex itself for others.
fn corners_around(w: &Winding, v: Vertex) -> Vec<Vertex> {
    w.provenance.vertex_weights(v).map(|(corner, _)| corner).collect()
}

/// Returns the corner at `v` in the face of a halfedge that starts or ends there.
fn corner_at(mesh: &TriangleMesh, h: Halfedge, v: Vertex) -> usize {
    let f = h.face();
    3 * f.index() + (0..3).find(|&k| mesh.face_vertices(f)[k] == v).expect("the halfedge touches the vertex")
}

/// Returns the edges crossed on a walk around a vertex whose faces are one fan, each with whether
/// it is crossed from its first face to its second; and whether the walk closes.
fn fan(mesh: &TriangleMesh, v: Vertex) -> Option<(Vec<(Edge, bool)>, bool)> {
    let corners = mesh.vertex_corners(v);
    let sides = |f: Face| -> Vec<Halfedge> {
        (0..3).map(|k| f.halfedge(k)).filter(|&h| mesh.origin(h) == v || mesh.tip(h) == v).collect()
    };
    let edges: Vec<Halfedge> = corners.iter().flat_map(|c| sides(c.face())).collect();
    if edges.iter().any(|&h| mesh.edge_halfedges(mesh.edge(h)).len() > 2) {
        return None;
    }
    let rim = edges.iter().copied().find(|&h| matches!(mesh.neighbour(h), Neighbour::Boundary));
    let mut entry = rim.or(edges.first().copied())?;
    let start = entry.face();
    let (mut crossings, mut seen) = (Vec::new(), 1);
    loop {
        let exit = sides(entry.face()).into_iter().find(|&h| h != entry)?;
        let Neighbour::Twin(other) = mesh.neighbour(exit) else {
            return (seen == corners.len()).then_some((crossings, false));
        };
        let edge = mesh.edge(exit);
        crossings.push((edge, mesh.edge_halfedges(edge)[0] == exit));
        if other.face() == start {
            return (seen == corners.len()).then_some((crossings, true));
        }
        seen += 1;
        entry = other;
    }
}

fn check_parts(w: &Winding, curves: &SurfaceCurves) {
    assert_eq!((w.parts.len(), w.curves.len()), (curves.curves.len(), curves.curves.len()));
    let mut steps = 0;
    for (walk, parts) in w.curves.iter().zip(&w.parts) {
        assert_eq!(parts.len(), walk.vertices.len().saturating_sub(1));
        assert_eq!(parts.len(), walk.segments.len());
        steps += parts.len();
    }
    let parts = [w.bounding_part(), w.nonbounding_part()];
    let left_out = w.parts.iter().flatten().filter(|part| **part == Part::LeftOut).count();
    assert_eq!(parts.iter().map(|p| p.segment_count()).sum::<usize>(), steps - left_out);
    for part in parts {
        if let Err(fault) = part.segments(&w.mesh) {
            panic!("a part is invalid: {fault}");
        }
    }
    for polyline in w.bounding_loops.iter().chain(&w.nonbounding_loops) {
        assert!(polyline.vertices.len() > 1 && polyline.jump > 0.0);
        assert!(polyline.vertices.windows(2).all(|p| w.mesh.find_edge(p[0], p[1]).is_some()));
    }
}

fn check_answers(input: &TriangleMesh, w: &Winding, choices: &mut Choices) {
    let split = w.split().expect("a small mesh can be split");
    assert_eq!(split.mesh.face_count(), w.mesh.face_count());
    assert!(split.provenance.keeps_faces() && split.provenance.dropped_vertices().is_empty());
    for v in split.mesh.vertices() {
        let corners = split.mesh.vertex_corners(v);
        assert!(corners.iter().all(|c| w.labels[c.face()] == w.labels[corners[0].face()]));
    }
    assert_eq!(w.input_labels().as_slice().len(), input.face_count());
    let wild = [choices.wild_float(), choices.wild_float(), choices.wild_float()];
    for f in input.faces() {
        for weights in [[1.0 / 3.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.5], wild] {
            black_box(w.label_at(f, weights));
        }
    }
    black_box(w.label_at(Face(choices.below(300) as u32), wild));
}

/// Reversing the curves reverses the nonbounding part at equal cost. Only the cost is compared: of
/// loops with equal cost either may be found.
fn check_reversal(solver: &Solver, curves: &SurfaceCurves, options: &WindingOptions, w: &Winding) {
    let Some(program) = &w.report.program else { return };
    // Cuts may differ, and the side of a curve is taken from its first face and transported across
    // edges and seams of sheets.
    let is_carried = |warning: &Warning| {
        matches!(warning, Warning::NotOrientable | Warning::StepsOnNonmanifoldEdges { .. })
    };
    if w.is_cut()
        || w.report.warnings.iter().any(is_carried)
        || program.relaxed > 0
        || curves.curves.iter().any(|c| c.up.is_some())
    {
        return;
    }
    let reversed = SurfaceCurves {
        curves: curves.curves.iter().cloned().map(Curve::reversed).collect(),
        points: curves.points.clone(),
    };
    let back = match solver.solve(&reversed, options) {
        Ok(back) => back,
        Err(fault) => {
            return assert!(!is_ordinary(&w.mesh), "not solved the other way: {fault}");
        }
    };
    if back.is_cut() {
        return;
    }
    assert!(w.jump.iter().zip(back.jump.iter()).all(|(a, b)| *a.1 == -*b.1));
    let there = program.objective;
    let back = back.report.program.as_ref().map_or(0.0, |p| p.objective);
    if there.is_infinite() {
        return;
    }
    let longest = w.mesh.edges().map(|e| length(&w.mesh, e)).fold(0.0, f64::max);
    // Ties are broken by changes of up to 1e-4.
    let most = 1e-3 * there.max(back) + TOLERANCE * scale(w) * longest;
    assert!((there - back).abs() <= most, "costs {there}, reversed {back}");
}

fn length(mesh: &TriangleMesh, e: Edge) -> f64 {
    let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Whether all edges are of comparable length, so that every solve must succeed.
fn is_ordinary(mesh: &TriangleMesh) -> bool {
    let lengths = mesh.edges().map(|e| length(mesh, e)).filter(|l| *l > 0.0);
    let (short, long) = lengths.fold((f64::INFINITY, 0.0f64), |(s, l), x| (s.min(x), l.max(x)));
    short > 1e-50 && long < 1e50 && long <= 1e4 * short
}

fn options(choices: &mut Choices) -> WindingOptions {
    WindingOptions::default()
        .with_completion(choices.of([Completion::Full, Completion::Curve]))
        .with_epsilon(match choices.below(4) {
            0 | 1 => 1e-2,
            2 => choices.of([1.0, 0.5, 1e-3, 1e-6, 1e-12]),
            _ => choices.wild_float(),
        })
        .with_reference(Reference::LargestArea)
        .with_split_short(choices.of([true, false]))
        .with_intrinsic_delaunay(choices.of([false, true]))
        .with_diagnosis(choices.of([Diagnosis::Automatic, Diagnosis::Never, Diagnosis::Always]))
        .with_completion_shape(choices.of([CompletionShape::Straight, CompletionShape::Edges]))
}

/// Returns a shape, or two side by side; intact or damaged.
fn mesh(choices: &mut Choices) -> Result<TriangleMesh, MeshError> {
    let mut mesh = shape(choices)?;
    if choices.below(6) == 5 {
        mesh = beside(&mesh, &shape(choices)?)?;
    }
    for _ in 0..choices.of([0, 0, 1, 2]) {
        let (seed, share) = (choices.below(256) as u64, choices.share());
        mesh = match choices.below(9) {
            0 => damage::jitter(&mesh, 0.5 * share, seed)?,
            1 => damage::remove_faces(&mesh, 0.5 * share, seed)?.mesh,
            2 => damage::holes(&mesh, 1 + choices.below(3), 1, seed)?.mesh,
            3 => damage::flip_faces(&mesh, share, seed)?.mesh,
            4 => damage::duplicate_faces(&mesh, share, seed)?.mesh,
            5 => damage::shuffle(&mesh, seed)?.mesh,
            6 => damage::unweld(&mesh)?.mesh,
            7 => damage::sliver_faces(&mesh, share, 1e-9, seed)?.mesh,
            _ => match weld(&mesh, share) {
                Ok(welded) => welded.mesh,
                Err(_) => mesh,
            },
        };
    }
    let spoils = choices.of([0, 0, 0, 1, 2, 4]);
    if spoils == 0 || mesh.vertex_count() == 0 {
        return Ok(mesh);
    }
    let (mut positions, mut faces) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
    for _ in 0..spoils {
        solve::spoil(choices, &mut positions, &mut faces);
    }
    TriangleMesh::new(positions, faces)
}

fn shape(choices: &mut Choices) -> Result<TriangleMesh, MeshError> {
    let (n, m) = (3 + choices.below(12), 3 + choices.below(6));
    match choices.below(15) {
        0 => shapes::torus(1.0, 0.4, n, m),
        1 => shapes::geodesic_sphere(1 + n % 4),
        2 => shapes::moebius_band(1.0, 0.6, n, m - 2),
        3 => shapes::klein_bottle(2.0, n, m),
        4 => shapes::projective_plane(m - 2),
        5 => shapes::annulus(0.5, 1.0, m - 2, n),
        6 => shapes::disk(m - 2, n, 1.0),
        7 => shapes::grid(
            n / 2,
            m / 2,
            1.0,
            1.0,
            choices.of([shapes::Diagonal::Alternating, shapes::Diagonal::Uniform]),
        ),
        8 => shapes::octahedron(),
        9 => shapes::chain_of_genus(2, 0),
        10 => shapes::linked_rings(2, 0.2, n, m),
        11 => Ok(strip_torus(n as u32)),
        _ => solve::mesh(choices),
    }
}

/// A torus one quad wide: both sides of each quad along the strip are the same edge, up to a
/// rotation.
fn strip_torus(n: u32) -> TriangleMesh {
    // A triangle of vertices per step makes a tube; every step is glued to the next.
    let at = |i: u32, j: u32| 3 * (i % n) + j % 3;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..3 {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let angle = |k: u32, of: u32| f64::from(k) / f64::from(of) * std::f64::consts::TAU;
    let position = |v: u32| {
        let (a, b) = (angle(v / 3, n), angle(v % 3, 3));
        let r = 1.0 + 0.3 * b.cos();
        [r * a.cos(), r * a.sin(), 0.3 * b.sin()]
    };
    TriangleMesh::new((0..3 * n).map(position).collect(), faces)
        .expect("at least three vertices in both directions")
}

fn beside(a: &TriangleMesh, b: &TriangleMesh) -> Result<TriangleMesh, MeshError> {
    let first = a.vertex_count() as u32;
    let mut positions = a.positions().to_vec();
    positions.extend(b.positions().iter().map(|p| [p[0] + 4.0, p[1], p[2]]));
    let mut faces = a.triangles().to_vec();
    faces.extend(b.triangles().iter().map(|f| f.map(|v| v + first)));
    TriangleMesh::new(positions, faces)
}

fn curves(choices: &mut Choices, mesh: &TriangleMesh) -> SurfaceCurves {
    if choices.below(6) == 5 {
        return solve::source(choices, mesh);
    }
    let mut curves: Vec<Curve> = Vec::new();
    for _ in 0..choices.of([1, 2, 1, 3, 2, 4, 6, 0]) {
        let mut made = curve(choices, mesh);
        if choices.below(8) == 7 {
            let up = [choices.share() - 0.5, choices.share() - 0.5, choices.wild_float()];
            made.iter_mut().for_each(|c| c.up = Some(up));
        }
        if choices.below(64) == 63 {
            made.iter_mut().for_each(|c| c.kind = CurveKind::Unsigned);
        }
        if choices.below(3) == 2 {
            made = made.into_iter().map(Curve::reversed).collect();
        }
        for _ in 0..choices.of([1, 1, 1, 2, 3, 1, 1, 20]) {
            curves.extend(made.iter().cloned());
        }
        if choices.below(8) == 7 {
            curves.extend(made.into_iter().map(Curve::reversed));
        }
    }
    SurfaceCurves { curves, points: Vec::new() }
}

/// Returns one curve, or the pieces of one.
fn curve(choices: &mut Choices, mesh: &TriangleMesh) -> Vec<Curve> {
    let vertex = |choices: &mut Choices| Vertex(choices.below(mesh.vertex_count()) as u32);
    let some_edge = |choices: &mut Choices, wanted: &dyn Fn(usize) -> bool| {
        let edges: Vec<Edge> = mesh.edges().filter(|&e| wanted(mesh.edge_halfedges(e).len())).collect();
        edges.get(choices.below(edges.len())).map(|&e| Curve::signed(mesh.edge_vertices(e)))
    };
    match choices.below(10) {
        0 | 1 => {
            // Along the boundary of a patch of faces, with some steps missing.
            let centre = vertex(choices);
            let reach = 1 + choices.below(4);
            let missing = choices.of([0, 0, 4, 3, 7]);
            rim(mesh, centre, reach)
                .into_iter()
                .enumerate()
                .filter(|(i, _)| missing == 0 || i % missing != 1)
                .map(|(_, c)| c)
                .collect()
        }
        2 | 3 => {
            let mut through = vec![vertex(choices), vertex(choices)];
            if choices.of([false, true]) {
                through.extend([vertex(choices), through[0]]);
            }
            let path = shortest_vertex_path(mesh, &through).unwrap_or_default();
            vec![Curve::signed(path)]
        }
        4 | 5 => {
            let mut at = vertex(choices);
            let mut nodes = vec![at];
            for _ in 0..choices.of([3, 5, 8, 12, 20, 40, 1]) {
                let around: Vec<Vertex> = neighbours(mesh, at);
                let Some(&next) = around.get(choices.below(around.len())) else { break };
                at = next;
                nodes.push(at);
            }
            vec![Curve::signed(nodes)]
        }
        6 => some_edge(choices, &|faces| faces == 1).into_iter().collect(),
        7 => some_edge(choices, &|faces| faces > 2).into_iter().collect(),
        8 => some_edge(choices, &|_| true).into_iter().collect(),
        _ => {
            let v = vertex(choices);
            vec![Curve::signed([v, v])]
        }
    }
}

fn neighbours(mesh: &TriangleMesh, v: Vertex) -> Vec<Vertex> {
    if v.index() >= mesh.vertex_count() {
        return Vec::new();
    }
    let mut around: Vec<Vertex> = mesh
        .vertex_corners(v)
        .iter()
        .flat_map(|c| mesh.face_vertices(c.face()))
        .filter(|&w| w != v)
        .collect();
    around.sort_unstable();
    around.dedup();
    around
}

/// Returns the sides between the faces within some steps of a vertex and the rest, one curve per
/// side.
fn rim(mesh: &TriangleMesh, centre: Vertex, reach: usize) -> Vec<Curve> {
    let mut near = vec![false; mesh.vertex_count()];
    let mut inside = vec![false; mesh.face_count()];
    let mut last = vec![centre];
    for _ in 0..reach {
        let mut found = Vec::new();
        for v in last {
            if v.index() >= mesh.vertex_count() || std::mem::replace(&mut near[v.index()], true) {
                continue;
            }
            mesh.vertex_corners(v).iter().for_each(|c| inside[c.face().index()] = true);
            found.extend(neighbours(mesh, v));
        }
        last = found;
    }
    let sides = mesh.faces().filter(|f| inside[f.index()]).flat_map(|f| (0..3).map(move |k| f.halfedge(k)));
    sides
        .filter(|&h| matches!(mesh.neighbour(h), Neighbour::Twin(other) if !inside[other.face().index()]))
        .map(|h| Curve::signed([mesh.origin(h), mesh.tip(h)].map(|v| SurfacePoint::Vertex { vertex: v.0 })))
        .collect()
}
