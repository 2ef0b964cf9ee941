//! Files of `eikona field`, read by libigl: the test runs where `EIKONA_PYTHON` names a Python with
//! libigl and numpy from PyPI.

mod run;

use run::Folder;
use serde_json::Value;

/// Reads a mesh and a field, and prints the singular vertices that libigl finds.
const READER: &str = r#"
import json, sys
import igl
import numpy as np
V, F = igl.read_triangle_mesh(sys.argv[1])
F = F.astype(np.int64)
D = np.loadtxt(sys.argv[2], skiprows=1)
normal = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
normal /= np.linalg.norm(normal, axis=1)[:, None]
first, second = D[:, :3].copy(), D[:, 3:6].copy()
counter_clockwise = float(np.abs(np.cross(normal, first) - second).max())
singular, index = igl.find_cross_field_singularities(V, F, igl.cross_field_mismatch(V, F, first, second, False))
print(json.dumps({"turned": counter_clockwise, "singular": np.flatnonzero(singular).tolist(), "index": index[np.flatnonzero(singular)].tolist()}))
"#;

#[test]
#[cfg_attr(not(python_libigl), ignore = "needs libigl: set EIKONA_PYTHON to a Python that has it")]
fn libigl_finds_every_singularity_of_split_fields() {
    let folder = Folder::new();
    folder.write("reader.py", READER);
    folder.write(
        "torus.json",
        r#"[{"face": [50, 82, 83], "bary": [0.7, 0.2, 0.1], "index": 0.25},
            {"face": [750, 782, 783], "bary": [0.3, 0.3, 0.4], "index": -0.25},
            {"edge": [350, 382], "t": 0.3, "index": 0.25},
            {"vertex": 1200, "index": -0.25}]"#,
    );
    folder.done("make torus -o torus.ply");
    folder.done("make icosphere levels=4 -o sphere.ply");
    for (mesh, given) in [("torus", "--singularities torus.json"), ("sphere", "--auto")] {
        folder.done(&format!(
            "field {mesh}.ply {given} --split {mesh}.obj -o {mesh}.rawfield --save-singularities {mesh}.sings"
        ));
        let python = std::env::var_os("EIKONA_PYTHON").expect("set when the test is not ignored");
        let files = ["reader.py".to_string(), format!("{mesh}.obj"), format!("{mesh}.rawfield")];
        let out = std::process::Command::new(python).args(files).current_dir(&folder.0).output().unwrap();
        let text = String::from_utf8_lossy(&out.stdout);
        let seen: Value = serde_json::from_str(&text).unwrap_or_else(|_| {
            panic!("{text}{}", String::from_utf8_lossy(&out.stderr));
        });
        assert!(seen["turned"].as_f64().unwrap() < 1e-12, "{seen}");
        // Rows of a vertex and its index times 4; libigl counts quarter turns modulo 4.
        let sings = folder.read(&format!("{mesh}.sings"));
        let mut expected: Vec<(i64, i64)> = Vec::new();
        for row in sings.lines().skip(1) {
            let numbers: Vec<i64> = row.split(' ').map(|word| word.parse().unwrap()).collect();
            expected.push((numbers[0], numbers[1]));
        }
        expected.sort();
        let numbers = |key: &str| -> Vec<i64> {
            seen[key].as_array().unwrap().iter().map(|x| x.as_i64().unwrap()).collect()
        };
        let vertices: Vec<i64> = expected.iter().map(|(v, _)| *v).collect();
        assert_eq!(numbers("singular"), vertices, "{mesh}");
        let quarters: Vec<i64> = expected.iter().map(|(_, turns)| turns.rem_euclid(4)).collect();
        assert_eq!(numbers("index"), quarters, "{mesh}");
    }
}
