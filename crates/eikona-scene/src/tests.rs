//! Both grammars against whole files.

use super::model::{
    Barycentre, Goal, Growth, Method, Motion, ObstacleShape, Quadrature, Quantity, Remeshing, Scene, Source,
    Target,
};
use super::{is_scene, parse, read_scene};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder with files that scenes can name, removed on drop.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("eikona-scene-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        for name in ["a.obj", "box.obj", "handcuffs.obj", "scan.ply", "room.npz"] {
            std::fs::write(path.join(name), "").unwrap();
        }
        Folder(path)
    }

    fn read(&self, name: &str, text: impl AsRef<[u8]>) -> Result<Scene, String> {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        read_scene(&path).map_err(|fault| fault.to_string())
    }

    #[track_caller]
    fn refused(&self, name: &str, text: &str, line: Option<usize>, words: &[&str]) {
        let message = self.read(name, text).expect_err(text);
        let place = line.map_or("scene.".into(), |line| format!("line {line}: "));
        for word in [place.as_str()].iter().chain(words) {
            assert!(message.contains(word), "no {word:?} in\n{message}\nof\n{text}");
        }
        assert!(!message.contains("faults:"), "more than one fault:\n{message}\nof\n{text}");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const ALL_WORDS: &str = "\u{feff}# every statement\r
repel_mesh\ta.obj  3.5 7 \r
  constrain barycenter\r
allow_barycenter_shift\r
constrain area 2 200 1.5\r
constrain volume .9 100\r
autotarget_volume 0.8\r
constrain vertices 0 12\r
constrain vertex 7 8 move 0 -.5 1e-1 50\r
constrain boundary_vertices\r
constrain boundary_normals\r
minimize squared_error\r
minimize area -1\r
minimize volume 2\r
minimize area_deviation 3\r
minimize volume_deviation 4\r
minimize boundary_length 5 2.5\r
minimize boundary_curvature 6\r
minimize willmore 7 0\r
obstacle box.obj .1 centered\r
point_cloud_obstacle scan.ply\r
implicit sphere repel 2 0.1 1 0 0 0\r
implicit cylinder repel 2 .1 0.075 0 0 0 0 0 1\r
implicit torus repel 2 .001 .8 0.1 0 0 0\r
implicit plane attract 2 20 0 0 0 -.11 0 .99\r
\r
iteration_limit 4000\r
time_limit 1500\r
disable_near_field\r
method l2\r
log out.csv";

#[test]
fn every_word_of_the_original_grammar_is_read() {
    let folder = Folder::new();
    let scene = folder.read("scene.txt", ALL_WORDS).unwrap();
    assert_eq!(scene.surfaces[0].value.source, Source::File(folder.0.join("a.obj")));
    assert_eq!((scene.surfaces[0].line, scene.exponents), (2, [3.5, 7.0]));
    let keep = &scene.constraints;
    assert_eq!(keep.barycentre.unwrap().value, Barycentre::Floating);
    let growth = |goal, steps| Target::Growth(Growth { goal, steps });
    assert_eq!(keep.area.unwrap().value, growth(Goal::Start { times: 2.0, plus: 1.5 }, 200));
    let volume = keep.volume.unwrap();
    assert_eq!((volume.line, volume.value), (7, growth(Goal::Obstacle { times: 0.8 }, 100)));
    let pins: Vec<_> = keep.pins.iter().map(|pin| (pin.line, pin.value.vertex, pin.value.motion)).collect();
    let motion = Some(Motion { offset: [0.0, -0.5, 0.1], steps: 50 });
    assert_eq!(pins, [(8, 0, None), (8, 12, None), (9, 7, motion), (9, 8, motion)]);
    assert_eq!((keep.boundary_vertices, keep.boundary_normals), (Some(10), Some(11)));
    let terms: Vec<_> = scene.terms.iter().map(|t| (t.value.quantity, t.value.weight)).collect();
    let weights = [1.0, -1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    assert_eq!(terms, Quantity::ALL.into_iter().zip(weights).collect::<Vec<_>>());
    let targets: Vec<_> = scene.terms[5..].iter().map(|t| t.value.target).collect();
    assert_eq!(targets, [Some(2.5), None, Some(0.0)]);
    assert!(matches!(scene.obstacles[0].value.shape, ObstacleShape::Mesh { centred: true, .. }));
    assert!(matches!(scene.obstacles[1].value.shape, ObstacleShape::Points { centred: false, .. }));
    assert_eq!(scene.obstacles.iter().map(|o| o.value.weight).collect::<Vec<_>>(), [0.1, 1.0]);
    assert_eq!(scene.barriers.iter().map(|b| b.line).collect::<Vec<_>>(), [22, 23, 24, 25]);
    assert_eq!((scene.stop.steps.unwrap().value, scene.stop.seconds.unwrap().value), (4000, 1.5));
    assert_eq!(scene.low_order_off, Some(29));
    assert_eq!(scene.method.unwrap().value, Method::L2);
    assert_eq!(scene.log.unwrap().value, folder.0.join("out.csv"));
    for method in Method::NAMES {
        folder.read("scene.txt", format!("repel_mesh a.obj\nmethod {method}\n")).unwrap();
    }
}

#[test]
fn faults_of_the_original_grammar_name_their_line() {
    let folder = Folder::new();
    for (line, words) in [
        ("minimzie area", vec!["`minimzie`", "`minimize`", "constrain, "]),
        ("constrain barycentre", vec!["did you mean `barycenter`", "boundary_normals"]),
        ("constrain normals", vec!["not supported", "boundary_normals"]),
        ("constrain", vec!["nothing to constrain", "volume"]),
        ("constrain area 2", vec!["takes 0, 2 or 3 values ([MULTIPLIER", "but has 1"]),
        ("constrain area 2 100 # doubled", vec!["but has 4", "comment needs a line of its own"]),
        ("constrain area 0 100", vec!["multiplier is `0`", "above 0"]),
        ("constrain volume -2 100", vec!["multiplier is `-2`", "above 0"]),
        ("constrain volume 2 0", vec!["`0`", "1 or more"]),
        ("constrain volume 2 1e2", vec!["`1e2`", "whole number"]),
        ("constrain vertices", vec!["names no vertex"]),
        ("constrain vertices 3 4.0", vec!["`4.0`", "whole number of 0 or more"]),
        ("constrain vertices -1", vec!["`-1`", "whole number of 0 or more"]),
        ("constrain vertices 3 move 1 0 0", vec!["`move` takes 4 values", "but has 3"]),
        ("constrain vertices 3 move 1 0 0 0", vec!["iterations is `0`"]),
        ("constrain vertices 3 4 3", vec!["vertex 3", "line 2"]),
        ("constrain barycenter 1", vec!["`constrain barycenter` takes no values, but has 1"]),
        ("minimize wilmore", vec!["did you mean `willmore`"]),
        ("minimize area nan", vec!["`nan`", "finite"]),
        ("minimize area inf", vec!["`inf`", "finite"]),
        ("minimize area 1 2 3", vec!["1, 2 or 3 values", "but has 4"]),
        ("obstacle", vec!["`obstacle` takes 1, 2 or 3 values (FILE", "but has 0"]),
        ("obstacle box.obj -1", vec!["`-1`", "0 or more"]),
        ("obstacle box.obj 1 centred", vec!["did you mean `centered`"]),
        ("obstacle none.obj", vec!["no file", "none.obj"]),
        ("obstacle .", vec!["is a folder"]),
        ("implicit", vec!["names no surface", "cylinder"]),
        ("implicit spher repel 2 1 1 0 0 0", vec!["did you mean `sphere`"]),
        ("implicit sphere push 2 1 1 0 0 0", vec!["`push`", "repel, attract"]),
        ("implicit sphere repel 2 1 1 0 0", vec!["`implicit sphere` takes 7 values", "but has 6"]),
        ("implicit sphere repel 0 1 1 0 0 0", vec!["power is `0`"]),
        ("implicit sphere repel 2 1 0 0 0 0", vec!["radius is 0"]),
        ("implicit plane repel 2 1 0 0 0 0 0 0", vec!["normal", "no direction"]),
        ("iteration_limit 0", vec!["`0`", "1 or more"]),
        ("iteration_limit", vec!["`iteration_limit` takes 1 value (ITERATIONS), but has 0"]),
        ("time_limit -5", vec!["`-5`", "1 or more"]),
        ("method newton", vec!["`newton`", "h1-lbfgs"]),
        ("log", vec!["but has 0"]),
        ("disable_near_field 1", vec!["takes no values"]),
        ("autotarget_volume 0.5", vec!["volume is not constrained"]),
    ] {
        folder.refused("scene.txt", &format!("repel_mesh a.obj 6 12\n{line}\n"), Some(2), &words);
    }
    for (text, line, words) in [
        ("constrain area\n", None, vec!["repel_mesh"]),
        ("", None, vec!["repel_mesh"]),
        ("repel_mesh a.obj 6\n", Some(1), vec!["1 or 3 values", "but has 2"]),
        ("repel_mesh a.obj 2 4\n", Some(1), vec!["p = 6"]),
        ("repel_mesh b.obj 6 12", Some(1), vec!["no file", "b.obj"]),
        ("repel_mesh a.obj\n\nrepel_mesh box.obj", Some(3), vec!["line 1 and again on line 3"]),
        ("repel_mesh a.obj\nautotarget_volume\nconstrain volume", Some(2), vec!["line 3"]),
        ("repel_mesh a.obj\nautotarget_volume\nconstrain volume 1 9", Some(2), vec!["no obstacle mesh"]),
        (
            "repel_mesh a.obj\nautotarget_volume\nconstrain volume 1 9\nobstacle a.obj\nobstacle box.obj",
            Some(2),
            vec!["2 obstacle meshes (lines 4, 5)"],
        ),
    ] {
        folder.refused("scene.txt", text, line, &words);
    }
    for line in [
        "constrain area",
        "constrain volume",
        "constrain barycenter",
        "constrain boundary_vertices",
        "constrain boundary_normals",
        "constrain vertices 4",
        "allow_barycenter_shift",
        "disable_near_field",
        "iteration_limit 3",
        "time_limit 3",
        "minimize willmore",
        "method hs",
        "log a.csv",
    ] {
        let text = format!("repel_mesh a.obj\n{line}\n# again\n{line}\n");
        folder.refused("scene.txt", &text, Some(4), &["on line 2 and again on line 4"]);
    }
}

#[test]
fn all_faults_of_a_file_come_at_once() {
    let folder = Folder::new();
    let text = "constrian area\nrepel_mesh b.obj 6 12\nobstacle c.obj\niteration_limit -1\n";
    let message = folder.read("scene.txt", text).unwrap_err();
    for word in ["4 faults", "line 1: ", "line 2: ", "b.obj", "line 3: ", "c.obj", "line 4: "] {
        assert!(message.contains(word), "no {word:?} in\n{message}");
    }
    let message = folder.read("scene.txt", "odd\n".repeat(15)).unwrap_err();
    assert!(message.contains("16 faults") && message.contains("line 10: "), "{message}");
    assert!(message.ends_with("and 6 more"), "{message}");
    let message = folder.read("scene.toml", "q = 6\n").unwrap_err();
    assert!(message.contains("2 faults") && message.contains("nothing says what to move"), "{message}");
    let text = "mesh = \"b.obj\"\nq = 6\n[keep]\narea = 3\nvolume = { times = 0, steps = 1 }\n\
                [[obstacle]]\nmesh = \"c.obj\"\n[[obstacle]]\nweight = -1\nmesh = \"a.obj\"\n\
                [stop]\nsteps = 0\nenergie = 2\n";
    let message = folder.read("scene.toml", text).unwrap_err();
    let lines: Vec<&str> =
        message.lines().skip(1).map(|line| line.trim().split(": ").next().unwrap()).collect();
    assert_eq!(
        lines,
        ["line 1", "line 2", "line 4", "line 5", "line 7", "line 9", "line 12", "line 13"],
        "{message}"
    );
}

/// The text of the page's block in a language.
fn block_of_page(language: &str) -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenes.md");
    let text = std::fs::read_to_string(page).unwrap();
    let block = text.split(&format!("```{language}\n")).nth(1).and_then(|rest| rest.split("```").next());
    block.unwrap().to_string()
}

#[test]
fn the_example_of_the_page_is_read() {
    let folder = Folder::new();
    let scene = folder.read("scene.toml", block_of_page("toml")).unwrap();
    assert_eq!(scene.surfaces.len(), 2);
    assert_eq!(scene.surfaces[1].value.offset, [4.0, 0.0, 0.0]);
    let parameters = vec![("minor".to_string(), "0.2".to_string())];
    assert_eq!(scene.surfaces[1].value.source, Source::Shape { name: "torus".into(), parameters });
    assert_eq!(scene.exponents, [6.0, 12.0]);
    assert_eq!(scene.constraints.barycentre.unwrap().value, Barycentre::Floating);
    assert_eq!(scene.constraints.pins.len(), 4);
    assert_eq!((scene.constraints.boundary_vertices, scene.low_order_off), (None, None));
    assert_eq!(scene.terms[0].value.target, Some(2.5));
    assert!(matches!(scene.obstacles[2].value.shape, ObstacleShape::Grid { .. }));
    assert_eq!(scene.barriers.len(), 2);
    assert_eq!(scene.stop.energy.unwrap().value, 10.0);
    let remeshing = Remeshing::On { edge_length: Some(0.05), adaptive: true };
    assert_eq!(scene.remeshing.unwrap().value, remeshing);
    assert_eq!(scene.output.checkpoint_every.unwrap().value, 50);
    assert_eq!((scene.collisions.unwrap().value, scene.seed.unwrap().value), (true, 1));
    assert_eq!(scene.quadrature.unwrap().value, Quadrature::Adaptive);
    // Without a table of constraints, those of the command hold.
    let plain = folder.read("scene.toml", "\u{feff}mesh = \"a.obj\"\r\nremesh = false").unwrap();
    assert_eq!(plain.constraints.area.unwrap().value, Target::Constant);
    assert_eq!(plain.constraints.barycentre.unwrap().value, Barycentre::Kept);
    assert_eq!(plain.remeshing.unwrap().value, Remeshing::Off);
    let bare = "mesh = { shape = \"geodesic-sphere\", frequency = 3 }\n[keep]\nbarycenter = false\n";
    let bare = folder.read("scene.toml", bare).unwrap();
    assert!(bare.constraints.area.is_none() && bare.constraints.barycentre.is_none());
}

#[test]
fn faults_of_toml_name_their_line() {
    let folder = Folder::new();
    for (text, words) in [
        ("colisions = true", vec!["`colisions`", "did you mean `collisions`", "keep"]),
        ("p = 2", vec!["p = 6"]),
        ("p = nan", vec!["p = 6"]),
        ("beta = 12", vec!["`alpha`"]),
        ("p = \"six\"", vec!["expected a number"]),
        ("method = \"newton\"", vec!["`newton`", "h1-lbfgs"]),
        ("seed = -1", vec!["whole number"]),
        ("keep = { area = \"yes\" }", vec!["true, false, or a table"]),
        ("keep = { area = { times = 2 } }", vec!["`steps` is missing"]),
        ("keep = { area = { times = 2, steps = 0 } }", vec!["0: expected a whole number of 1"]),
        ("keep = { area = { times = -2, steps = 1 } }", vec!["-2: expected a number above 0"]),
        ("keep = { area = { times = 2, steps = 1, of = \"obstacle\" } }", vec!["only the volume"]),
        ("keep = { volume = { steps = 1, plus = 1, of = \"obstacle\" } }", vec!["`plus`"]),
        ("keep = { volume = { steps = 1, of = \"obstacle\" } }", vec!["no obstacle mesh"]),
        ("keep = { barycentre = \"float\" }", vec!["did you mean `floating`"]),
        ("pin = [{ vertices = [1.5] }]", vec!["whole number of 0 or more"]),
        ("pin = [{ vertices = [-1] }]", vec!["whole number of 0 or more"]),
        ("pin = [{ vertices = [] }]", vec!["empty"]),
        ("pin = [{ vertices = [1], steps = 3 }]", vec!["`move`"]),
        ("pin = [{ vertices = [1], move = [0, 0, 1] }]", vec!["`steps`"]),
        ("pin = [{ vertices = [1], move = [0, 1], steps = 3 }]", vec!["list of length 3"]),
        ("pin = [{ vertices = [1] }, { vertices = [2, 1] }]", vec!["vertex 1"]),
        ("minimise = [{ term = \"lenght\" }]", vec!["`lenght`", "boundary_length"]),
        ("minimise = [{ weight = 3 }]", vec!["`term` is missing"]),
        ("minimise = [{ term = \"area\", weight = inf }]", vec!["finite"]),
        ("minimise = [{ term = \"area\" }, { term = \"area\" }]", vec!["minimize area"]),
        ("obstacle = [{ weight = 3 }]", vec!["exactly one of the keys mesh, points and grid"]),
        ("obstacle = [{ mesh = \"none.obj\" }]", vec!["no file", "none.obj"]),
        ("obstacle = [{ grid = \"room.npz\", centred = true }]", vec!["can not be centred"]),
        ("obstacle = [{ mesh = \"a.obj\", wight = 3 }]", vec!["did you mean `weight`"]),
        ("obstacle = [{ mesh = { shape = \"tours\" } }]", vec!["did you mean `torus`"]),
        ("obstacle = [{ mesh = { shape = \"torus\", minro = 1 } }]", vec!["did you mean `minor`"]),
        ("obstacle = [{ mesh = { shape = \"torus\", minor = -1 } }]", vec!["minor"]),
        ("obstacle = [{ mesh = { file = \"a.obj\", minor = 1 } }]", vec!["`minor`"]),
        ("obstacle = [{ mesh = { file = \"a.obj\", shape = \"torus\" } }]", vec!["keep one of both"]),
        ("obstacle = [{ mesh = {} }]", vec!["a file or a shape"]),
        ("implicit = [{ action = \"repel\", power = 1, weight = 1 }]", vec!["exactly one", "cylinder"]),
        (
            "implicit = [{ sphere = { radius = 1 }, action = \"repel\", power = 1, weight = 1 }]",
            vec!["`centre` is missing"],
        ),
        (
            "implicit = [{ sphere = { radius = 0, centre = [0, 0, 0] }, action = \"repel\", power = 1, \
             weight = 1 }]",
            vec!["radius is 0"],
        ),
        ("stop = { seconds = 0 }", vec!["above 0"]),
        ("remesh = { edge = 0 }", vec!["above 0"]),
        ("quadrature = \"gauss\"", vec!["`gauss`", "midpoint", "adaptive"]),
        ("remesh = 3", vec!["true, false"]),
        ("output = { frames_every = 0 }", vec!["1 or more"]),
        ("p = ", vec!["not TOML"]),
        ("mesh = \"a.obj\"", vec!["`mesh` is given on line 1 and again on line 2"]),
    ] {
        folder.refused("scene.toml", &format!("mesh = \"a.obj\"\n{text}\n"), Some(2), &words);
    }
    for (text, line, words) in [
        ("p = 6", None, vec!["mesh = "]),
        ("", None, vec!["mesh = "]),
        ("mesh = []", Some(1), vec!["empty"]),
        ("mesh = 3", Some(1), vec!["a file name"]),
        ("\nmesh = [\"a.obj\",\n\"none.obj\"]", Some(3), vec!["none.obj"]),
        ("[mesh]\nshape = \"torus\"\nminro = 3", Some(3), vec!["`minor`"]),
        ("mesh = \"a.obj\"\np = 6\n\nalpha = 6", Some(4), vec!["line 2", "line 4"]),
        ("mesh = \"a.obj\"\nalpha = 6\nbeta = 30", Some(3), vec!["beta"]),
        (
            "mesh = \"a.obj\"\n[keep]\narea = true\n[stop]\nsteps = 1\n[keep]\nvolume = true",
            Some(6),
            vec!["`keep` is given on line 2"],
        ),
        ("mesh = \"a.obj\"\n[[obstacle]]\nmesh = \"a.obj\"\n\n[[obstacle]]\n", Some(5), vec!["exactly one"]),
    ] {
        folder.refused("scene.toml", text, line, &words);
    }
}

#[test]
fn a_file_that_is_no_scene_is_refused() {
    let folder = Folder::new();
    let message = folder.read("scene.txt", b"repel_mesh a.obj\n\xff\xfe").unwrap_err();
    assert!(message.contains("line 2: this is not UTF-8"), "{message}");
    let message = folder.read("scene.txt", "odd\n".repeat(100_000)).unwrap_err();
    assert!(message.contains("100001 faults"), "{message}");
    for text in ["[".repeat(100_000), "a = [".repeat(100_000), "= 1\n".repeat(100_000)] {
        assert!(folder.read("scene.toml", text).is_err());
    }
    let message = read_scene(&folder.0.join("none.txt")).unwrap_err().to_string();
    assert!(message.contains("none.txt: No such file"), "{message}");
}

#[test]
fn scenes_are_told_from_meshes() {
    let folder = Folder::new();
    let is = |name: &str, text: &str| {
        std::fs::write(folder.0.join(name), text).unwrap();
        is_scene(&folder.0.join(name))
    };
    assert!(is("a.TXT", "") && is("b.toml", "") && is("c", "\u{feff}# c\n\n constrain area\n"));
    assert!(!is("d.obj", "constrain area") && !is("e", "v 0 0 0\n") && !is("f", ""));
    assert!(!is_scene(Path::new("-")) && !is_scene(&folder.0) && is_scene(Path::new("none.txt")));
}

/// A small generator of random numbers, the same each time.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % bound.max(1)
    }

    /// Cuts a file short, flips bytes, and swaps or repeats lines.
    fn mutate(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        for _ in 0..=self.below(3) {
            match self.below(4) {
                0 => bytes.truncate(self.below(bytes.len())),
                1 if !bytes.is_empty() => {
                    let at = self.below(bytes.len());
                    bytes[at] ^= 1 << self.below(8);
                }
                2 if !bytes.is_empty() => {
                    let at = self.below(bytes.len());
                    let other = self.below(bytes.len());
                    bytes[at] = bytes[other];
                }
                _ => {
                    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
                    let (a, b) = (self.below(lines.len()), self.below(lines.len()));
                    if self.below(2) == 0 && !lines.is_empty() {
                        lines.swap(a, b);
                    } else if !lines.is_empty() {
                        lines.insert(a, lines[b]);
                    }
                    bytes = lines.concat();
                }
            }
        }
        bytes
    }
}

#[test]
fn damaged_scenes_never_panic() {
    let folder = Folder::new();
    let mut random = Random(7);
    for (name, text) in [("scene.txt", ALL_WORDS.to_string()), ("scene.toml", block_of_page("toml"))] {
        let path = folder.0.join(name);
        let mut refused = 0;
        for _ in 0..4000 {
            let bytes = random.mutate(text.as_bytes());
            let (_, faults) = parse(&bytes, &path);
            if let Err(fault) = faults.into_result(&path) {
                refused += 1;
                let message = fault.to_string();
                assert!(message.lines().count() <= 12, "{message}");
            }
        }
        assert!(refused > 1000 && refused < 4000, "{name}: {refused} of 4000 were refused");
    }
}

/// All scene files of the authors' program in the data folder.
#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn the_scenes_of_the_data_folder_are_read() {
    let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/repulsive"));
    let (mut read, mut missing) = (0, Vec::new());
    for folder in std::fs::read_dir(data).unwrap().map(|entry| entry.unwrap().path()) {
        for path in std::fs::read_dir(&folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
            if path.extension().is_none_or(|extension| extension != "txt") {
                continue;
            }
            match read_scene(&path).map_err(|fault| fault.to_string()) {
                Ok(scene) => {
                    read += 1;
                    assert_eq!(scene.surfaces.len(), 1, "{path:?}");
                }
                Err(message) => missing.push(message),
            }
        }
    }
    println!("{read} scenes were read, {} name a mesh that is missing", missing.len());
    assert_eq!((read, missing.len()), (15, 1), "{missing:?}");
    assert!(missing[0].contains("Bunny/scene.txt: line 1: there is no file"), "{missing:?}");
    assert!(missing[0].contains("Bunny/bunny.obj"), "{missing:?}");
}
