//! Steps of the flow of a mesh: energies, lengths, iterations and seconds.
//!
//! ```sh
//! cargo run --release -p eikona --example flow -- mesh.obj 10 2    # steps, threads
//! ```

use eikona::repulsive::{Flow, FlowOptions, Quantity};
use std::time::Instant;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().expect("a mesh is expected");
    let steps: usize = arguments.next().map_or(10, |word| word.parse().expect("a number is expected"));
    let threads: usize = arguments.next().map_or(1, |word| word.parse().expect("a number is expected"));
    let mesh = eikona::mesh::io::read_mesh(std::path::Path::new(&path)).expect("the file is valid").mesh;
    let (mesh, _) = mesh.triangulate().expect("its polygons are valid");
    let options = FlowOptions::default().with_threads(threads).with_keep(vec![Quantity::Area]);
    let mut flow = Flow::new(&mesh, &options).expect("the energy is finite");
    println!("{} faces, energy {}", mesh.face_count(), flow.energy());
    for k in 1..=steps {
        let start = Instant::now();
        let Some(step) = flow.step().expect("nothing stops it") else {
            println!("no step lowers the energy");
            break;
        };
        println!("{k}: {:.3} s {step:?}", start.elapsed().as_secs_f64());
    }
}
