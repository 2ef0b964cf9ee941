//! Benchmark cases: meshes with a source whose exact distance is known.

use crate::bench::peer::{write, write_doubles, write_mesh};
use crate::exit::Failure;
use clap::ValueEnum;
use eikona::contour::isolines;
use eikona::geometry::Triangle;
use eikona_mesh::{Located, SurfaceCurves, TriangleMesh, shapes};
use std::path::Path;

/// Benchmark surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Shape {
    /// The unit sphere with uniform triangles
    Sphere,
    /// The torus with radii 1 and 0.4
    Torus,
}

impl Shape {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Shape::Sphere => "sphere",
            Shape::Torus => "torus",
        }
    }
}

const MINOR: f64 = 0.4;
const LATITUDE: f64 = 0.3;

/// A mesh, a source, and the exact distance at the vertices.
pub struct Case {
    pub mesh: TriangleMesh,
    pub source: SurfaceCurves,
    truth: Vec<f64>,
    /// A third of the area of the faces around each vertex.
    area: Vec<f64>,
}

impl Case {
    /// Creates the shape with about this many faces, and its intersection with a plane of constant
    /// z as source.
    pub fn new(shape: Shape, faces: usize) -> Result<Case, Failure> {
        let (mesh, level) = match shape {
            Shape::Sphere => {
                let frequency = (faces as f64 / 20.0).sqrt().round().max(1.0);
                (shapes::geodesic_sphere(frequency as usize)?, LATITUDE)
            }
            Shape::Torus => {
                // 2 nu nv faces of about equal shape: the outer circle is 1.4 / 0.4 times as long
                // as the circle of the tube. A multiple of 4 puts vertices on the source circles
                // and on the ridges of the distance between them.
                let quarter = (faces as f64 / 2.0 / 2.5 / 16.0).sqrt().round().max(1.0) as usize;
                (shapes::torus(1.0, MINOR, 10 * quarter, 4 * quarter)?, 0.0)
            }
        };
        let height: Vec<f64> = mesh.positions().iter().map(|p| p[2]).collect();
        let circles = isolines(&mesh, &height.into(), &[level])?.pop().unwrap_or_default();
        let truth = mesh.positions().iter().map(|&p| exact(shape, p)).collect();
        let mut area = vec![0.0; mesh.vertex_count()];
        for face in mesh.faces() {
            let third = Triangle::of_face(&mesh, face).area / 3.0;
            mesh.face_vertices(face).iter().for_each(|v| area[v.index()] += third);
        }
        Ok(Case { mesh, source: SurfaceCurves { curves: circles.curves, points: Vec::new() }, truth, area })
    }

    /// The error sqrt(sum A (phi - phi0)² / sum A), divided by the range of phi0.
    pub fn l2_error(&self, distance: &[f64]) -> f64 {
        let squares = distance.iter().zip(&self.truth).zip(&self.area).map(|((d, t), a)| a * (d - t).powi(2));
        let mean = squares.sum::<f64>() / self.area.iter().sum::<f64>();
        let (low, high) =
            self.truth.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &t| (l.min(t), h.max(t)));
        mean.sqrt() / (high - low)
    }

    /// Writes mesh, curve and exact distance as raw arrays and JSON for another program.
    pub fn export(&self, folder: &Path) -> Result<(), Failure> {
        write_mesh(folder, &self.mesh)?;
        write_doubles(folder, "truth.f64", self.truth.iter().copied())?;
        write_doubles(folder, "area.f64", self.area.iter().copied())?;
        let mut curves: Vec<Vec<(u32, u32, f64)>> = Vec::new();
        for curve in &self.source.curves {
            let mut nodes = Vec::with_capacity(curve.nodes.len());
            for node in &curve.nodes {
                nodes.push(match node.locate(&self.mesh).map_err(|e| Failure::Failed(e.to_string()))? {
                    Located::Vertex(v) => (v.0, v.0, 0.0),
                    Located::Edge(e, t) => {
                        let [a, b] = self.mesh.edge_vertices(e);
                        (a.0, b.0, t)
                    }
                    Located::Face(f, _) => {
                        return Err(Failure::Failed(format!(
                            "an isoline has a node inside {f}; this is a bug, please report it"
                        )));
                    }
                });
            }
            curves.push(nodes);
        }
        let text = serde_json::to_string(&curves).map_err(|e| Failure::Failed(e.to_string()))?;
        write(folder, "curves.json", text.as_bytes())
    }
}

/// The exact distance, negative where z is smaller than on the source.
fn exact(shape: Shape, [x, y, z]: [f64; 3]) -> f64 {
    match shape {
        Shape::Sphere => LATITUDE.acos() - z.clamp(-1.0, 1.0).acos(),
        Shape::Torus => {
            let around_tube = z.atan2(x.hypot(y) - 1.0).abs();
            MINOR * around_tube.min(std::f64::consts::PI - around_tube) * z.signum()
        }
    }
}
