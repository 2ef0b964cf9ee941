//! dump
use eikona_mesh::shapes;
use std::io::Write;
fn npy(path: &str, dtype: &str, shape: (usize, usize), data: &[u8]) {
    let mut h =
        format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({}, {}), }}", shape.0, shape.1);
    while (h.len() + 11) % 64 != 0 {
        h.push(' ');
    }
    h.push('\n');
    let mut f = std::fs::File::create(path).unwrap();
    f.write_all(b"\x93NUMPY\x01\x00").unwrap();
    f.write_all(&(h.len() as u16).to_le_bytes()).unwrap();
    f.write_all(h.as_bytes()).unwrap();
    f.write_all(data).unwrap();
}
fn main() {
    let f: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let m = shapes::geodesic_sphere(f).unwrap();
    let v: Vec<u8> = m.positions().iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let t: Vec<u8> = m.triangles().iter().flatten().flat_map(|x| (*x as i64).to_le_bytes()).collect();
    npy("/tmp/V.npy", "<f8", (m.vertex_count(), 3), &v);
    npy("/tmp/F.npy", "<i8", (m.face_count(), 3), &t);
}
