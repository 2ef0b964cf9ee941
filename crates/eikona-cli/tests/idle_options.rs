//! Options without effect, and outputs that would overwrite something, are refused or give a
//! warning.

mod run;

use run::{Folder, LINE, grid_obj};

fn grid() -> Folder {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.write("line.json", LINE);
    folder
}

#[test]
fn an_output_must_differ_from_other_outputs_and_inputs() {
    let folder = grid();
    std::fs::create_dir(folder.0.join("sub")).unwrap();
    folder.write("points.json", r#"{"eikona":"curves","version":1,"points":[{"vertex":3}]}"#);
    folder.write("space.obj", "v 5 0 0\nv 5 2 0\nl 1 2\n");
    let sdf = "sdf grid.obj --curve line.json";
    for other in ["./same.csv", "sub/../same.csv"] {
        folder.refused(&format!("{sdf} -o same.csv --report {other}"), 2, &["same.csv and", other]);
    }
    folder.refused("make torus -o t.obj --curve-out ./t.obj --cut axis=x", 2, &["t.obj and ./t.obj"]);
    folder.refused("make torus -o t.obj --curve-out ./t.obj --cut axis=x", 2, &["name them differently"]);
    for (command, words) in [
        (format!("{sdf} -o ./grid.obj"), ["./grid.obj", "input grid.obj"]),
        (format!("{sdf} -o grid.obj"), ["grid.obj", "another name"]),
        (format!("{sdf} -o out.csv --report ./line.json"), ["./line.json", "input line.json"]),
        ("sdf grid.obj --points points.json --report ./points.json".into(), ["./points.json", "input"]),
        ("sdf grid.obj --curve space.obj --isolines ./space.obj".into(), ["./space.obj", "input"]),
        ("winding grid.obj --curve line.json -o sub/../grid.obj".into(), ["sub/../grid.obj", "input"]),
        ("winding grid.obj --curve line.json --suggested ./line.json".into(), ["./line.json", "input"]),
        ("render grid.obj -o out.png --report ./grid.obj".into(), ["./grid.obj", "input"]),
        ("inspect grid.obj --report ./grid.obj".into(), ["./grid.obj", "input"]),
        ("inspect grid.obj --curve line.json --report line.json".into(), ["line.json", "input"]),
    ] {
        folder.refused(&command, 2, &words);
    }
    assert_eq!((folder.read("grid.obj"), folder.read("line.json")), (grid_obj(), LINE.to_string()));
    // A file of the same name in another folder is a different file, and so is standard output.
    folder.done(&format!("{sdf} -o sub/grid.obj"));
    let outcome = folder.run_words(
        ["sdf", "-", "--curve", "line.json", "-o", "-", "--out-format", "csv"],
        grid_obj().as_bytes(),
    );
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[cfg(unix)]
#[test]
fn symbolic_links_are_followed() {
    let folder = grid();
    std::os::unix::fs::symlink("grid.obj", folder.0.join("link.obj")).unwrap();
    let input = ["link.obj", "input grid.obj"];
    folder.refused("sdf grid.obj --curve line.json -o link.obj", 2, &input);
    folder.refused("sdf link.obj --curve line.json -o grid.obj", 2, &["grid.obj", "input link.obj"]);
    std::os::unix::fs::symlink(".", folder.0.join("here")).unwrap();
    folder.refused("sdf grid.obj --curve line.json -o o.csv --report here/o.csv", 2, &["o.csv and here"]);
    // A hard link is replaced, and the file it linked to stays.
    std::fs::hard_link(folder.0.join("grid.obj"), folder.0.join("hard.obj")).unwrap();
    folder.done("sdf grid.obj --curve line.json -o hard.obj");
    assert_eq!(folder.read("grid.obj"), grid_obj());
}

#[test]
fn curves_that_points_ignores_are_counted() {
    let folder = grid();
    let points = r#""points":[{"vertex":3}]"#;
    folder.write("both.json", &LINE.replace(r#""curves":"#, &format!(r#"{points},"curves":"#)));
    folder.write("points.json", &format!(r#"{{"eikona":"curves","version":1,{points}}}"#));
    let words = ["both.json has 1 curve, which --points ignores", "--curve both.json uses both"];
    folder.warned("sdf grid.obj --points both.json -o out.csv", &words);
    folder.done("sdf grid.obj --points points.json -o out.csv --strict");
    folder.done("sdf grid.obj --curve both.json -o out.csv --strict");
}

#[test]
fn lines_of_the_mesh_are_used_if_no_source_is_given() {
    let folder = grid();
    folder.write("own.obj", &(grid_obj() + "l 16 17 18\n"));
    folder.done("sdf own.obj --points 0 -o points.csv --strict");
    folder.done("sdf grid.obj --points 0 -o same.csv --strict");
    assert_eq!(folder.bytes("points.csv"), folder.bytes("same.csv"));
    for verb in ["sdf", "winding", "inspect", "render"] {
        let help = folder.done(&format!("{verb} --help")).text();
        let words: Vec<&str> = help.split_whitespace().collect();
        let without = if verb == "winding" { "Without it" } else { "Without it and --points" };
        let sentence = format!("{without}, the `l` lines of the mesh");
        assert!(words.join(" ").contains(&sentence), "{verb}: {help}");
    }
}

#[test]
fn options_of_missing_outputs_are_refused() {
    let folder = grid();
    let picture = [
        "--size 64x48",
        "--azimuth 30",
        "--elevation 20",
        "--zoom 2",
        "--up z",
        "--ortho",
        "--transparent",
        "--no-bar",
        "--wireframe",
        "--map gray",
        "--range 0,1",
    ];
    for flags in picture {
        let flag = flags.split(' ').next().unwrap();
        folder.refused(&format!("sdf none.obj --points 0 -o o.csv {flags}"), 2, &[flag, "--render OUT.png"]);
        let winding = "winding none.obj --curve line.json";
        folder.refused(&format!("{winding} -o o.csv {flags}"), 2, &[flag, "--render-values OUT.png"]);
        if flag == "--map" || flag == "--range" {
            let words = [flag, "regions", "--render-values OUT.png"];
            folder.refused(&format!("{winding} --render o.png {flags}"), 2, &words);
            let words = [flag, "--field none"];
            folder.refused(&format!("render none.obj -o o.png --field none {flags}"), 2, &words);
        }
    }
    for flags in ["--spacing 1", "--levels 0,1"] {
        let flag = flags.split(' ').next().unwrap();
        let words = [flag, "--isolines OUT.obj", "--render OUT.png"];
        folder.refused(&format!("sdf none.obj --points 0 -o o.csv {flags}"), 2, &words);
        for output in ["--isolines i.obj", "--render i.png --size 64x48"] {
            folder.done(&format!("sdf grid.obj --curve line.json {output} {flags} --strict"));
        }
    }
    for flags in ["--spacing 1", "--isolines 5"] {
        let flag = flags.split(' ').next().unwrap();
        let words = [flag, "--field none"];
        folder.refused(&format!("render none.obj -o o.png --field none {flags}"), 2, &words);
        let words = [flag, "no field"];
        folder.warned(&format!("render grid.obj -o o.png --size 64x48 {flags}"), &words);
    }
    folder.done("render grid.obj -o o.png --size 64x48 --isolines 0 --no-bar --strict");
    let words = ["--map", "no field"];
    folder.warned("render grid.obj -o o.png --size 64x48 --map gray", &words);
    let words = ["--confidence", "-o OUT.ply"];
    folder.refused("sdf none.obj --points 0 --render o.png --confidence", 2, &words);
    folder.done("winding grid.obj --curve line.json -o l.ply -q");
    let words = ["--spacing", "label", "one value per face"];
    folder.warned("render l.ply -o o.png --size 64x48 --field label --spacing 1", &words);
}

#[test]
fn options_about_sides_need_a_signed_curve() {
    let folder = grid();
    folder.write("unsigned.json", &LINE.replace(r#"{"nodes""#, r#"{"kind":"unsigned","nodes""#));
    folder.write("own.obj", &(grid_obj() + "l 16 16\n"));
    let flags =
        ["--flip", "--sign left-negative", "--preserve-normals", "--unsigned", "--level-sets per-component"];
    for flags in flags {
        let flag = flags.split(' ').next().unwrap();
        let words = [flag, "--points", "--curve FILE"];
        folder.refused(&format!("sdf none.obj --points 0 -o o.csv {flags}"), 2, &words);
        if flag == "--level-sets" {
            folder.warned(&format!("sdf own.obj -o o.csv {flags}"), &[flag, "only points"]);
            continue;
        }
        folder.warned(&format!("sdf own.obj -o o.csv {flags}"), &[flag, "no effect", "signed"]);
        let unsigned = format!("sdf grid.obj --curve unsigned.json -o o.csv {flags}");
        folder.warned(&unsigned, &[flag, "no effect", "signed"]);
        folder.done(&format!("sdf grid.obj --curve line.json -o o.csv {flags} --strict"));
        if flag != "--unsigned" {
            let words = [flag, "--unsigned"];
            folder.refused(&format!("sdf none.obj --curve c.json -o o.csv --unsigned {flags}"), 2, &words);
        }
    }
    for flag in ["--flip", "--unsigned"] {
        folder.refused(&format!("render grid.obj --curve line.json -o o.png {flag}"), 2, &[flag, "sides"]);
        folder.refused(&format!("inspect grid.obj --points 0 {flag}"), 2, &[flag, "--points"]);
        folder.warned(&format!("inspect grid.obj {flag}"), &[flag, "no effect"]);
    }
    folder.done("sdf grid.obj --points 0 -o o.csv --strict");
}

#[test]
fn options_that_are_always_refused_are_hidden() {
    let folder = grid();
    for (verb, offered, refused) in [
        ("sdf", &["--curve", "--points", "--unsigned", "--flip"][..], &[][..]),
        ("winding", &["--curve", "--flip"], &["--points", "--unsigned"]),
        ("render", &["--curve", "--points"], &["--unsigned", "--flip"]),
    ] {
        for help in ["--help", "-h"] {
            let help = folder.done(&format!("{verb} {help}")).text();
            assert!(offered.iter().all(|flag| help.contains(flag)), "{verb}: {help}");
            assert!(!refused.iter().any(|flag| help.contains(flag)), "{verb}: {help}");
        }
    }
    // They are refused with a reason, unlike unknown options.
    for flags in ["--points 0", "--unsigned"] {
        folder.refused(&format!("winding grid.obj --curve line.json -o o.ply {flags}"), 2, &["oriented"]);
    }
}

#[test]
fn ambiguous_curves_and_idle_seeds_are_refused() {
    let folder = Folder::new();
    for (flags, words) in [
        ("--cut axis=z,at=0,axis=x", ["axis=x", "once"]),
        ("--cut at=0,at=0", ["at=0", "once"]),
        ("--cut axis=z,about=1:2:3", ["about", "wave=A"]),
        ("--cut axis=z,waves=7", ["waves", "wave=A"]),
        ("--cut axis=z,at=0,about=1:2:3,axis=x,waves=7", ["axis=x", "once"]),
        ("--curve circle,n=9,n=10", ["circle", "n=10"]),
        ("--cut axis=z --seed 3", ["--seed 3", "--broken-curve"]),
    ] {
        folder.refused(&format!("make torus -o t.ply --curve-out c.json {flags}"), 2, &words);
    }
    folder.refused("make torus -o t.ply --seed 3 --unweld", 2, &["--seed 3", "--shuffle"]);
    for flags in ["--jitter 0", "--holes 1", "--remove-faces 0.1", "--flip-faces 0.1", "--shuffle"] {
        folder.done(&format!("make torus nu=12 nv=8 -o t.ply --seed 3 {flags}"));
    }
    folder
        .done("make torus nu=12 nv=8 -o t.ply --curve-out c.json --cut axis=z,wave=0.1,waves=4,about=0:0:0");
}

#[test]
fn the_weight_of_soft_level_sets_has_a_range() {
    let folder = Folder::new();
    for weight in ["1e-20", "9e-10", "1e13", "0", "-1", "nan", "inf", "x"] {
        let words = [weight, "from 1e-9 to 1e12"];
        folder.refused(&format!("sdf none.obj --points 0 -o o.csv --level-sets soft={weight}"), 2, &words);
    }
}

#[test]
fn the_cost_of_loops_along_the_curve_has_a_range() {
    let folder = grid();
    let winding = "--curve line.json -o o.ply --epsilon";
    for epsilon in ["1e-20", "9e-10", "1.1", "0", "-1", "nan", "inf", "x"] {
        folder.refused(&format!("winding none.obj {winding} {epsilon}"), 2, &[epsilon, "from 1e-9 to 1"]);
    }
    for epsilon in ["1e-9", "1"] {
        folder.done(&format!("winding grid.obj {winding} {epsilon}"));
    }
    let help = folder.done("winding --help").text();
    assert!(help.split_whitespace().collect::<Vec<_>>().join(" ").contains("from 1e-9 to 1"), "{help}");
}
