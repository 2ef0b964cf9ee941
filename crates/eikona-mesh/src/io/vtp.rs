//! VTK XML PolyData reader: ascii, base64 and appended arrays, plain or zlib.
//!
//! Own reader: vtkio 0.6 rejects files with bit or string arrays or padded attributes, and drops
//! the text of an array after a comment.

use super::MeshFile;
use super::faces::Faces;
use super::names::Names;
use super::text::{decode_text, is_wide};
use super::vtp_arrays::{Arrays, VTP, attribute, split_appended};
use crate::error::FileError;
use crate::warning::FileWarning;
use roxmltree::{Document, Node};
use std::collections::HashSet;

/// Reads the mesh of a VTP file: all its pieces, concatenated. Polygons and strips become faces,
/// lines become lines; point and cell arrays with one component become scalars, and those with more
/// components one scalar per component (`name_0`, ...). Vertex cells and non-numeric arrays are
/// omitted with a warning.
///
/// # Errors
/// [`FileError::Syntax`] with the element, [`FileError::Mesh`] with every face that refers to a
/// point that does not exist, [`FileError::Unsupported`] for LZ4 and LZMA.
pub fn read_vtp(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let text = decode_text(bytes);
    let (xml, appended) = split_appended(&text)?;
    let fault = |problem: String| FileError::syntax(VTP, "XML", problem);
    let document = Document::parse(&xml).map_err(|e| fault(format!("it is not well-formed: {e}")))?;
    let file = document.root_element();
    if attribute(file, "type") != Some("PolyData") {
        let found = attribute(file, "type").unwrap_or(file.tag_name().name());
        return Err(FileError::Unsupported(format!(
            "the file contains {found}, expected a VTKFile of type PolyData"
        )));
    }
    let arrays = Arrays::new(file, appended)?;
    if is_wide(bytes) && arrays.has_raw_data() {
        return Err(FileError::Unsupported(
            "this VTP file was converted to UTF-16, which corrupts its raw data; copy it again from its source".into(),
        ));
    }
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
    vertex_cells: usize,
    /// Warnings, once for all pieces: arrays omitted or renamed, counts that differ from the
    /// declared ones.
    odd: Distinct,
}

/// Warnings without repetitions.
#[derive(Default)]
struct Distinct {
    warnings: Vec<FileWarning>,
    sentences: HashSet<String>,
}

impl Distinct {
    fn insert(&mut self, warning: FileWarning) {
        if self.sentences.insert(warning.to_string()) {
            self.warnings.push(warning);
        }
    }
}

fn child<'a, 'i>(piece: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    piece.children().find(|n| n.has_tag_name(tag))
}

/// Returns the cells of one kind: connectivity and the end of each cell in it.
fn cells(arrays: &Arrays, piece: Node, tag: &str) -> Result<(Vec<i64>, Vec<usize>), FileError> {
    let Some(node) = child(piece, tag) else { return Ok(Default::default()) };
    let named = |name: &str| {
        let array =
            node.children().find(|n| n.has_tag_name("DataArray") && attribute(*n, "Name") == Some(name));
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
                    "offset {end} follows {before}; offsets must not decrease or exceed {}, the length of connectivity",
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
            let problem = format!("{} coordinates are not a multiple of three", coordinates.len());
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
                let problem = format!("point {v} does not exist: there are {vertices}, numbered from 0");
                return Err(FileError::syntax(VTP, format!("line {i}"), problem));
            }
            self.lines.push(shifted(line).into_iter().map(|v| v as u32).collect());
        }
        // The cell of each face among the polygons and strips, which follow vertices and lines.
        let mut cell_of_face = Vec::new();
        let before = vertex_cells.len() + line_ends.len();
        let (connectivity, poly_ends) = cells(arrays, piece, "Polys")?;
        for (i, polygon) in slices(&connectivity, &poly_ends).enumerate() {
            self.faces.push(&shifted(polygon))?;
            cell_of_face.push(before + i);
        }
        let (connectivity, strip_ends) = cells(arrays, piece, "Strips")?;
        for (i, strip) in slices(&connectivity, &strip_ends).enumerate() {
            self.faces.push_strip(&shifted(strip))?;
            cell_of_face.resize(self.faces.count() - first_face, before + poly_ends.len() + i);
        }
        self.vertex_cells += vertex_cells.len();
        for (what, found) in [
            ("Points", vertices),
            ("Verts", vertex_cells.len()),
            ("Lines", line_ends.len()),
            ("Strips", strip_ends.len()),
            ("Polys", poly_ends.len()),
        ] {
            let declared = attribute(piece, &format!("NumberOf{what}"));
            if declared.and_then(|n| n.parse::<usize>().ok()).is_some_and(|n| n != found) {
                let declared = declared.unwrap_or_default().to_string();
                self.odd.insert(FileWarning::CellCount { cells: what, declared, found });
            }
        }
        let cell_count = before + strip_ends.len() + poly_ends.len();
        for (name, values) in columns(arrays, piece, "PointData", vertices, &mut self.odd)? {
            append(&mut self.vertex_scalars, name, first_vertex, values);
        }
        for (name, values) in columns(arrays, piece, "CellData", cell_count, &mut self.odd)? {
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
        let mut warnings = Vec::new();
        if self.vertex_cells > 0 {
            warnings.push(FileWarning::VertexCells { count: self.vertex_cells });
        }
        warnings.extend(self.odd.warnings);
        Ok(MeshFile {
            mesh: self.faces.finish(self.positions)?,
            points: Vec::new(),
            lines: self.lines,
            vertex_scalars: self.vertex_scalars,
            face_scalars: self.face_scalars,
            corner_uvs: None,
            warnings,
        })
    }
}

/// Appends the values of one piece; earlier pieces without them get NaN.
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

/// Returns the arrays of a piece at its points or cells, one column per component. Arrays that can
/// not be read are omitted with a warning; repeated names are numbered.
fn columns(
    arrays: &Arrays,
    piece: Node,
    tag: &str,
    count: usize,
    odd: &mut Distinct,
) -> Result<Columns, FileError> {
    let mut columns: Columns = Vec::new();
    let mut names = Names::default();
    let Some(data) = child(piece, tag) else { return Ok(columns) };
    let is_array = |n: &Node| n.has_tag_name("DataArray") || n.has_tag_name("Array");
    for (i, array) in data.children().filter(is_array).enumerate() {
        let name = array.attribute("Name").map_or_else(|| format!("array{i}"), str::to_string);
        let mut left_out = |reason: String| {
            let (element, names) = (tag.to_string(), vec![name.clone()]);
            odd.insert(FileWarning::IgnoredFields { element, names, reason: Some(reason) });
        };
        if !Arrays::is_numeric(array) {
            left_out(format!("its type is {}", attribute(array, "type").unwrap_or("unknown")));
            continue;
        }
        let mut values = arrays.floats(array)?;
        let declared: Option<usize> = attribute(array, "NumberOfComponents").and_then(|n| n.parse().ok());
        if attribute(array, "type") == Some("Bit") {
            // Drop the padding of the last byte.
            values.truncate(declared.unwrap_or(1).saturating_mul(count));
        }
        let components = values.len().checked_div(count).unwrap_or(0);
        if components * count != values.len() {
            left_out(format!("it has {} values for {count} elements", values.len()));
            continue;
        }
        for k in 0..components {
            let wanted = if components == 1 { name.clone() } else { format!("{name}_{k}") };
            let free = names.claim(wanted.clone());
            if free != wanted {
                odd.insert(FileWarning::RenamedFields {
                    element: tag.to_string(),
                    names: vec![free.clone()],
                });
            }
            columns.push((free, values.iter().skip(k).step_by(components).copied().collect()));
        }
    }
    Ok(columns)
}
