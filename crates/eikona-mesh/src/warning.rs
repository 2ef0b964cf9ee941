//! Warnings of readers and writers, as data.

use crate::io::MeshFormat;
use crate::wording::counted;
use serde::Serialize;
use std::fmt;

/// Something that a reader or writer ignored, changed or could not store. The file was read or
/// written nevertheless.
///
/// [`Display`](fmt::Display) gives a sentence for the user. Serialized, a warning is an object with
/// its [`kind`](FileWarning::kind) and its fields.
///
/// ```
/// use eikona_mesh::FileWarning;
/// let warning = FileWarning::IgnoredElements { element: "material".into(), count: 3 };
/// assert_eq!(warning.kind(), "ignored_elements");
/// assert_eq!(warning.to_string(), "3 elements \"material\" were ignored");
/// assert_eq!(
///     serde_json::to_string(&warning)?,
///     r#"{"kind":"ignored_elements","element":"material","count":3}"#
/// );
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, strum::IntoStaticStr)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum FileWarning {
    /// The content is in another format than the name suggests; the content decided.
    MisnamedFile {
        /// Format of the name.
        named: MeshFormat,
        /// Format of the content.
        read: MeshFormat,
    },
    /// More content than the header declares, in a text file; it was ignored.
    TrailingLines {
        /// The first line of it, from 1.
        line: usize,
        /// What the header declares.
        declared: String,
    },
    /// More bytes than the header declares, in a binary file; they were ignored.
    TrailingBytes {
        /// Number of bytes.
        bytes: usize,
        /// What the header declares.
        declared: String,
    },
    /// The header of an STL file declares another number of facets; all were read.
    FacetCount {
        /// Number in the header.
        declared: usize,
        /// Number in the file.
        found: usize,
    },
    /// A VTP file declares another number of cells; all were read.
    CellCount {
        /// Kind of cells.
        cells: &'static str,
        /// Number in the header.
        declared: String,
        /// Number in the file.
        found: usize,
    },
    /// The final keyword is missing; the file may be truncated.
    MissingEnd {
        /// The keyword.
        keyword: &'static str,
    },
    /// A line ends with a backslash, but was not joined with the next.
    UnjoinedLine {
        /// Its number, from 1.
        line: usize,
    },
    /// The file contains no mesh.
    NoMesh,
    /// Unknown elements that were ignored.
    IgnoredElements {
        /// Name of the element.
        element: String,
        /// Their number.
        count: usize,
    },
    /// Properties or arrays that were ignored.
    IgnoredFields {
        /// Name of the element that they belong to.
        element: String,
        /// Their names.
        names: Vec<String>,
        /// Why, if that is not obvious.
        reason: Option<String>,
    },
    /// Fields of the same name; all but the first were renamed.
    RenamedFields {
        /// Name of the element that they belong to.
        element: String,
        /// Their new names.
        names: Vec<String>,
    },
    /// A field without values at some vertices; it is NaN there.
    MissingValues {
        /// Name of the field.
        field: String,
        /// Number of vertices without a value, if known.
        count: Option<usize>,
    },
    /// Degenerate triangles that join strips; they were omitted.
    StripJoints {
        /// Number of these triangles.
        count: usize,
    },
    /// Cells that are single vertices; they were ignored.
    VertexCells {
        /// Number of these cells.
        count: usize,
    },
    /// Skinned meshes, read as stored.
    SkinnedMeshes {
        /// Number of these meshes.
        count: usize,
        /// The first node with one.
        first_node: usize,
    },
    /// Morph targets that were ignored.
    MorphTargets {
        /// Number of meshes with morph targets.
        count: usize,
        /// The first of them.
        first_mesh: usize,
    },
    /// Instances of meshes that were ignored.
    Instances {
        /// Number of nodes with instances.
        count: usize,
        /// The first of them.
        first_node: usize,
    },
    /// Faces whose corners coincide because coordinates were rounded to 32-bit floats.
    LostDigits {
        /// Number of these faces.
        faces: usize,
        /// Number of all faces.
        of: usize,
        /// Distance between neighbouring floats at the largest coordinate.
        spacing: f64,
        /// Largest absolute coordinate.
        reach: f64,
    },

    /// The format cannot store something.
    NotStored {
        /// The format.
        format: MeshFormat,
        /// What was left out.
        what: String,
    },
    /// 32-bit floats change coordinates noticeably.
    RoundedCoordinates {
        /// The format.
        format: MeshFormat,
        /// Largest change.
        change: f64,
        /// Length of the shortest edge.
        shortest_edge: f64,
        /// Number of positions that then coincide with others.
        collapsed: usize,
        /// Number of all positions.
        of: usize,
    },

    /// A curve file without curves.
    NoCurve {
        /// Kind of lines that is missing.
        missing: &'static str,
    },
    /// Lines of two vertices that were opposite to their curve; they were reversed.
    ReversedLines {
        /// Number of these lines.
        count: usize,
    },
    /// Single points in space that were skipped.
    SkippedPoints {
        /// Number of these points.
        count: usize,
    },
    /// A curve with fewer than two nodes; it was skipped.
    ShortCurve {
        /// Line of the file, from 1.
        line: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// A segment of length 0; it was skipped.
    EmptySegment {
        /// Line of the file, from 1.
        line: usize,
        /// Index of its second node, as written in the file.
        node: i64,
    },
}

impl FileWarning {
    /// Returns the stable name of the kind of warning: its variant in snake case.
    pub fn kind(&self) -> &'static str {
        self.into()
    }
}

impl fmt::Display for FileWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use FileWarning::*;
        match self {
            MisnamedFile { named, read } => {
                let (named, read) = (named.name(), read.name());
                write!(f, "the file name suggests {named}, but the content is {read}; it was read as {read}")
            }
            TrailingLines { line, declared } => write!(
                f,
                "there is more content from line {line} on than the header declares ({declared}); it was ignored"
            ),
            TrailingBytes { bytes, declared } => write!(
                f,
                "there are {bytes} bytes more than the header declares ({declared}); they were ignored"
            ),
            FacetCount { declared, found } => write!(
                f,
                "the header declares {declared} facets, but the file contains {found}; all were read"
            ),
            CellCount { cells, declared, found } => {
                write!(f, "NumberOf{cells} is {declared}, but the file contains {found}; these were read")
            }
            MissingEnd { keyword } => {
                write!(f, "\"{keyword}\" is missing at the end of the file; it may be truncated")
            }
            UnjoinedLine { line } => write!(
                f,
                "line {line} ends with a backslash, but the next line begins a statement; such lines were not \
                 joined"
            ),
            NoMesh => write!(f, "the scene contains no mesh"),
            IgnoredElements { element, count: 1 } => write!(f, "1 element \"{element}\" was ignored"),
            IgnoredElements { element, count } => write!(f, "{count} elements \"{element}\" were ignored"),
            IgnoredFields { element, names, reason } => {
                write!(f, "fields of \"{element}\" were ignored: {}", names.join(", "))?;
                match reason {
                    Some(reason) => write!(f, " ({reason})"),
                    None => Ok(()),
                }
            }
            RenamedFields { element, names } => write!(
                f,
                "several fields of \"{element}\" have the same name; the later ones were renamed to {}",
                names.join(", ")
            ),
            MissingValues { field, count: Some(count) } => {
                write!(f, "{} no {field}; it is NaN there", counted(*count, "vertex has", "vertices have"))
            }
            MissingValues { field, count: None } => {
                write!(f, "some vertices have no {field}; it is NaN there")
            }
            StripJoints { count } => {
                let triangles = counted(*count, "degenerate triangle", "degenerate triangles");
                write!(f, "omitted {triangles} joining strips")
            }
            VertexCells { count } => {
                let cells = counted(*count, "vertex cell", "vertex cells");
                write!(f, "ignored {cells}; their points were kept")
            }
            SkinnedMeshes { count, first_node } => write!(
                f,
                "read {} as stored (first: node {first_node}): the joints are ignored and, as the specification \
                 requires, so is the transform of the node",
                counted(*count, "skinned mesh", "skinned meshes")
            ),
            MorphTargets { count, first_mesh } => {
                let meshes = counted(*count, "mesh", "meshes");
                write!(f, "the morph targets of {meshes} (first: mesh {first_mesh}) were ignored")
            }
            Instances { count, first_node } => write!(
                f,
                "ignored the mesh instances of {} (first: node {first_node})",
                counted(*count, "node", "nodes")
            ),
            LostDigits { faces, of, spacing, reach } => write!(
                f,
                "{faces} of {of} faces have coincident corners; the coordinates are 32-bit floats, which are \
                 {spacing} apart at {reach:.1e}, so the file seems to have lost digits; export it with 64-bit \
                 floats, or from closer to the origin"
            ),
            NotStored { format, what } => {
                write!(f, "{} cannot store {what}; left out", format.name())
            }
            RoundedCoordinates { format, change, shortest_edge, collapsed, of } => {
                write!(
                    f,
                    "the 32-bit floats of {} change coordinates by up to {change:.1e}, while the shortest edge is \
                     {shortest_edge:.1e}",
                    format.name()
                )?;
                if *collapsed > 0 {
                    let coincide = if *collapsed == 1 { "coincides" } else { "coincide" };
                    write!(f, "; {collapsed} of {of} positions then {coincide} with others")?;
                }
                write!(f, "; write .ply, .vtp, .obj or .off, or move the mesh closer to the origin")
            }
            NoCurve { missing } => {
                write!(f, "the file has no {missing} lines, so it contains no curve")
            }
            ReversedLines { count } => write!(
                f,
                "{count} two-vertex l lines were opposite to the direction of their curve and were reversed; \
                 check the direction"
            ),
            SkippedPoints { count } => write!(
                f,
                "{count} single points in space were skipped; give points on the mesh by vertex, edge or face"
            ),
            ShortCurve { line, nodes } => write!(
                f,
                "line {line}: a curve with {nodes} node(s) was skipped, since it needs at least 2; use \
                 unsigned_point for isolated points"
            ),
            EmptySegment { line, node } => {
                write!(f, "line {line}: the segment to node {node} was skipped, since it has length 0")
            }
        }
    }
}
