//! Triangulation of polygons that are not convex, not planar, or touch or cross themselves.
//! (reports.md F2, F22)

mod broken;
mod data_files;
mod files;
mod holes;
mod random;
mod shapes;
mod sizes;

use eikona_mesh::{Face, MeshError, PolygonMesh, Vertex};

type Point = [f64; 3];

fn flat(points: &[[f64; 2]]) -> Vec<Point> {
    points.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

/// Returns a mesh with one polygon through all vertices.
fn polygon(points: Vec<Point>) -> PolygonMesh {
    let n = points.len() as u32;
    let mut mesh = PolygonMesh::new(points);
    mesh.push_face(0..n);
    mesh
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// Returns the area vector of a closed polygon: half the sum of cross products of successive
/// corners.
fn area_vector(corners: &[Point]) -> Point {
    let n = corners.len();
    let origin = corners[0];
    let mut sum = [0.0; 3];
    for k in 0..n {
        let part = cross(minus(corners[k], origin), minus(corners[(k + 1) % n], origin));
        (0..3).for_each(|i| sum[i] += 0.5 * part[i]);
    }
    sum
}

fn corners_of(mesh: &PolygonMesh, f: usize) -> Vec<Point> {
    mesh.face(f).iter().map(|&v| mesh.positions[v as usize]).collect()
}

/// Returns the triangles of each polygon.
fn triangles_of(mesh: &PolygonMesh) -> Result<Vec<Vec<[u32; 3]>>, MeshError> {
    let (triangles, provenance) = mesh.triangulate()?;
    let parts = provenance.push_faces(&triangles.triangles().to_vec().into(), |_, parts| parts.to_vec())?;
    Ok(parts.into_vec())
}

/// Checks that polygon 0 is covered without a fold: `count` triangles, all oriented like the
/// polygon, whose areas sum to `area`. Returns the triangles.
#[track_caller]
fn covered(mesh: &PolygonMesh, count: usize, area: f64) -> Vec<[u32; 3]> {
    let triangles = triangles_of(mesh).unwrap().swap_remove(0);
    assert_eq!(triangles.len(), count, "{triangles:?}");
    let normal = area_vector(&corners_of(mesh, 0));
    let unit = normal.map(|x| x / norm(normal));
    let mut sum = 0.0;
    for &t in &triangles {
        let part = dot(area_vector(&t.map(|v| mesh.positions[v as usize])), unit);
        assert!(part > 0.0, "{t:?} of {triangles:?} has area {part}");
        sum += part;
    }
    assert!((sum - area).abs() <= 1e-9 * area, "area {sum} instead of {area}");
    triangles
}

/// Returns whether the triangle mesh of the polygon is a disk: each edge of the polygon has one
/// triangle, each other edge two. Keyholes count by corner, so give them one vertex per corner.
fn is_disk(mesh: &PolygonMesh) -> bool {
    let (triangles, _) = mesh.triangulate().unwrap();
    let n = mesh.face(0).len();
    let boundary = (0..n).all(|k| {
        let [a, b] = [k, (k + 1) % n].map(|k| Vertex(mesh.face(0)[k]));
        triangles.find_edge(a, b).is_some_and(|e| triangles.is_boundary_edge(e))
    });
    boundary && triangles.edges().filter(|e| triangles.edge_halfedges(*e).len() == 2).count() == n - 3
}
