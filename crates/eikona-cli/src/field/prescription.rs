//! Reads singularities, indices and points from JSON.

use crate::exit::Failure;
use crate::input::MeshInput;
use eikona::polar_field::{Place, Singularity};
use eikona_mesh::{CurveError, FileError, SurfacePoint};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::Path;

/// One entry of a list, read key by key, so that the error names a wrong key.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object such as {\"vertex\": 3, \"index\": 0.25}")]
pub struct Entry {
    vertex: Option<u32>,
    edge: Option<[u32; 2]>,
    t: Option<f64>,
    face: Option<[u32; 3]>,
    bary: Option<[f64; 3]>,
    boundary: Option<usize>,
    index: Option<f64>,
}

const FORMS: &str =
    "{\"vertex\": i}, {\"edge\": [i, j], \"t\": t} or {\"face\": [i, j, k], \"bary\": [a, b, c]}";

/// Returns the entry of a singularity. `file` converts vertices to the numbers of the file.
pub fn entry(singularity: &Singularity, file: impl Fn(u32) -> u32) -> Value {
    let index = singularity.index;
    match singularity.place {
        Place::Boundary(boundary) => json!({"boundary": boundary, "index": index}),
        Place::Point(SurfacePoint::Vertex { vertex }) => json!({"vertex": file(vertex), "index": index}),
        Place::Point(SurfacePoint::Edge { vertices, t }) => {
            json!({"edge": vertices.map(file), "t": t, "index": index})
        }
        Place::Point(SurfacePoint::Face { vertices, bary }) => {
            json!({"face": vertices.map(file), "bary": bary, "index": index})
        }
    }
}

impl Entry {
    /// Returns the singularity, in the numbers of the file.
    pub fn singularity(&self) -> Result<Singularity, String> {
        let index = self.index.ok_or("the key \"index\" is missing; add it")?;
        let place = match (self.boundary, self.point()) {
            (Some(boundary), None) if self.has_no_point() => Place::Boundary(boundary),
            (None, Some(point)) => Place::Point(point),
            _ => {
                return Err(format!(
                    "a singularity is {FORMS} or {{\"boundary\": loop}}, with exactly these keys and \"index\""
                ));
            }
        };
        Ok(Singularity { place, index })
    }

    fn point(&self) -> Option<SurfacePoint> {
        match *self {
            Entry { vertex: Some(vertex), edge: None, t: None, face: None, bary: None, .. } => {
                Some(SurfacePoint::Vertex { vertex })
            }
            Entry { vertex: None, edge: Some(vertices), t: Some(t), face: None, bary: None, .. } => {
                Some(SurfacePoint::Edge { vertices, t })
            }
            Entry { vertex: None, edge: None, t: None, face: Some(vertices), bary: Some(bary), .. } => {
                Some(SurfacePoint::Face { vertices, bary })
            }
            _ => None,
        }
    }
    fn has_no_point(&self) -> bool {
        self.vertex.is_none()
            && self.edge.is_none()
            && self.t.is_none()
            && self.face.is_none()
            && self.bary.is_none()
    }
}

/// Whether a file is of the form of Directional: N and a count, then vertices with index times N.
pub fn is_sings(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("sings") || e.eq_ignore_ascii_case("sing"))
}

/// Reads `N count`, then rows of a vertex and its index times N.
fn read_sings(path: &Path, degree: u32, input: &MeshInput) -> Result<Vec<Singularity>, Failure> {
    let bytes = std::fs::read(path)
        .map_err(|fault| Failure::reading(path, FileError::Io { path: path.display().to_string(), fault }))?;
    let text = String::from_utf8_lossy(&bytes);
    let wrong = |line: usize, problem: String| {
        Failure::Input(format!("{}: line {}: {problem}", path.display(), line + 1))
    };
    let mut result = Vec::new();
    let mut header: Option<(i64, i64)> = None;
    for (line, words) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let numbers: Vec<i64> = words.split_whitespace().map_while(|word| word.parse().ok()).collect();
        match (header, numbers.as_slice()) {
            // An older writer adds a third number to the header.
            (None, &[n, count, ..]) if n == i64::from(degree) => header = Some((n, count)),
            (None, &[n, _, ..]) => {
                return Err(wrong(line, format!("these singularities are for N = {n}; give -n {n}")));
            }
            (Some((n, _)), &[vertex, turns]) => {
                let vertex =
                    u32::try_from(vertex).map_err(|_| wrong(line, format!("there is no vertex {vertex}")))?;
                let point = SurfacePoint::Vertex { vertex };
                let point = on_mesh(point, input).map_err(|problem| wrong(line, problem))?;
                result.push(Singularity { place: Place::Point(point), index: turns as f64 / n as f64 });
            }
            (None, _) => return Err(wrong(line, "expected N and the number of singularities".into())),
            (Some(_), _) => return Err(wrong(line, "expected a vertex and its index times N".into())),
        }
    }
    match header {
        Some((_, count)) if usize::try_from(count) == Ok(result.len()) => Ok(result),
        Some((_, count)) => {
            let found = result.len();
            Err(wrong(0, format!("the header says {count} singularities, but {found} rows follow")))
        }
        None => Err(wrong(0, "the file is empty; expected N and the number of singularities".into())),
    }
}

/// Reads a list of singularities, in the numbers of the mesh file.
pub fn read_singularities(path: &Path, degree: u32, input: &MeshInput) -> Result<Vec<Singularity>, Failure> {
    if is_sings(path) {
        return read_sings(path, degree, input);
    }
    let entries: Vec<Entry> = read(path)?;
    let mut result = Vec::with_capacity(entries.len());
    for (i, entry) in entries.iter().enumerate() {
        let wrong = |problem: String| Failure::Input(format!("{}: entry {i}: {problem}", path.display()));
        let Singularity { place, index } = entry.singularity().map_err(wrong)?;
        let place = match place {
            Place::Point(point) => Place::Point(on_mesh(point, input).map_err(wrong)?),
            Place::Boundary(boundary) => Place::Boundary(boundary),
        };
        result.push(Singularity { place, index });
    }
    Ok(result)
}

/// Reads a list of points, in the numbers of the mesh file.
pub fn read_points(path: &Path, input: &MeshInput) -> Result<Vec<SurfacePoint>, Failure> {
    let entries: Vec<Entry> = read(path)?;
    let point = |(i, entry): (usize, &Entry)| {
        let wrong = |problem: String| Failure::Input(format!("{}: entry {i}: {problem}", path.display()));
        match entry.point() {
            Some(point) if entry.boundary.is_none() && entry.index.is_none() => {
                on_mesh(point, input).map_err(wrong)
            }
            _ => Err(wrong(format!("a point is {FORMS}, with exactly these keys"))),
        }
    };
    entries.iter().enumerate().map(point).collect()
}

/// Reads a list of numbers.
pub fn read_indices(path: &Path) -> Result<Vec<f64>, Failure> {
    read(path)
}

/// Converts a point from the numbers of the file to those of the mesh, and checks that it is there.
fn on_mesh(point: SurfacePoint, input: &MeshInput) -> Result<SurfacePoint, String> {
    input.check_of_file(point)?;
    let on_mesh = input.renumber(point);
    match (on_mesh.locate(&input.mesh), point) {
        (Ok(_), _) => Ok(on_mesh),
        (Err(CurveError::NoSuchEdge { .. }), SurfacePoint::Edge { vertices: [a, b], .. }) => {
            Err(format!("vertices {a} and {b} are not joined by an edge; name the ends of one"))
        }
        (Err(CurveError::NoSuchFace { .. }), SurfacePoint::Face { vertices, .. }) => {
            Err(CurveError::NoSuchFace { vertices }.to_string())
        }
        (Err(fault), _) => Err(fault.to_string()),
    }
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, Failure> {
    let wrong = |problem: &str| {
        Failure::Input(format!("{}: {problem}; give a JSON list as shown by --help", path.display()))
    };
    let name = || path.display().to_string();
    let bytes =
        std::fs::read(path).map_err(|fault| Failure::reading(path, FileError::Io { path: name(), fault }))?;
    let text = std::str::from_utf8(&bytes).map_err(|_| wrong("this is not a text file"))?;
    if text.trim().is_empty() {
        return Err(wrong("the file is empty"));
    }
    serde_json::from_str(text).map_err(|fault| {
        let message = fault.to_string();
        // The place is given once, before the problem.
        let problem = message.rsplit_once(" at line ").map_or(message.as_str(), |(problem, _)| problem);
        let problem = in_words(problem);
        wrong(&format!("line {} column {}: {problem}", fault.line(), fault.column()))
    })
}

/// Replaces names of types in a message of the JSON reader.
fn in_words(problem: &str) -> String {
    let words = [
        ("u32", "a whole number of 0 or more"),
        ("usize", "a whole number of 0 or more"),
        ("f64", "a number"),
        ("invalid type: map, expected a sequence", "this is one object, not a list of them"),
        ("expected a sequence", "expected a list"),
        ("an array of length", "a list of length"),
    ];
    words.into_iter().fold(problem.to_string(), |text, (from, to)| text.replace(from, to))
}
