//! Compares fields with the twin.

use super::dense::rank;
use super::{Form, Twin, Vector, cross, dot, sub};
use crate::polar_field::bevel::wrapped;
use crate::polar_field::homology::Step;
use crate::polar_field::samples::{prescription, surfaces};
use crate::polar_field::{FieldOptions, Place, PolarField, PolarFieldError, Singularity, Solver};
use eikona_mesh::random::Random;
use eikona_mesh::{Face, Halfedge, SurfacePoint, Topology, Vertex, damage, shapes};
use std::f64::consts::TAU;

/// The walks of the solver's generators, as corners.
fn generators(solver: &Solver) -> Vec<Vec<usize>> {
    let corner = |step: &Step| match *step {
        // Where the step ends.
        Step::Jump(h) => h.index(),
        Step::AgainstSplit(h) => h.index(),
    };
    solver.domain.homology.generators.iter().map(|g| g.walk.iter().map(corner).collect()).collect()
}

#[test]
fn cycles_are_the_closed_walks_of_corners() {
    for (name, mesh) in surfaces() {
        let twin = Twin::new(&mesh);
        let solver = Solver::new(&mesh, &Default::default()).unwrap();
        let bevel = &solver.domain.bevel;
        assert_eq!(bevel.cycles().count(), twin.cycles.len(), "{name}");
        let mut form = bevel.zero();
        for (i, &[from, to]) in twin.edges.iter().enumerate() {
            let value = if i < mesh.halfedge_count() {
                &mut form.split.as_mut_slice()[i]
            } else {
                &mut form.jump.as_mut_slice()[to]
            };
            *value = (i as f64).sin();
            if i >= mesh.halfedge_count() {
                assert_eq!(bevel.twin.as_slice()[to].unwrap().next().index(), from, "{name}");
            }
        }
        let sums = bevel.sums(&form);
        for (cycle, walk) in &twin.cycles {
            let sum: f64 = twin.sum(walk).iter().map(|&(e, x)| x * (e as f64).sin()).sum();
            assert!((sums[*cycle] - sum).abs() < 1e-12, "{name} {cycle:?}");
            let curvature = twin.curvature(*cycle, walk);
            assert!((solver.domain.curvature[*cycle] - curvature).abs() < 1e-12, "{name} {cycle:?}");
        }
        for (walk, g) in generators(&solver).iter().zip(&solver.domain.homology.generators) {
            let sum: f64 = twin.sum(walk).iter().map(|&(e, x)| x * (e as f64).sin()).sum();
            assert!((g.sum(&form) - sum).abs() < 1e-12, "{name}");
            assert!((g.curvature - twin.curvature_of_generator(walk)).abs() < 1e-12, "{name}");
        }
    }
}

/// One row of the cycles depends on the others per component, and the generators are independent of
/// them; together they are all that a rotation can be asked for.
#[test]
fn ranks_are_those_of_the_topology() {
    for (name, mesh) in surfaces() {
        let twin = Twin::new(&mesh);
        let solver = Solver::new(&mesh, &Default::default()).unwrap();
        let components = twin.topology.components.len();
        let mut rows: Vec<Form> = twin.cycles.iter().map(|(_, walk)| twin.sum(walk)).collect();
        let cycles = rank(&rows, twin.edges.len());
        assert_eq!(cycles, rows.len() - components, "{name}");
        rows.extend(generators(&solver).iter().map(|walk| twin.sum(walk)));
        let all = rank(&rows, twin.edges.len());
        let handles: u32 = twin.topology.components.iter().map(|c| c.genus.unwrap()).sum();
        assert_eq!(all, cycles + 2 * handles as usize, "{name}");
        // What is left are the differences of functions on corners.
        assert_eq!(twin.edges.len() - all, mesh.halfedge_count() - components, "{name}");
    }
}

/// Fields on all surfaces that are not too large for dense systems, with random prescriptions.
fn fields(
    runs: usize,
    crowded: bool,
    mut check: impl FnMut(&str, &Twin, &Prescription, &PolarField),
) -> usize {
    let mut random = Random::from_seed(if crowded { 23 } else { 17 });
    let mut checked = 0;
    for (name, mesh) in surfaces() {
        let twin = Twin::new(&mesh);
        let solver = Solver::new(&mesh, &Default::default()).unwrap();
        for run in 0..runs {
            let degree = [1, 2, 3, 4, 6][(run + checked) % 5];
            let singularities = prescription(&mesh, degree, crowded, &mut random);
            let walks = generators(&solver);
            let turns: Vec<f64> = walks.iter().map(|_| random.below(3) as f64 - 1.0).collect();
            let along: Vec<f64> = turns.iter().map(|t| t / f64::from(degree)).collect();
            let options = FieldOptions::default().with_degree(degree).with_generators(along.clone());
            let field = match solver.solve(&singularities, &options) {
                Ok(field) => field,
                Err(PolarFieldError::Repeated { .. } | PolarFieldError::Conflict { .. }) => continue,
                Err(fault) => panic!("{name}: {fault}"),
            };
            let generators = walks.into_iter().zip(along).collect();
            check(name, &twin, &Prescription { singularities, degree, generators }, &field);
            checked += 1;
        }
    }
    checked
}

struct Prescription {
    singularities: Vec<Singularity>,
    degree: u32,
    generators: Vec<(Vec<usize>, f64)>,
}

/// Compares a field with the dense rotation, powers and scales.
fn compare(name: &str, twin: &Twin, given: &Prescription, field: &PolarField) {
    let Prescription { singularities, degree, generators } = given;
    let theta = twin.rotation(singularities, *degree, generators);
    let bevel = &field.domain.bevel;
    let mut off = 0.0f64;
    for h in bevel.halfedges() {
        let difference = field.values.turn(h) - theta[h.index()];
        // A face that takes more than its power only has the phases.
        let placed = field.report.unplaced.iter().all(|element| *element != h.face().to_string());
        off = off.max(if placed { difference } else { wrapped(difference) }.abs());
        if let Some(other) = bevel.twin[h] {
            let jump = theta[twin.number[&[other.next().index(), h.index()]]];
            let seen = field.values.jump(h, other, &field.domain.connection, *degree);
            off = off.max(wrapped(seen - jump).abs());
        }
    }
    assert!(off < 1e-9, "{name}: {off:e} {singularities:?} N {degree}");
    let powers = twin.powers(singularities, *degree, &theta);
    assert_eq!(field.values.powers.as_slice(), powers, "{name}");
    let ties = twin.ties(singularities, *degree, &theta, &powers);
    compare_scales(name, twin, &ties, field);
}

/// The energies differ by rounding, which grows with the ratios of tied scales.
fn compare_scales(name: &str, twin: &Twin, ties: &[([usize; 2], f64)], field: &PolarField) {
    let power = |corner: usize| f64::from(field.values.powers.as_slice()[corner / 3]);
    let bases = field.values.base.iter().enumerate();
    let scales: Vec<f64> = bases.map(|(c, base)| base.norm().powf(power(c))).collect();
    assert!(!field.report.scales_gave_up, "{name}");
    assert!(scales.iter().all(|s| *s > 1.0 - 1e-9), "{name}");
    for ([a, b], ratio) in ties {
        assert!((scales[*b] / scales[*a] / ratio - 1.0).abs() < 1e-9, "{name}");
    }
    let matrix = twin.scale_energy();
    let energy = |s: &[f64]| -> f64 {
        matrix.iter().zip(s).map(|(row, x)| x * row.iter().zip(s).map(|(a, y)| a * y).sum::<f64>()).sum()
    };
    let (found, least) = (energy(&scales), energy(&twin.scales(ties)));
    let steepest = ties.iter().map(|(_, ratio)| ratio.max(1.0 / ratio)).fold(1.0, f64::max);
    let tolerance = if steepest < 1e3 { 1e-8 } else { 1e-5 };
    assert!((found - least).abs() <= tolerance * (1e-3 + least), "{name}: {found:e} {least:e} {steepest:e}");
}

#[test]
fn fields_are_those_of_the_dense_twin() {
    let checked = fields(2, false, compare);
    println!("{checked} fields");
    assert!(checked >= 20);
}

/// Several singularities per face, with large powers and jumps.
#[test]
fn crowded_fields_are_those_of_the_dense_twin() {
    let checked = fields(2, true, compare);
    println!("{checked} fields");
    assert!(checked >= 15);
}

/// The field turns relative to the tangent of a curve along each generator, through the middles of
/// the edges that it crosses, as often as prescribed.
#[test]
fn fields_turn_along_generators_as_prescribed() {
    let torus = damage::jitter(&shapes::torus(1.0, 0.4, 24, 12).unwrap(), 0.15, 1).unwrap();
    let double = damage::jitter(&shapes::chain_of_genus(2, 1).unwrap(), 0.1, 2).unwrap();
    let mut random = Random::from_seed(41);
    for mesh in [torus, double] {
        let solver = Solver::new(&mesh, &Default::default()).unwrap();
        let strips: Vec<Vec<Halfedge>> =
            solver.domain.homology.generators.iter().map(|g| entered(&g.walk)).collect();
        let mut near = vec![false; mesh.vertex_count()];
        for h in strips.iter().flatten() {
            mesh.face_vertices(h.face()).iter().for_each(|v| near[v.index()] = true);
        }
        let far: Vec<u32> = mesh.vertices().filter(|v| !near[v.index()]).map(|v| v.0).collect();
        let chi = Topology::of(&mesh).euler_characteristic;
        for degree in [1, 2, 3, 4, 6] {
            let n = f64::from(degree);
            // As many singularities as a turn each needs.
            let places = random.choose((chi * i64::from(degree)).unsigned_abs() as usize, far.len());
            let at = |i: usize| Place::Point(SurfacePoint::Vertex { vertex: far[i] });
            let given: Vec<Singularity> =
                places.into_iter().map(|i| Singularity { place: at(i), index: -1.0 / n }).collect();
            let turns: Vec<f64> = strips.iter().map(|_| random.below(5) as f64 - 2.0).collect();
            let along = turns.iter().map(|t| t / n).collect();
            let options = FieldOptions::default().with_degree(degree).with_generators(along);
            let field = solver.solve(&given, &options).unwrap();
            for (strip, turns) in strips.iter().zip(&turns) {
                let measured = turning(&field, strip);
                assert!((measured - turns).abs() < 1e-9, "N {degree}: {measured} {turns}");
            }
        }
    }
}

/// The halfedges by which a walk enters its faces.
fn entered(walk: &[Step]) -> Vec<Halfedge> {
    walk.iter().filter_map(|step| if let Step::Jump(h) = *step { Some(h) } else { None }).collect()
}

/// How often the N-th power turns along the closed curve through the middles of these sides,
/// relative to N times its tangent.
fn turning(field: &PolarField, strip: &[Halfedge]) -> f64 {
    let mesh = field.mesh();
    let n = f64::from(field.degree());
    // The angle of a vector in the frame of a face, whose first axis is its first side.
    let angle = |f: Face, v: Vector| {
        let [a, b, c] = mesh.face_positions(f);
        let (along, normal) = (sub(b, a), cross(sub(b, a), sub(c, a)));
        let across = cross(normal, along).map(|x| x / dot(normal, normal).sqrt());
        dot(v, across).atan2(dot(v, along))
    };
    let ends = |h: Halfedge| [mesh.position(mesh.origin(h)), mesh.position(mesh.tip(h))];
    let middle = |h: Halfedge| [0, 1, 2].map(|k| 0.5 * (ends(h)[0][k] + ends(h)[1][k]));
    // Weights of the middle of a side of this face.
    let weights = |f: Face, h: Halfedge| {
        let at = |v: Vertex| if v == mesh.origin(h) || v == mesh.tip(h) { 0.5 } else { 0.0 };
        mesh.face_vertices(f).map(at)
    };
    let mut turned = 0.0;
    for (i, &enter) in strip.iter().enumerate() {
        let leave = strip[(i + 1) % strip.len()];
        let (f, g) = (enter.face(), leave.face());
        let [from, to] = [weights(f, enter), weights(f, leave)];
        let steps = 64;
        let value = |s: i32| {
            let t = f64::from(s) / f64::from(steps);
            field.power_at(f, [0, 1, 2].map(|k| (1.0 - t) * from[k] + t * to[k])).arg()
        };
        turned += (0..steps).map(|s| wrapped(value(s + 1) - value(s))).sum::<f64>();
        let side = sub(ends(leave)[1], ends(leave)[0]);
        let transport = angle(g, side) - angle(f, side);
        let inside = field.power_at(g, weights(g, leave)).arg();
        turned += wrapped(inside - value(steps) - n * transport);
        let after = strip[(i + 2) % strip.len()];
        let tangent =
            angle(g, sub(middle(after), middle(leave))) - angle(f, sub(middle(leave), middle(enter)));
        turned -= n * wrapped(tangent - transport);
    }
    turned / TAU
}
