//! Reads singularities, indices and points from JSON.

use crate::exit::Failure;
use crate::input::MeshInput;
use eikona::polar_field::{Place, Singularity};
use eikona_mesh::SurfacePoint;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// One entry of a list, read key by key, so that the error names a wrong key.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
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

impl Entry {
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

/// Reads a list of singularities, in the numbers of the mesh file.
pub fn read_singularities(path: &Path, input: &MeshInput) -> Result<Vec<Singularity>, Failure> {
    let entries: Vec<Entry> = read(path)?;
    let mut result = Vec::with_capacity(entries.len());
    for (i, entry) in entries.iter().enumerate() {
        let wrong = |problem: String| Failure::Input(format!("{}: entry {i}: {problem}", path.display()));
        let Some(index) = entry.index else {
            return Err(wrong("the key \"index\" is missing; add it".into()));
        };
        let place = match (entry.boundary, entry.point()) {
            (Some(boundary), None) if entry.has_no_point() => Place::Boundary(boundary),
            (None, Some(point)) => Place::Point(on_mesh(point, input).map_err(wrong)?),
            _ => {
                return Err(wrong(format!(
                    "a singularity is {FORMS} or {{\"boundary\": loop}}, with exactly these keys and \"index\""
                )));
            }
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
                let point = on_mesh(point, input).map_err(wrong)?;
                point.locate(&input.mesh).map_err(|e| wrong(e.to_string()))?;
                Ok(point)
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

/// Converts a point from the numbers of the file to those of the mesh.
fn on_mesh(point: SurfacePoint, input: &MeshInput) -> Result<SurfacePoint, String> {
    input.check_of_file(point)?;
    Ok(input.renumber(point))
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|fault| {
        Failure::Input(match fault.kind() {
            std::io::ErrorKind::NotFound => {
                format!("{}: no such file; check the name and the folder", path.display())
            }
            _ => format!("{}: {fault}", path.display()),
        })
    })?;
    serde_json::from_str(&text).map_err(|fault| {
        let message = fault.to_string();
        // The place is given once, before the problem.
        let problem = message.rsplit_once(" at line ").map_or(message.as_str(), |(problem, _)| problem);
        let (line, column) = (fault.line(), fault.column());
        Failure::Input(format!(
            "{}: line {line} column {column}: {problem}; give a JSON list as shown by --help",
            path.display()
        ))
    })
}
