//! VTK XML PolyData writer.

use super::MeshOut;
use super::base64;
use std::io::{self, Write};

/// Writes points, lines and polygons with point and cell data, each array inline as base64: unlike
/// appended raw bytes, that is XML which any XML reader accepts. VTK numbers lines before polygons,
/// so every cell array begins with one NaN per line.
pub(super) fn write_vtp(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let (points, lines, polys) = (mesh.positions().len(), mesh.lines.len(), mesh.face_count());
    writeln!(
        out,
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData>
<Piece NumberOfPoints="{points}" NumberOfVerts="0" NumberOfLines="{lines}" NumberOfStrips="0" NumberOfPolys="{polys}">"#
    )?;
    let first = |scalars: &[(&str, &[f64])]| match scalars.first() {
        Some((name, _)) => format!(" Scalars=\"{}\"", escaped(name)),
        None => String::new(),
    };
    writeln!(out, "<PointData{}>", first(&mesh.vertex_scalars))?;
    for (name, values) in &mesh.vertex_scalars {
        array(out, "Float64", name, 1, values.iter().flat_map(|x| x.to_le_bytes()))?;
    }
    if let Some(colours) = mesh.vertex_colours {
        array(out, "UInt8", "RGB", 3, colours.iter().flatten().copied())?;
    }
    writeln!(out, "</PointData>\n<CellData{}>", first(&mesh.face_scalars))?;
    for (name, values) in &mesh.face_scalars {
        let values = std::iter::repeat_n(&f64::NAN, lines).chain(values.iter());
        array(out, "Float64", name, 1, values.flat_map(|x| x.to_le_bytes()))?;
    }
    for (name, vectors) in &mesh.face_vectors {
        let values = std::iter::repeat_n(&[f64::NAN; 3], lines).chain(vectors.iter());
        array(out, "Float64", name, 3, values.flatten().flat_map(|x| x.to_le_bytes()))?;
    }
    writeln!(out, "</CellData>\n<Points>")?;
    array(out, "Float64", "Points", 3, mesh.positions().iter().flatten().flat_map(|x| x.to_le_bytes()))?;
    writeln!(out, "</Points>")?;
    cells(out, "Lines", || mesh.lines.iter().map(Vec::as_slice))?;
    cells(out, "Polys", || mesh.faces())?;
    writeln!(out, "</Piece>\n</PolyData>\n</VTKFile>")
}

fn cells<'a, I: Iterator<Item = &'a [u32]>>(
    out: &mut dyn Write,
    tag: &str,
    cells: impl Fn() -> I,
) -> io::Result<()> {
    writeln!(out, "<{tag}>")?;
    array(out, "Int64", "connectivity", 1, cells().flatten().flat_map(|&v| i64::from(v).to_le_bytes()))?;
    let ends = cells().scan(0i64, |end, cell| {
        *end += cell.len() as i64;
        Some(*end)
    });
    array(out, "Int64", "offsets", 1, ends.flat_map(i64::to_le_bytes))?;
    writeln!(out, "</{tag}>")
}

fn array(
    out: &mut dyn Write,
    kind: &str,
    name: &str,
    components: usize,
    values: impl Iterator<Item = u8>,
) -> io::Result<()> {
    let mut bytes = vec![0; 8];
    bytes.extend(values);
    let length = (bytes.len() - 8) as u64;
    bytes[..8].copy_from_slice(&length.to_le_bytes());
    let name = escaped(name);
    writeln!(
        out,
        r#"<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="binary">"#
    )?;
    out.write_all(base64::encode(&bytes).as_bytes())?;
    writeln!(out, "\n</DataArray>")
}

/// Escapes a name for an attribute. XML allows `>` there, but VTK takes it for the end of the tag.
fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\'' => text.push_str("&apos;"),
            // XML 1.0 can not represent most of them.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => text.push('_'),
            c => text.push(c),
        }
    }
    text
}
