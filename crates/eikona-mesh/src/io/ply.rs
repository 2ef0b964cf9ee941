//! Stanford PLY reader: ascii and binary, polygons and triangle strips, all scalar properties of
//! vertices and faces.
//!
//! Own reader: ply-rs-bw makes a hash map of every element, which is about twenty times slower than
//! acceptable for a million triangles. Version 4.0 ignores surplus values on a line without a
//! warning.

use super::MeshFile;
use super::faces::Faces;
use super::names::Names;
use super::ply_header::{Element, Encoding, Header, Kind, PLY, Type};
use super::ply_lines;
use super::text::{decode_text, is_wide};
use super::words::{Words, integer, number, shown, whole};
use crate::error::FileError;
use crate::warning::FileWarning;

/// Reads the mesh of a PLY file. Vertex properties other than x, y, z and face properties other
/// than the vertex list become scalars under their own names; `edge` elements become lines of two
/// nodes; strips become triangles. List properties other than the vertex list, and other elements,
/// are omitted with a warning.
///
/// Elements of ascii files need not begin a line. Data after the declared elements is ignored with
/// a warning.
///
/// # Errors
/// [`FileError::Syntax`] with the line of the header or the element, also if the header declares
/// more than the file contains; [`FileError::Mesh`] with every face that refers to a vertex that
/// does not exist; [`FileError::Unsupported`] for binary data in UTF-16.
pub fn read_ply(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let text = decode_text(bytes);
    let Header { encoding, elements, length, lines } = Header::parse(&text)?;
    let body = text.get(length..).unwrap_or_default();
    if !matches!(encoding, Encoding::Ascii) && is_wide(bytes) {
        return Err(FileError::Unsupported(
            "this binary PLY file was converted to UTF-16, which corrupts its numbers; copy it again from its source"
                .into(),
        ));
    }
    let declared = || {
        let counts: Vec<String> = elements.iter().map(|e| format!("{} {}", e.count, e.name)).collect();
        counts.join(", ")
    };
    match encoding {
        Encoding::Ascii => {
            let mut body_words = AsciiBody { words: Words::new(body) };
            let read = read_body(&elements, &mut body_words);
            let rest = body_words.words.word().map(|_| lines + body_words.words.line());
            if (read.is_err() || rest.is_some())
                && let Some(fault) = ply_lines::misfit(body, lines, &elements)
            {
                return Err(fault);
            }
            let mut file = read?;
            file.warnings.extend(rest.map(|line| FileWarning::TrailingLines { line, declared: declared() }));
            Ok(file)
        }
        Encoding::Binary { big_endian } => {
            let (read, rest) = if big_endian {
                let mut body = BinaryBody::<true> { rest: body };
                (read_body(&elements, &mut body), body.rest)
            } else {
                let mut body = BinaryBody::<false> { rest: body };
                (read_body(&elements, &mut body), body.rest)
            };
            let mut file = read?;
            // Some programs end the file with a line end or pad it with zeros.
            if rest.iter().any(|b| !matches!(b, 0 | b' ' | b'\n' | b'\r')) {
                file.warnings.push(FileWarning::TrailingBytes { bytes: rest.len(), declared: declared() });
            }
            Ok(file)
        }
    }
}

/// Why a value could not be read.
enum Stop {
    Ended,
    Unreadable(String),
}

/// The values after the header, one after the other.
trait Body {
    /// Returns the minimum number of bytes of a value of this type.
    fn least(&self, kind: Type) -> usize;
    fn remaining(&self) -> usize;
    fn float(&mut self, kind: Type) -> Result<f64, Stop>;
    fn integer(&mut self, kind: Type) -> Result<i64, Stop>;
    /// Skips values of this type that are known to fit in the rest.
    fn skip(&mut self, kind: Type, count: usize) -> Result<(), Stop>;

    /// Returns the length of a list whose items fit in the rest.
    fn list_length(&mut self, count: Type, item: Type) -> Result<usize, Stop> {
        let length = self.integer(count)?;
        let length =
            usize::try_from(length).map_err(|_| Stop::Unreadable(format!("a list has length {length}")))?;
        match length.checked_mul(self.least(item)) {
            Some(bytes) if bytes <= self.remaining() => Ok(length),
            _ => Err(Stop::Ended),
        }
    }
}

struct AsciiBody<'a> {
    words: Words<'a>,
}

impl Body for AsciiBody<'_> {
    fn least(&self, _: Type) -> usize {
        1
    }
    fn remaining(&self) -> usize {
        self.words.remaining()
    }
    #[inline]
    fn float(&mut self, _: Type) -> Result<f64, Stop> {
        let word = self.words.word().ok_or(Stop::Ended)?;
        number(word).ok_or_else(|| Stop::Unreadable(format!("{} is not a number", shown(word))))
    }
    #[inline]
    fn integer(&mut self, _: Type) -> Result<i64, Stop> {
        let word = self.words.word().ok_or(Stop::Ended)?;
        integer(word).ok_or_else(|| Stop::Unreadable(format!("{} is not an integer", shown(word))))
    }
    fn skip(&mut self, _: Type, count: usize) -> Result<(), Stop> {
        (0..count).try_for_each(|_| self.words.word().map(|_| ()).ok_or(Stop::Ended))
    }
}

struct BinaryBody<'a, const BIG_ENDIAN: bool> {
    rest: &'a [u8],
}

impl<const BIG_ENDIAN: bool> BinaryBody<'_, BIG_ENDIAN> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let (value, rest) = self.rest.split_first_chunk().ok_or(Stop::Ended)?;
        self.rest = rest;
        let mut value = *value;
        if BIG_ENDIAN {
            value.reverse();
        }
        Ok(value)
    }
}

impl<const BIG_ENDIAN: bool> Body for BinaryBody<'_, BIG_ENDIAN> {
    fn least(&self, kind: Type) -> usize {
        kind.size()
    }
    fn remaining(&self) -> usize {
        self.rest.len()
    }
    #[inline]
    fn float(&mut self, kind: Type) -> Result<f64, Stop> {
        Ok(match kind {
            Type::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Type::F64 => f64::from_le_bytes(self.take()?),
            Type::U64 => u64::from_le_bytes(self.take()?) as f64,
            _ => self.integer(kind)? as f64,
        })
    }
    #[inline]
    fn integer(&mut self, kind: Type) -> Result<i64, Stop> {
        Ok(match kind {
            Type::I8 => i64::from(i8::from_le_bytes(self.take()?)),
            Type::U8 => i64::from(u8::from_le_bytes(self.take()?)),
            Type::I16 => i64::from(i16::from_le_bytes(self.take()?)),
            Type::U16 => i64::from(u16::from_le_bytes(self.take()?)),
            Type::I32 => i64::from(i32::from_le_bytes(self.take()?)),
            Type::U32 => i64::from(u32::from_le_bytes(self.take()?)),
            Type::I64 => i64::from_le_bytes(self.take()?),
            Type::U64 => i64::try_from(u64::from_le_bytes(self.take()?)).unwrap_or(i64::MAX),
            Type::F32 | Type::F64 => {
                let value = self.float(kind)?;
                whole(value).ok_or_else(|| Stop::Unreadable(format!("{value} is not an integer")))?
            }
        })
    }
    fn skip(&mut self, kind: Type, count: usize) -> Result<(), Stop> {
        let bytes = count.checked_mul(kind.size()).ok_or(Stop::Ended)?;
        self.rest = self.rest.get(bytes..).ok_or(Stop::Ended)?;
        Ok(())
    }
}

/// The use of a property.
#[derive(Clone, Copy)]
enum Use {
    Axis(usize),
    /// One of the kept columns.
    Column(usize),
    /// The list of vertices of a face or strip.
    Corners,
    /// An endpoint of an edge.
    End(usize),
    Nothing,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Vertex,
    Face,
    Strips,
    Edge,
    Unknown,
}

/// The values of one element while they are read; reused for each.
#[derive(Default)]
struct Row {
    axes: [f64; 3],
    corners: Vec<i64>,
    ends: [i64; 2],
}

type Columns = Vec<(String, Vec<f64>)>;

fn read_body(elements: &[Element], body: &mut impl Body) -> Result<MeshFile, FileError> {
    let mut file = MeshFile::default();
    let (mut positions, mut faces, mut edges) = (Vec::new(), Faces::default(), Vec::new());
    let (mut has_vertices, mut has_faces) = (false, false);
    for element in elements {
        let role = match element.name.as_str() {
            "vertex" if !has_vertices => Role::Vertex,
            "face" if !has_faces => Role::Face,
            "tristrips" => Role::Strips,
            "edge" => Role::Edge,
            _ => Role::Unknown,
        };
        has_vertices |= role == Role::Vertex;
        has_faces |= role == Role::Face;
        check_size(element, body)?;
        let (uses, mut columns) = plan(element, role, &mut file.warnings)?;
        if element.properties.is_empty() {
            continue;
        }
        let mut row = Row::default();
        let first_face = faces.count();
        let mut stitches = 0;
        for i in 0..element.count {
            read_row(element, &uses, body, &mut columns, &mut row)
                .map_err(|(stop, p)| fault(element, i, p, stop))?;
            match role {
                Role::Vertex => positions.push(row.axes),
                Role::Face => faces.push(&row.corners)?,
                Role::Strips => stitches += faces.push_strip(&row.corners)?,
                Role::Edge => edges.push(row.ends),
                Role::Unknown => {}
            }
        }
        if stitches > 0 {
            file.warnings.push(FileWarning::StripJoints { count: stitches });
        }
        match role {
            Role::Vertex => file.vertex_scalars.extend(columns),
            // Triangles of strips, before and after, have no values.
            Role::Face => file.face_scalars.extend(columns.into_iter().map(|(name, mut values)| {
                values.splice(0..0, std::iter::repeat_n(f64::NAN, first_face));
                (name, values)
            })),
            _ => {}
        }
    }
    if !has_vertices {
        return Err(FileError::syntax(
            PLY,
            "header",
            "it has no element \"vertex\"; check that this is a mesh",
        ));
    }
    let vertices = positions.len();
    for (i, ends) in edges.iter().enumerate() {
        let line = ends.map(|v| u32::try_from(v).ok().filter(|&v| (v as usize) < vertices));
        let [Some(a), Some(b)] = line else {
            let problem = format!(
                "it joins vertices {} and {}, but there are {vertices}, numbered from 0",
                ends[0], ends[1]
            );
            return Err(FileError::syntax(PLY, format!("edge {i}"), problem));
        };
        file.lines.push(vec![a, b]);
    }
    for (_, values) in &mut file.face_scalars {
        values.resize(faces.count(), f64::NAN);
    }
    file.mesh = faces.finish(positions)?;
    Ok(file)
}

/// Fails if the header declares more than the file can contain, before memory is allocated for it.
fn check_size(element: &Element, body: &impl Body) -> Result<(), FileError> {
    let least: usize = element
        .properties
        .iter()
        .map(|p| match p.kind {
            Kind::Scalar(kind) | Kind::List { count: kind, .. } => body.least(kind),
        })
        .sum();
    match element.count.checked_mul(least) {
        Some(bytes) if bytes <= body.remaining() => Ok(()),
        _ => {
            let problem = format!(
                "the header declares {} of them with at least {least} bytes each, but only {} bytes are left; the file is truncated or its header is wrong",
                element.count,
                body.remaining()
            );
            Err(FileError::syntax(PLY, format!("element {}", element.name), problem))
        }
    }
}

/// Returns what each property is used for, and the empty columns of those that are kept as scalars.
fn plan(
    element: &Element,
    role: Role,
    warnings: &mut Vec<FileWarning>,
) -> Result<(Vec<Use>, Columns), FileError> {
    let mut names = Names::default();
    let mut columns: Columns = Vec::new();
    let (mut left_out, mut renamed) = (Vec::new(), Vec::new());
    let uses: Vec<Use> = element
        .properties
        .iter()
        .map(|p| match (role, p.kind, p.name.as_str()) {
            (Role::Vertex, Kind::Scalar(_), "x") => Use::Axis(0),
            (Role::Vertex, Kind::Scalar(_), "y") => Use::Axis(1),
            (Role::Vertex, Kind::Scalar(_), "z") => Use::Axis(2),
            (Role::Face | Role::Strips, Kind::List { .. }, "vertex_indices" | "vertex_index") => Use::Corners,
            (Role::Edge, Kind::Scalar(_), "vertex1") => Use::End(0),
            (Role::Edge, Kind::Scalar(_), "vertex2") => Use::End(1),
            (Role::Vertex | Role::Face, Kind::Scalar(_), _) => {
                let name = names.claim(p.name.clone());
                if name != p.name {
                    renamed.push(name.clone());
                }
                columns.push((name, Vec::new()));
                Use::Column(columns.len() - 1)
            }
            _ => {
                left_out.push(p.name.clone());
                Use::Nothing
            }
        })
        .collect();
    let has = |wanted: fn(&Use) -> bool, number: usize| uses.iter().filter(|u| wanted(u)).count() == number;
    let complete = match role {
        Role::Vertex => {
            [0, 1, 2].iter().all(|k| uses.iter().filter(|u| matches!(u, Use::Axis(a) if a == k)).count() == 1)
        }
        Role::Face | Role::Strips => has(|u| matches!(u, Use::Corners), 1),
        Role::Edge => has(|u| matches!(u, Use::End(0)), 1) && has(|u| matches!(u, Use::End(1)), 1),
        Role::Unknown => true,
    };
    if !complete && element.count > 0 {
        let needed = match role {
            Role::Vertex => "the properties x, y and z, once each",
            Role::Edge => "the properties vertex1 and vertex2, once each",
            _ => "one list property vertex_indices or vertex_index",
        };
        return Err(FileError::syntax(PLY, "header", format!("element {} needs {needed}", element.name)));
    }
    if role == Role::Unknown && element.count > 0 {
        warnings.push(FileWarning::IgnoredElements { element: element.name.clone(), count: element.count });
    } else if !left_out.is_empty() {
        let element = element.name.clone();
        warnings.push(FileWarning::IgnoredFields { element, names: left_out, reason: None });
    }
    if !renamed.is_empty() {
        warnings.push(FileWarning::RenamedFields { element: element.name.clone(), names: renamed });
    }
    // The size has been checked: a column is at most eight times as large as its part of the file.
    columns.iter_mut().for_each(|(_, values)| values.reserve_exact(element.count));
    Ok((uses, columns))
}

/// Reads one element; on a fault, returns the property at which it occurred.
#[inline]
fn read_row(
    element: &Element,
    uses: &[Use],
    body: &mut impl Body,
    columns: &mut Columns,
    row: &mut Row,
) -> Result<(), (Stop, usize)> {
    for (p, (property, target)) in element.properties.iter().zip(uses).enumerate() {
        let at = |stop| (stop, p);
        match (property.kind, *target) {
            (Kind::Scalar(kind), Use::Axis(k)) => row.axes[k] = body.float(kind).map_err(at)?,
            (Kind::Scalar(kind), Use::Column(c)) => columns[c].1.push(body.float(kind).map_err(at)?),
            (Kind::Scalar(kind), Use::End(k)) => row.ends[k] = body.integer(kind).map_err(at)?,
            (Kind::Scalar(kind), _) => body.skip(kind, 1).map_err(at)?,
            (Kind::List { count, item }, target) => {
                let length = body.list_length(count, item).map_err(at)?;
                if let Use::Corners = target {
                    row.corners.clear();
                    for _ in 0..length {
                        row.corners.push(body.integer(item).map_err(at)?);
                    }
                } else {
                    body.skip(item, length).map_err(at)?;
                }
            }
        }
    }
    Ok(())
}

fn fault(element: &Element, index: usize, property: usize, stop: Stop) -> FileError {
    let name = element.properties.get(property).map_or("", |p| p.name.as_str());
    let problem = match stop {
        Stop::Ended => {
            format!(
                "the file ends here, but the header declares {} of them; it is truncated or its header is wrong",
                element.count
            )
        }
        Stop::Unreadable(what) => what,
    };
    FileError::syntax(PLY, format!("{} {index}, property {name}", element.name), problem)
}
