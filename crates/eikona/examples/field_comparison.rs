//! Compares power-linear fields with trivial connections (as figure 14 of the paper does), and the
//! fields of one shape on meshes of four qualities (figure 13):
//!
//! ```sh
//! cargo run --release -p eikona --example field_comparison
//! ```

use eikona::mesh::{Located, SurfacePoint, TriangleMesh, damage, shapes};
use eikona::polar_field::{AutomaticOptions, FieldOptions, Place, PolarField, Singularity, Solver};
use eikona::spatial::Bvh;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("Energy per face of cross fields with the same singularities (automatic ones, at vertices).");
    println!("split: squared gradients + 10 squared jumps; printed: as in the paper, jumps times 50 or 1\n");
    println!(
        "{:<26} {:>6} {:>4}  {:>21}  {:>23}  {:>21}",
        "mesh", "faces", "sing", "split: ours, trivial", "printed 50: ours, triv.", "printed 1: ours, triv."
    );
    for (name, mesh) in meshes()? {
        let solver = Solver::new(&mesh, &Default::default())?;
        let found = solver.automatic(&AutomaticOptions::default())?;
        let options = FieldOptions::default().with_generators(found.generators);
        let ours = solver.solve(&found.singularities, &options)?.report;
        let trivial = solver.trivial_connection(&found.singularities, &options)?.report;
        let per_face = |x: f64| x / mesh.face_count() as f64;
        let pair = |a: f64, b: f64| format!("{:.4} {:.4}", per_face(a), per_face(b));
        println!(
            "{name:<26} {:>6} {:>4}  {:>21}  {:>23}  {:>21}",
            mesh.face_count(),
            found.singularities.len(),
            pair(ours.energy, trivial.energy),
            pair(ours.printed_energy[0], trivial.printed_energy[0]),
            pair(ours.printed_energy[1], trivial.printed_energy[1]),
        );
    }
    println!(
        "\nOne ellipsoid, N = 4, eight singularities at the same points of space, on meshes of four qualities:"
    );
    println!("angle to the field on the finest mesh, in degrees, up to a common rotation\n");
    let qualities = qualities()?;
    let fields: Vec<PolarField> =
        qualities.iter().map(|(_, mesh)| of_ellipsoid(mesh)).collect::<Result<_, _>>()?;
    for ((name, mesh), field) in qualities.iter().zip(&fields) {
        let [mean, median] = angles(&fields[0], field)?;
        println!("{name:<26} {:>6} faces: root mean square {mean:.2}, median {median:.2}", mesh.face_count());
    }
    Ok(())
}

type Named = (&'static str, TriangleMesh);

/// Good, uneven and coarse meshes.
fn meshes() -> Result<Vec<Named>, Box<dyn std::error::Error>> {
    Ok(vec![
        ("sphere, even", shapes::geodesic_sphere(24)?),
        ("sphere, poles", shapes::uv_sphere(48, 96)?),
        ("bumps, jittered", damage::jitter(&shapes::bumpy_sphere(24, 0.2, 5.0)?, 0.3, 1)?),
        ("torus, stretched", shapes::torus(1.0, 0.4, 160, 16)?),
        ("genus 2", shapes::chain_of_genus(2, 3)?),
        ("sphere, coarse", damage::jitter(&shapes::geodesic_sphere(5)?, 0.3, 1)?),
    ])
}

/// Semi-axes of the ellipsoid.
const AXES: [f64; 3] = [1.2, 1.0, 0.7];

/// An ellipsoid on meshes that are fine, uneven, stretched and coarse.
fn qualities() -> Result<Vec<Named>, Box<dyn std::error::Error>> {
    Ok(vec![
        ("fine", moved(&shapes::geodesic_sphere(32)?, |p| p)?),
        // Faces near one end are up to four times as wide as near the other.
        ("uneven", moved(&shapes::geodesic_sphere(20)?, |[x, y, z]| [x + 0.5, y, z])?),
        ("stretched", moved(&shapes::uv_sphere(120, 20)?, |p| p)?),
        ("coarse", moved(&shapes::geodesic_sphere(8)?, |p| p)?),
    ])
}

/// Moves the vertices of a sphere, normalises them, and stretches the sphere to the ellipsoid.
fn moved(
    sphere: &TriangleMesh,
    change: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<TriangleMesh, Box<dyn std::error::Error>> {
    let position = |p: &[f64; 3]| {
        let p = change(*p);
        let size = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        [0, 1, 2].map(|k| AXES[k] * p[k] / size)
    };
    Ok(TriangleMesh::new(sphere.positions().iter().map(position).collect(), sphere.triangles().to_vec())?)
}

fn at(u: f64, v: f64) -> [f64; 3] {
    [AXES[0] * u.cos() * v.cos(), AXES[1] * u.sin() * v.cos(), AXES[2] * v.sin()]
}

fn nearest(mesh: &TriangleMesh, bvh: &Bvh, position: [f64; 3]) -> Option<Located> {
    bvh.closest_point(position).map(|closest| closest.locate(mesh))
}

/// The field with eight singularities of index 1/4, at the nearest points of the mesh.
fn of_ellipsoid(mesh: &TriangleMesh) -> Result<PolarField, Box<dyn std::error::Error>> {
    let bvh = Bvh::new(mesh);
    let mut singularities = Vec::new();
    for i in 0..8 {
        let (u, v) = (0.4 + 0.78 * f64::from(i), if i % 2 == 0 { 0.6 } else { -0.5 });
        let place = nearest(mesh, &bvh, at(u, v)).ok_or("the mesh has no faces")?;
        singularities.push(Singularity { place: Place::Point(place.to_surface_point(mesh)), index: 0.25 });
    }
    let solver = Solver::new(mesh, &Default::default())?;
    Ok(solver.solve(&singularities, &FieldOptions::default())?)
}

/// Angle to the direction around the axis, times 4, at a point of the ellipsoid.
fn phase(field: &PolarField, bvh: &Bvh, u: f64, v: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let mesh = field.mesh();
    let place = nearest(mesh, bvh, at(u, v)).ok_or("the mesh has no faces")?;
    let point: SurfacePoint = place.to_surface_point(mesh);
    let d = field.vectors_at(point)?[0];
    // The exact tangent of the circle of latitude, and the direction to the left of it.
    let unit = |v: [f64; 3]| v.map(|x| x / v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
    };
    let p = at(u, v);
    let normal = unit([0, 1, 2].map(|k| p[k] / AXES[k].powi(2)));
    let along = unit([-AXES[0] * u.sin(), AXES[1] * u.cos(), 0.0]);
    let across = cross(normal, along);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    Ok(4.0 * dot(d, across).atan2(dot(d, along)))
}

/// Root mean square and median of the angle between two fields, in degrees.
fn angles(one: &PolarField, other: &PolarField) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let [a, b] = [one, other].map(|field| Bvh::new(field.mesh()));
    let mut differences = Vec::new();
    for i in 0..60 {
        for j in 0..24 {
            let (u, v) =
                (f64::from(i) * std::f64::consts::TAU / 60.0 + 0.01, f64::from(j - 12) * 0.11 + 0.02);
            differences.push(phase(one, &a, u, v)? - phase(other, &b, u, v)?);
        }
    }
    // The common rotation is the direction of the mean.
    let [x, y] = differences.iter().fold([0.0, 0.0], |[x, y], d| [x + d.cos(), y + d.sin()]);
    let common = y.atan2(x);
    let turn = std::f64::consts::TAU;
    let mut angles: Vec<f64> = differences
        .iter()
        .map(|d| (d - common) - turn * ((d - common) / turn).round())
        .map(|phase| (phase / 4.0).to_degrees().abs())
        .collect();
    angles.sort_by(f64::total_cmp);
    let mean = (angles.iter().map(|a| a * a).sum::<f64>() / angles.len() as f64).sqrt();
    Ok([mean, angles[angles.len() / 2]])
}
