//! The flow of a surface of the data folder, if it exists.

use eikona::mesh::io;
use eikona::repulsive::{
    EnergyOptions, Flow, FlowOptions, Pairs, Quadrature, Quantity, tangent_point_energy,
};
use eikona::spatial::self_intersections;
use std::path::Path;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/repulsive");

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn linked_handcuffs_come_apart() {
    let path = Path::new(DATA).join("EntangledDoubleTorus/doubletorus10k.obj");
    let mesh = io::read_mesh(&path).unwrap().mesh.triangulate().unwrap().0;
    let mut flow = Flow::new(&mesh, &FlowOptions::default().with_threads(2)).unwrap();
    let all = EnergyOptions::default().with_pairs(Pairs::All).with_threads(2);
    let midpoint = tangent_point_energy(&mesh, &all).unwrap().value;
    assert!((midpoint / 376.2395225971 - 1.0).abs() < 1e-11, "{midpoint}");
    let adaptive = tangent_point_energy(&mesh, &all.with_quadrature(Quadrature::adaptive())).unwrap().value;
    assert!((flow.energy() / adaptive - 1.0).abs() < 1e-3, "{} {adaptive}", flow.energy());
    for _ in 0..10 {
        flow.step().unwrap().unwrap();
        assert!(self_intersections(flow.mesh(), 2).unwrap().is_empty());
    }
    // The published program: 260.
    let ten = flow.energy();
    assert!(ten < 180.0, "{ten}");
    // Linked, the energy stays above 40. Apart, the minimiser of genus 2 has about 7.5.
    let mut steps = 10;
    while flow.energy() > 9.0 && steps < 500 {
        flow.step().unwrap().unwrap();
        steps += 1;
        if steps % 10 == 0 {
            assert!(self_intersections(flow.mesh(), 2).unwrap().is_empty(), "step {steps}");
        }
    }
    let [kept, given] = [flow.mesh(), &mesh].map(|mesh| Quantity::Area.of(mesh));
    println!(
        "1 file: energy {ten} after 10 steps, {} after {steps}, area {:e} off",
        flow.energy(),
        kept / given - 1.0
    );
    assert!(flow.energy() < 9.0, "{}", flow.energy());
    assert!((kept / given - 1.0).abs() < 1e-8);
}
