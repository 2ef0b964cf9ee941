//! Continuous collision detection against the IPC Toolkit: the test runs where `EIKONA_PYTHON`
//! names a Python with ipctk and numpy from PyPI.

mod run;

use eikona::spatial::{safe_motion, self_intersections};
use eikona_mesh::random::Random;
use eikona_mesh::{TriangleMesh, shapes};
use run::Folder;
use serde_json::{Value, json};

/// Counts the steps that collide according to the toolkit, and the meshes that intersect.
const CHECKER: &str = r#"
import json, sys
import ipctk
import numpy as np
cases = json.load(open(sys.argv[1]))
faces = np.asarray(cases["faces"], dtype=np.int32)
let_through, limited, needless, disagree = [], 0, 0, []
mesh = None
for i, case in enumerate(cases["cases"]):
    start = np.asfortranarray(np.array(case["start"]))
    motion = np.array(case["motion"])
    if mesh is None:
        mesh = ipctk.CollisionMesh(start, ipctk.edges(faces), faces)
    end = np.asfortranarray(start + case["share"] * motion)
    if not ipctk.is_step_collision_free(mesh, start, end):
        let_through.append(i)
    if case["share"] < 1:
        limited += 1
        whole = np.asfortranarray(start + motion)
        needless += int(ipctk.is_step_collision_free(mesh, start, whole))
    end = np.asfortranarray(start + motion)
    if ipctk.has_intersections(mesh, end) != case["intersects"]:
        disagree.append(i)
print(json.dumps({"let_through": let_through, "limited": limited, "needless": needless, "disagree": disagree}))
"#;

/// Two icosahedra and a square that they lie close to.
fn cluster(random: &mut Random) -> TriangleMesh {
    let one = shapes::icosphere(0).unwrap();
    let mut positions: Vec<[f64; 3]> = one.positions().to_vec();
    let shift = [2.2 + 0.3 * random.uniform(), 0.2 * random.uniform(), 0.2 * random.uniform()];
    positions.extend(one.positions().iter().map(|p| [0, 1, 2].map(|k| p[k] + shift[k])));
    let below = -1.05 - 0.2 * random.uniform();
    positions.extend([[-2., -2., below], [5., -2., below], [5., 2., below], [-2., 2., below]]);
    let count = one.vertex_count() as u32;
    let mut faces = one.triangles().to_vec();
    faces.extend(one.triangles().iter().map(|t| t.map(|v| v + count)));
    faces.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| v + 2 * count)));
    TriangleMesh::new(positions, faces).unwrap()
}

#[test]
#[cfg_attr(not(python_ipctk), ignore = "needs ipctk: set EIKONA_PYTHON to a Python that has it")]
fn no_step_is_let_through_that_the_ipc_toolkit_calls_a_collision() {
    let mut random = Random::from_seed(21);
    let mut cases = Vec::new();
    let mut faces = Vec::new();
    for i in 0..10_000 {
        let mesh = cluster(&mut random);
        faces = mesh.triangles().to_vec();
        let size = [0.05, 0.3, 2.0][i % 3];
        // Rigid for each part, or each vertex for itself.
        let parts = [(); 3].map(|()| random.in_unit_ball());
        let motion: Vec<[f64; 3]> = (0..mesh.vertex_count())
            .map(|v| {
                let own = random.in_unit_ball();
                let direction = if i % 2 == 0 { own } else { parts[v / 12] };
                direction.map(|x| size * x)
            })
            .collect();
        let safe = safe_motion(&mesh, &motion, 1).unwrap();
        let end = mesh.positions().iter().zip(&motion).map(|(p, m)| [0, 1, 2].map(|k| p[k] + m[k]));
        let end = mesh.with_positions(end.collect()).unwrap();
        let intersects = !self_intersections(&end, 1).unwrap().is_empty();
        cases.push(json!({
            "start": mesh.positions(), "motion": motion, "share": safe.share, "intersects": intersects,
        }));
    }
    let folder = Folder::new();
    folder.write("checker.py", CHECKER);
    folder.write("cases.json", &json!({"faces": faces, "cases": cases}).to_string());
    let python = std::env::var_os("EIKONA_PYTHON").expect("set when the test is not ignored");
    let files = ["checker.py", "cases.json"];
    let out = std::process::Command::new(python).args(files).current_dir(&folder.0).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    let seen: Value = serde_json::from_str(&text)
        .unwrap_or_else(|_| panic!("{text}{}", String::from_utf8_lossy(&out.stderr)));
    println!("{seen}");
    assert_eq!(seen["let_through"], json!([]), "{seen}");
    assert_eq!(seen["disagree"], json!([]), "{seen}");
    // Steps are limited because something is in the way.
    let [limited, needless] = ["limited", "needless"].map(|key| seen[key].as_u64().unwrap());
    assert!(limited > 2000 && 20 * needless < limited, "{seen}");
}
