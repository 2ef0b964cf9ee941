//! Every OBJ and OFF file of the data folder against the figures of its table, which other programs measured.

use eikona_mesh::{Orientation, PolygonMesh, Quality, Topology};
use std::path::Path;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// Vertices and faces only; reads the files of the data folder, not the formats in general.
fn read(path: &Path) -> Option<PolygonMesh> {
    let text = String::from_utf8_lossy(&std::fs::read(path).ok()?).into_owned();
    let numbers = |line: &str| -> Vec<f64> { line.split_whitespace().map_while(|w| w.parse().ok()).collect() };
    if path.extension()? == "off" {
        let content = text.trim_start().strip_prefix("OFF")?;
        let mut lines = content.lines().filter(|l| !l.trim().is_empty() && !l.trim().starts_with('#'));
        let counts = numbers(lines.next()?);
        let positions = lines.by_ref().take(counts[0] as usize).map(|l| <[f64; 3]>::try_from(&numbers(l)[..3]).unwrap());
        let mut mesh = PolygonMesh::new(positions.collect());
        for line in lines.take(counts[1] as usize) {
            let n = numbers(line);
            mesh.push_face(n[1..=n[0] as usize].iter().map(|v| *v as u32));
        }
        return Some(mesh);
    }
    let lines = || text.lines().map(str::trim_start);
    let positions = lines().filter_map(|l| l.strip_prefix("v ")).map(|l| {
        <[f64; 3]>::try_from(numbers(l).get(..3).unwrap_or_else(|| panic!("{path:?}: {l:?}"))).expect("three numbers")
    });
    let mut mesh = PolygonMesh::new(positions.collect());
    for line in lines().filter_map(|l| l.strip_prefix("f ")) {
        let index = |w: &str| w.split('/').next().and_then(|i| i.parse::<u32>().ok()).map(|i| i - 1);
        mesh.push_face(line.split_whitespace().map_while(index));
    }
    Some(mesh)
}

/// The number after `key` in a cell such as "no: 47 edges" or "chi -4, g 3"; words count from the key on.
fn number_before(cell: &str, word: &str) -> Option<i64> {
    let words: Vec<&str> = cell.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty()).collect();
    words.iter().position(|w| *w == word).and_then(|i| words.get(i.checked_sub(1)?)?.parse().ok())
}

fn number_after(cell: &str, word: &str) -> Option<i64> {
    let words: Vec<&str> = cell.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty()).collect();
    words.iter().position(|w| *w == word).and_then(|i| words.get(i + 1)?.parse().ok())
}

/// Whether `value` rounded to two digits is `shown`.
fn agrees(value: f64, shown: f64) -> bool {
    (value - shown).abs() <= 0.051 * shown.abs().max(1e-300) || value == shown
}

#[test]
fn table_of_the_data_folder() {
    let table = std::fs::read_to_string(Path::new(DATA).join("MANIFEST.md")).unwrap_or_default();
    let mut files = 0;
    let mut differences: Vec<String> = Vec::new();
    for row in table.lines().filter(|l| l.starts_with("| ")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let name = cells[1];
        if !(name.ends_with(".obj") || name.ends_with(".off")) {
            continue;
        }
        let Some(polygons) = read(&Path::new(DATA).join(name)) else { continue };
        let (mesh, _) = polygons.triangulate().unwrap_or_else(|e| panic!("{name}: {e}"));
        files += 1;
        let topology = Topology::of(&mesh);
        let orientation = Orientation::of(&mesh);
        let quality = Quality::of(&mesh);
        let mut compare = |what: &str, ours: String, table: String| {
            if ours != table {
                differences.push(format!("{name}: {what}: {ours}, in the table {table}"));
            }
        };
        let count = |cell: &str| cell.split_whitespace().next().unwrap_or("").to_string();
        compare("vertices", mesh.vertex_count().to_string(), count(cells[4]));
        compare("polygons", polygons.face_count().to_string(), count(cells[5]));
        compare("components", topology.components.len().to_string(), count(cells[6]));
        compare("sheets", topology.sheet_count.to_string(), count(cells[6]));
        compare("boundary loops", topology.boundary_loops.len().to_string(), count(cells[7]));
        compare("boundary pieces", topology.boundary_piece_count.to_string(), count(cells[7]));
        compare("chi", format!("{:?}", Some(topology.euler_characteristic)), format!("{:?}", number_after(cells[8], "χ")));
        if let Some(g) = number_after(cells[8], "g") {
            compare("genus", format!("{:?}", topology.components[0].genus), format!("Some({g})"));
        }
        let fans: usize = topology.nonmanifold_vertices.iter().map(|v| v.fans - 1).sum();
        compare("nonmanifold edges", topology.nonmanifold_edges.len().to_string(), number_before(cells[9], "edges").unwrap_or(0).to_string());
        compare("extra fans", fans.to_string(), number_before(cells[9], "extra").unwrap_or(0).to_string());
        compare("orientable", orientation.is_orientable().to_string(), cells[10].starts_with("yes").to_string());
        if orientation.is_orientable() {
            let table = number_before(cells[10], "edges").unwrap_or(0);
            compare("inconsistent edges", orientation.inconsistent_edges.len().to_string(), table.to_string());
        }
        let angles: Vec<f64> = cells[11].split(|c| " ()%:".contains(c)).filter_map(|w| w.parse().ok()).collect();
        let ours = [quality.min_angle_deg.unwrap_or(f64::NAN), quality.min_angle_percentile_1_deg.unwrap_or(f64::NAN)];
        for (what, ours, shown) in [("min angle", ours[0], angles[0]), ("1st percentile", ours[1], angles[2])] {
            if !agrees(ours, shown) {
                compare(what, ours.to_string(), shown.to_string());
            }
        }
        let faults = eikona_mesh::validate(&mesh);
        let of_kind = |kind: fn(&eikona_mesh::Fault) -> bool| faults.iter().filter(|f| kind(f)).count().to_string();
        use eikona_mesh::Fault;
        for (words, found) in [
            ("coincident", of_kind(|f| matches!(f, Fault::CoincidentVertices { .. }))),
            ("zero-area", of_kind(|f| matches!(f, Fault::ZeroArea { .. }))),
            ("duplicate", of_kind(|f| matches!(f, Fault::DuplicateFace { .. }))),
            ("unreferenced", of_kind(|f| matches!(f, Fault::UnreferencedVertex { .. }))),
        ] {
            compare(words, found, number_before(cells[14], words).unwrap_or(0).to_string());
        }
    }
    println!("{files} files of the data folder ran");
    println!("{}", differences.join("\n"));
}
