//! `eikona energy`.

mod run;

use run::Folder;

#[test]
fn energy_is_reported_with_its_gradient_and_density() {
    let folder = Folder::new();
    folder.done("make icosphere levels=3 -o s.ply");
    folder.done("energy s.ply --all-pairs --density d.ply --report r.json");
    let result = folder.json("r.json")["result"].clone();
    assert!((result["energy"].as_f64().unwrap() / 2.504071120297146 - 1.0).abs() < 1e-11);
    assert!((result["gradient_norm"].as_f64().unwrap() / 0.3305973985151843 - 1.0).abs() < 1e-11);
    let header = String::from_utf8_lossy(&folder.bytes("d.ply")[..700]).into_owned();
    assert!(header.contains("property double energy_density"), "{header}");
    folder.done("render d.ply --field energy_density -o d.png --size 320x240");
    folder.done("energy s.ply --report far.json");
    let far = folder.json("far.json")["result"].clone();
    for (key, most) in [("energy", 1e-3), ("gradient_norm", 5e-3)] {
        let [far, all] = [&far, &result].map(|result| result[key].as_f64().unwrap());
        assert!(far != all && (far / all - 1.0).abs() < most, "{key}: {far} {all}");
    }
    folder.done("energy s.ply --p 4 --all-pairs --report p.json");
    folder.done("energy s.ply --alpha 4 --beta 8 --all-pairs --report ab.json");
    assert_eq!(folder.json("p.json")["result"], folder.json("ab.json")["result"]);
}

#[test]
fn tips_that_nearly_touch_need_adaptive_quadrature() {
    let folder = Folder::new();
    folder
        .write("tips.obj", "v 0 0 .01\nv 1 0 1\nv 0 1 1\nv 0 0 -.01\nv 1 0 -1\nv 0 1 -1\nf 1 2 3\nf 4 6 5\n");
    for (options, energy) in
        [("", 0.00986), ("--quadrature midpoint", 0.00986), ("--quadrature adaptive", 6.565)]
    {
        folder.done(&format!("energy tips.obj {options} --report r.json"));
        let found = folder.json("r.json")["result"]["energy"].as_f64().unwrap();
        assert!((found / energy - 1.0).abs() < 1e-3, "{options}: {found}");
    }
}

#[test]
fn faults_name_the_option_or_element_and_leave_no_file() {
    let folder = Folder::new();
    folder.done("make icosphere levels=1 -o s.ply");
    for (options, words) in [
        ("--p 2", ["alpha = 2", "p = 6"]),
        ("--alpha 6 --beta 20", ["beta = 20", "p = 6"]),
        ("--p 6 --beta 12", ["--p", "--beta"]),
        ("--alpha 6", ["--beta", "required"]),
        ("--density d.obj", ["d.obj", ".ply and .vtp"]),
    ] {
        folder.refused(&format!("energy s.ply {options}"), 2, &words);
    }
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n");
    folder.refused("energy flat.obj --density d.ply", 3, &["face 1", "no area"]);
    assert!(!folder.files().contains(&"d.ply".to_string()));
}
