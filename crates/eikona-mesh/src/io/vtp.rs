//! VTK's PolyData as XML, read: ascii, base64 and appended arrays, plain or zlib.

use super::MeshFile;
use super::faces::Faces;
use super::vtp_arrays::{Arrays, VTP, split_appended};
use crate::error::FileError;
use roxmltree::{Document, Node};

/// The mesh of a VTP file: all its pieces, one after the other. Polygons and strips become faces, lines lines; arrays of one
/// component at points and cells become scalars, those of more components one scalar a component (`name_0`, ...). Vertex
/// cells are left out with a warning.
///
/// # Errors
/// [`FileError::Syntax`] with the element, [`FileError::Mesh`] with every face that names a point that does not exist,
/// [`FileError::Unsupported`] for LZ4 and LZMA.
pub fn read_vtp(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let (xml, appended) = split_appended(bytes)?;
    let fault = |problem: String| FileError::syntax(VTP, "XML", problem);
    let document = Document::parse(&xml).map_err(|e| fault(format!("it is not well-formed: {e}")))?;
    let file = document.root_element();
    if file.attribute("type") != Some("PolyData") {
        let found = file.attribute("type").unwrap_or(file.tag_name().name());
        return Err(FileError::Unsupported(format!(
            "the file holds {found}, expected a VTKFile of type PolyData"
        )));
    }
    let arrays = Arrays::new(file, appended)?;
    let mut collected = Collected::default();
    for piece in file.descendants().filter(|n| n.has_tag_name("Piece")) {
        collected.add_piece(&arrays, piece)?;
    }
    collected.finish()
}

type Columns = Vec<(String, Vec<f64>)>;

#[derive(Default)]
struct Collected {
    positions: Vec<[f64; 3]>,
    faces: Faces,
    lines: Vec<Vec<u32>>,
    vertex_scalars: Columns,
    face_scalars: Columns,
    warnings: Vec<String>,
}

fn child<'a, 'i>(piece: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    piece.children().find(|n| n.has_tag_name(tag))
}

/// The cells of one kind: connectivity and where each cell ends in it.
fn cells(arrays: &Arrays, piece: Node, tag: &str) -> Result<(Vec<i64>, Vec<usize>), FileError> {
    let Some(node) = child(piece, tag) else { return Ok(Default::default()) };
    let named = |name: &str| {
        let array =
            node.children().find(|n| n.has_tag_name("DataArray") && n.attribute("Name") == Some(name));
        array.map_or(Ok(Vec::new()), |a| arrays.integers(a))
    };
    let connectivity = named("connectivity")?;
    let mut ends = Vec::new();
    for end in named("offsets")? {
        let before = ends.last().copied().unwrap_or(0);
        match usize::try_from(end) {
            Ok(end) if end >= before && end <= connectivity.len() => ends.push(end),
            _ => {
                let problem = format!(
                    "offset {end} follows {before}; offsets must not decrease nor exceed {}, the length of connectivity",
                    connectivity.len()
                );
                return Err(FileError::syntax(VTP, format!("{tag}, cell {}", ends.len()), problem));
            }
        }
    }
    Ok((connectivity, ends))
}

fn slices<'a>(connectivity: &'a [i64], ends: &'a [usize]) -> impl Iterator<Item = &'a [i64]> {
    let starts = std::iter::once(0).chain(ends.iter().copied());
    starts.zip(ends).map(|(start, &end)| &connectivity[start..end])
}

impl Collected {
    fn add_piece(&mut self, arrays: &Arrays, piece: Node) -> Result<(), FileError> {
        let first_vertex = self.positions.len();
        let first_face = self.faces.count();
        let points = child(piece, "Points").and_then(|p| child(p, "DataArray"));
        let coordinates = points.map_or(Ok(Vec::new()), |array| arrays.floats(array))?;
        if !coordinates.len().is_multiple_of(3) {
            let problem = format!("{} coordinates are not three a point", coordinates.len());
            return Err(FileError::syntax(VTP, "Points", problem));
        }
        self.positions.extend(coordinates.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        let vertices = self.positions.len() - first_vertex;
        let shifted =
            |cell: &[i64]| cell.iter().map(|v| v.saturating_add(first_vertex as i64)).collect::<Vec<_>>();

        let (_, vertex_cells) = cells(arrays, piece, "Verts")?;
        let (connectivity, line_ends) = cells(arrays, piece, "Lines")?;
        for (i, line) in slices(&connectivity, &line_ends).enumerate() {
            if let Some(v) = line.iter().find(|v| !(0..vertices as i64).contains(v)) {
                let problem = format!("it names point {v}, but there are {vertices}, numbered from 0");
                return Err(FileError::syntax(VTP, format!("line {i}"), problem));
            }
            self.lines.push(shifted(line).into_iter().map(|v| v as u32).collect());
        }
        // For each face, its cell among the strips and polygons, which follow vertices and lines.
        let mut cell_of_face = Vec::new();
        let before = vertex_cells.len() + line_ends.len();
        let (connectivity, strip_ends) = cells(arrays, piece, "Strips")?;
        for (i, strip) in slices(&connectivity, &strip_ends).enumerate() {
            self.faces.push_strip(&shifted(strip))?;
            cell_of_face.resize(self.faces.count() - first_face, before + i);
        }
        let (connectivity, poly_ends) = cells(arrays, piece, "Polys")?;
        for (i, polygon) in slices(&connectivity, &poly_ends).enumerate() {
            self.faces.push(&shifted(polygon))?;
            cell_of_face.push(before + strip_ends.len() + i);
        }
        if !vertex_cells.is_empty() {
            self.warnings
                .push(format!("{} vertex cells were left out; their points were kept", vertex_cells.len()));
        }
        let cell_count = before + strip_ends.len() + poly_ends.len();
        for (name, values) in columns(arrays, piece, "PointData", vertices)? {
            append(&mut self.vertex_scalars, name, first_vertex, values);
        }
        for (name, values) in columns(arrays, piece, "CellData", cell_count)? {
            let values = cell_of_face.iter().map(|&cell| values[cell]).collect();
            append(&mut self.face_scalars, name, first_face, values);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<MeshFile, FileError> {
        let (vertices, faces) = (self.positions.len(), self.faces.count());
        for (scalars, count) in [(&mut self.vertex_scalars, vertices), (&mut self.face_scalars, faces)] {
            scalars.iter_mut().for_each(|(_, values)| values.resize(count, f64::NAN));
        }
        Ok(MeshFile {
            mesh: self.faces.finish(self.positions)?,
            lines: self.lines,
            vertex_scalars: self.vertex_scalars,
            face_scalars: self.face_scalars,
            corner_uvs: None,
            warnings: self.warnings,
        })
    }
}

/// Appends the values of one piece; pieces before it that have none get NaN.
fn append(scalars: &mut Columns, name: String, before: usize, values: Vec<f64>) {
    let known = scalars.iter().position(|(n, _)| *n == name);
    let column = known.unwrap_or_else(|| {
        scalars.push((name, Vec::new()));
        scalars.len() - 1
    });
    let column = &mut scalars[column].1;
    column.resize(before, f64::NAN);
    column.extend(values);
}

/// The arrays of a piece at its points or cells, each component by itself.
fn columns(arrays: &Arrays, piece: Node, tag: &str, count: usize) -> Result<Columns, FileError> {
    let mut columns: Columns = Vec::new();
    let Some(data) = child(piece, tag) else { return Ok(columns) };
    for (i, array) in data.children().filter(|n| n.has_tag_name("DataArray")).enumerate() {
        let name = array.attribute("Name").map_or_else(|| format!("array{i}"), str::to_string);
        if array.attribute("type") == Some("String") {
            continue;
        }
        let values = arrays.floats(array)?;
        let components = values.len().checked_div(count).unwrap_or(0);
        if components * count != values.len() {
            let problem = format!("{} values are given for {count} elements", values.len());
            return Err(FileError::syntax(VTP, format!("{tag}, array {name}"), problem));
        }
        for k in 0..components {
            let name = if components == 1 { name.clone() } else { format!("{name}_{k}") };
            if columns.iter().any(|(n, _)| *n == name) {
                return Err(FileError::syntax(
                    VTP,
                    tag,
                    format!("two arrays are named {name}; give each its own name"),
                ));
            }
            columns.push((name, values.iter().skip(k).step_by(components).copied().collect()));
        }
    }
    Ok(columns)
}
