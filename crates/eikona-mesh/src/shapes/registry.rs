//! Shapes by name, for the command line: their descriptions, their parameters, and their
//! construction from text.

use super::parameter::{refuse, require, require_length};
use super::*;
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use crate::vector::scale;

/// A parameter of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The name.
    pub name: &'static str,
    /// The default value, as text.
    pub default: &'static str,
    /// The meaning, in a few words.
    pub meaning: &'static str,
}

/// A shape and its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShapeDescription {
    /// The name for [`make`].
    pub name: &'static str,
    /// A one-line description.
    pub summary: &'static str,
    /// The parameters.
    pub parameters: &'static [Parameter],
}

/// Returns the names of all shapes, by family.
pub fn shape_names() -> impl ExactSizeIterator<Item = &'static str> {
    SHAPES.iter().map(|s| s.description.name)
}

/// Returns the descriptions of all shapes that [`make`] accepts, by family.
pub fn shape_descriptions() -> impl ExactSizeIterator<Item = &'static ShapeDescription> {
    SHAPES.iter().map(|s| &s.description)
}

/// Makes the shape of this name with these parameters, and defaults for the others. A hyphen in a
/// name counts as an underscore.
///
/// # Errors
/// [`MeshError::UnknownName`] for a shape or a parameter that does not exist, with the existing
/// ones, the most similar first; [`MeshError::Parameter`] for a value that can not be parsed, is
/// given twice, or is out of range for the shape.
///
/// ```
/// use eikona_mesh::shapes::make;
/// let torus = make("torus", &[("nu", "30"), ("nv", "10")])?;
/// assert_eq!(torus.face_count(), 600);
/// let message = make("tours", &[]).unwrap_err().to_string();
/// assert!(message.contains("torus, "), "{message}");
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn make(name: &str, values: &[(&str, &str)]) -> Result<TriangleMesh, MeshError> {
    let wanted = name.replace('-', "_");
    let Some(shape) = SHAPES.iter().find(|s| s.description.name == wanted) else {
        return Err(unknown("shape", name, shape_names()));
    };
    let parameters = shape.description.parameters;
    let mut chosen: Vec<(&'static str, &str)> = Vec::new();
    for &(key, value) in values {
        let wanted = key.replace('-', "_");
        let Some(parameter) = parameters.iter().find(|p| p.name == wanted) else {
            return Err(unknown("parameter", key, parameters.iter().map(|p| p.name)));
        };
        let again = chosen.iter().any(|c| c.0 == parameter.name);
        require(!again, parameter.name, value, "it is given twice; give it once")?;
        chosen.push((parameter.name, value));
    }
    for p in parameters {
        if !chosen.iter().any(|c| c.0 == p.name) {
            chosen.push((p.name, p.default));
        }
    }
    (shape.make)(&Values(chosen))
}

fn unknown(what: &'static str, name: &str, known: impl Iterator<Item = &'static str>) -> MeshError {
    let mut known: Vec<&'static str> = known.collect();
    known.sort_by_key(|k| edit_distance(name, k));
    MeshError::UnknownName { what, name: name.to_string(), known }
}

/// Returns the number of letters to insert, delete, replace, or swap with the next one to turn one
/// word into the other.
fn edit_distance(a: &str, b: &str) -> usize {
    // Names are short; letters beyond the length of any of them are ignored.
    let letters = |s: &str| s.chars().take(64).map(|c| c.to_ascii_lowercase()).collect::<Vec<char>>();
    let (a, b) = (letters(a), letters(b));
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

/// The value of every parameter of a shape, as text.
struct Values<'a>(Vec<(&'static str, &'a str)>);

impl Values<'_> {
    fn text(&self, name: &'static str) -> Result<&str, MeshError> {
        let known = || self.0.iter().map(|v| v.0);
        self.0.iter().find(|v| v.0 == name).map(|v| v.1).ok_or_else(|| unknown("parameter", name, known()))
    }

    fn count(&self, name: &'static str) -> Result<usize, MeshError> {
        let text = self.text(name)?;
        text.trim().parse().or_else(|_| refuse(name, text, "it must be an integer of 0 or more"))
    }

    fn levels(&self, name: &'static str) -> Result<u32, MeshError> {
        let text = self.text(name)?;
        text.trim().parse().or_else(|_| refuse(name, text, "it must be an integer of 0 or more"))
    }

    fn real(&self, name: &'static str) -> Result<f64, MeshError> {
        let text = self.text(name)?;
        match text.trim().parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => refuse(name, text, "it must be a finite number"),
        }
    }

    fn diagonal(&self) -> Result<Diagonal, MeshError> {
        match self.text("diagonal")? {
            "uniform" => Ok(Diagonal::Uniform),
            "alternating" => Ok(Diagonal::Alternating),
            "shorter" => Ok(Diagonal::Shorter),
            other => refuse("diagonal", other, "it must be uniform, alternating or shorter"),
        }
    }

    fn ends(&self) -> Result<Ends, MeshError> {
        match self.text("ends")? {
            "open" => Ok(Ends::Open),
            "capped" => Ok(Ends::Capped),
            other => refuse("ends", other, "it must be open or capped"),
        }
    }

    fn tunnel_knot(&self) -> Result<TunnelKnot, MeshError> {
        match self.text("knot")?.replace('-', "_").as_str() {
            "trefoil" => Ok(TunnelKnot::Trefoil),
            "figure_eight" => Ok(TunnelKnot::FigureEight),
            other => refuse("knot", other, "it must be trefoil or figure_eight"),
        }
    }

    /// Scales the mesh about the origin by the parameter `radius`.
    fn with_radius(&self, mesh: TriangleMesh) -> Result<TriangleMesh, MeshError> {
        let radius = self.real("radius")?;
        require_length("radius", radius)?;
        mesh.with_positions(mesh.positions().iter().map(|&p| scale(p, radius)).collect())
    }

    /// Returns `across` x `up` round holes of this radius, evenly spaced over the plate.
    fn holes(&self, width: f64, height: f64) -> Result<Vec<Hole>, MeshError> {
        let (across, up) = (self.count("holes_x")?, self.count("holes_y")?);
        let radius = self.real("hole_radius")?;
        let few = across.saturating_mul(up) <= 10_000;
        require(few, "holes_x", across, "there can be at most 10,000 holes")?;
        let place = |i: usize, n: usize, length: f64| length * (i as f64 + 0.5) / n as f64;
        let centre = |i, j| [place(i, across, width), place(j, up, height)];
        Ok((0..across)
            .flat_map(|i| (0..up).map(move |j| Hole::Disk { centre: centre(i, j), radius }))
            .collect())
    }
}

struct Shape {
    description: ShapeDescription,
    make: fn(&Values) -> Result<TriangleMesh, MeshError>,
}

const fn shape(
    name: &'static str,
    summary: &'static str,
    parameters: &'static [Parameter],
    make: fn(&Values) -> Result<TriangleMesh, MeshError>,
) -> Shape {
    Shape { description: ShapeDescription { name, summary, parameters }, make }
}

const fn p(name: &'static str, default: &'static str, meaning: &'static str) -> Parameter {
    Parameter { name, default, meaning }
}

const RADIUS: Parameter = p("radius", "1", "distance of the vertices from the centre");
const DIAGONAL: Parameter = p("diagonal", "uniform", "how quads are cut: uniform, alternating or shorter");

static SHAPES: &[Shape] = &[
    shape(
        "geodesic_sphere",
        "sphere from an icosahedron, 20 n² nearly equal triangles",
        &[p("frequency", "20", "subdivisions of each edge of the icosahedron"), RADIUS],
        |v| v.with_radius(geodesic_sphere(v.count("frequency")?)?),
    ),
    shape(
        "icosphere",
        "sphere from an icosahedron by repeated edge bisection, 20 · 4^k triangles",
        &[p("levels", "4", "number of bisection steps"), RADIUS],
        |v| v.with_radius(icosphere(v.levels("levels")?)?),
    ),
    shape(
        "uv_sphere",
        "sphere from meridians and parallels",
        &[
            p("meridians", "64", "half circles from pole to pole"),
            p("parallels", "31", "circles between the poles"),
            RADIUS,
        ],
        |v| v.with_radius(uv_sphere(v.count("meridians")?, v.count("parallels")?)?),
    ),
    shape(
        "cube_sphere",
        "sphere from a cube, without poles",
        &[p("n", "20", "quads along an edge of the cube"), RADIUS],
        |v| v.with_radius(cube_sphere(v.count("n")?)?),
    ),
    shape(
        "bumpy_sphere",
        "sphere with smooth waves",
        &[
            p("frequency", "40", "as for geodesic_sphere"),
            p("amplitude", "0.35", "height of the waves, 0 to 0.9"),
            p("waves", "6", "waves along an axis, in radians per unit"),
        ],
        |v| bumpy_sphere(v.count("frequency")?, v.real("amplitude")?, v.real("waves")?),
    ),
    shape("tetrahedron", "4 faces, vertices on a sphere", &[RADIUS], |v| v.with_radius(tetrahedron()?)),
    shape("octahedron", "8 faces, vertices on a sphere", &[RADIUS], |v| v.with_radius(octahedron()?)),
    shape("icosahedron", "20 faces, vertices on a sphere", &[RADIUS], |v| v.with_radius(icosahedron()?)),
    shape(
        "cuboid",
        "box with its sides subdivided into quads",
        &[
            p("width", "1", "length along x"),
            p("depth", "1", "length along y"),
            p("height", "1", "length along z"),
            p("nx", "10", "cells along x"),
            p("ny", "10", "cells along y"),
            p("nz", "10", "cells along z"),
        ],
        |v| {
            cuboid(
                [v.real("width")?, v.real("depth")?, v.real("height")?],
                [v.count("nx")?, v.count("ny")?, v.count("nz")?],
            )
        },
    ),
    shape(
        "torus",
        "torus about the z axis",
        &[
            p("major", "1", "radius of the circle that the tube follows"),
            p("minor", "0.4", "radius of the tube"),
            p("nu", "80", "vertices around the axis"),
            p("nv", "32", "vertices around the tube"),
        ],
        |v| torus(v.real("major")?, v.real("minor")?, v.count("nu")?, v.count("nv")?),
    ),
    shape(
        "punctured_torus",
        "torus about the z axis with a hole in its side",
        &[
            p("major", "1", "radius of the circle that the tube follows"),
            p("minor", "0.4", "radius of the tube"),
            p("hole", "0.5", "width of the hole"),
            p("nu", "80", "vertices around the axis"),
            p("nv", "32", "vertices around the tube"),
        ],
        |v| {
            let [major, minor, hole] = [v.real("major")?, v.real("minor")?, v.real("hole")?];
            punctured_torus(major, minor, hole, v.count("nu")?, v.count("nv")?)
        },
    ),
    shape(
        "cylinder",
        "cylinder about the z axis, open or capped",
        &[
            p("radius", "0.5", "radius"),
            p("height", "2", "length along z"),
            p("sectors", "48", "vertices around the axis"),
            p("stacks", "30", "bands along z"),
            p("ends", "capped", "open or capped"),
        ],
        |v| {
            cylinder(v.real("radius")?, v.real("height")?, v.count("sectors")?, v.count("stacks")?, v.ends()?)
        },
    ),
    shape(
        "cone",
        "side of a cone about the z axis, open at its base",
        &[
            p("radius", "1", "radius of the base"),
            p("height", "1.5", "height of the apex"),
            p("rings", "20", "rings of vertices around the apex"),
            p("sectors", "6", "vertices of the first ring"),
        ],
        |v| cone(v.real("radius")?, v.real("height")?, v.count("rings")?, v.count("sectors")?),
    ),
    shape(
        "grid",
        "flat rectangle",
        &[
            p("nx", "30", "cells along x"),
            p("ny", "30", "cells along y"),
            p("width", "1", "length along x"),
            p("height", "1", "length along y"),
            DIAGONAL,
        ],
        |v| grid(v.count("nx")?, v.count("ny")?, v.real("width")?, v.real("height")?, v.diagonal()?),
    ),
    shape(
        "grid_with_holes",
        "flat rectangle with round holes",
        &[
            p("nx", "60", "cells along x"),
            p("ny", "40", "cells along y"),
            p("width", "3", "length along x"),
            p("height", "2", "length along y"),
            p("holes_x", "3", "holes along x"),
            p("holes_y", "2", "holes along y"),
            p("hole_radius", "0.25", "radius of the holes"),
        ],
        |v| {
            let (width, height) = (v.real("width")?, v.real("height")?);
            grid_with_holes(v.count("nx")?, v.count("ny")?, width, height, &v.holes(width, height)?)
        },
    ),
    shape(
        "strip",
        "flat strip of equilateral triangles with edges of length 1",
        &[p("columns", "20", "triangle pairs along x"), p("rows", "4", "rows of triangles")],
        |v| strip(v.count("columns")?, v.count("rows")?),
    ),
    shape(
        "disk",
        "flat disk",
        &[
            p("rings", "20", "rings of vertices"),
            p("sectors", "6", "vertices of the first ring"),
            p("radius", "1", "radius"),
        ],
        |v| disk(v.count("rings")?, v.count("sectors")?, v.real("radius")?),
    ),
    shape(
        "annulus",
        "flat ring between two circles",
        &[
            p("inner", "0.4", "inner radius"),
            p("outer", "1", "outer radius"),
            p("rings", "10", "bands"),
            p("sectors", "64", "vertices per circle"),
        ],
        |v| annulus(v.real("inner")?, v.real("outer")?, v.count("rings")?, v.count("sectors")?),
    ),
    shape(
        "trefoil_tube",
        "tube around the trefoil knot",
        &[
            p("radius", "0.4", "radius of the tube"),
            p("n_along", "300", "sections"),
            p("n_around", "24", "vertices per section"),
        ],
        |v| trefoil_tube(v.real("radius")?, v.count("n_along")?, v.count("n_around")?),
    ),
    shape(
        "figure_eight_tube",
        "tube around the figure-eight knot",
        &[
            p("radius", "0.22", "radius of the tube"),
            p("n_along", "400", "sections"),
            p("n_around", "16", "vertices per section"),
        ],
        |v| figure_eight_tube(v.real("radius")?, v.count("n_along")?, v.count("n_around")?),
    ),
    shape(
        "linked_rings",
        "chain of linked tori",
        &[
            p("count", "3", "rings"),
            p("minor", "0.2", "radius of the tube; the rings have radius 1"),
            p("nu", "64", "vertices around each ring"),
            p("nv", "16", "vertices around each tube"),
        ],
        |v| linked_rings(v.count("count")?, v.real("minor")?, v.count("nu")?, v.count("nv")?),
    ),
    shape(
        "chain_of_genus",
        "smooth closed surface with any number of handles",
        &[p("genus", "3", "number of handles"), p("levels", "4", "number of smoothing steps")],
        |v| chain_of_genus(v.count("genus")?, v.levels("levels")?),
    ),
    shape(
        "clay_animal",
        "smooth animal on four legs",
        &[p("levels", "4", "number of smoothing steps")],
        |v| clay_animal(v.levels("levels")?),
    ),
    shape(
        "handcuffs",
        "two linked rings joined by a bar, of genus 2",
        &[p("levels", "3", "number of smoothing steps")],
        |v| handcuffs(v.levels("levels")?),
    ),
    shape(
        "joined_rings",
        "two rings above each other joined by a bar, of genus 2",
        &[p("levels", "3", "number of smoothing steps")],
        |v| joined_rings(v.levels("levels")?),
    ),
    shape(
        "borromean_rings",
        "three rings that hold together, no two of them linked",
        &[p("levels", "3", "number of smoothing steps")],
        |v| borromean_rings(v.levels("levels")?),
    ),
    shape(
        "knotted_tunnel",
        "block with a knotted tunnel, of genus 1",
        &[p("knot", "trefoil", "trefoil or figure_eight"), p("levels", "2", "number of smoothing steps")],
        |v| knotted_tunnel(v.tunnel_knot()?, v.levels("levels")?),
    ),
    shape(
        "moebius_band",
        "one-sided band with one boundary loop",
        &[
            p("radius", "1", "radius of its middle line"),
            p("width", "0.6", "width of the band"),
            p("nu", "80", "cells along"),
            p("nv", "8", "cells across"),
        ],
        |v| moebius_band(v.real("radius")?, v.real("width")?, v.count("nu")?, v.count("nv")?),
    ),
    shape(
        "klein_bottle",
        "one-sided closed surface, crossing itself (figure-eight form)",
        &[
            p("radius", "2.5", "radius of its middle line; the figure eight is 2 wide"),
            p("nu", "96", "vertices along"),
            p("nv", "48", "vertices around the tube"),
        ],
        |v| klein_bottle(v.real("radius")?, v.count("nu")?, v.count("nv")?),
    ),
    shape(
        "projective_plane",
        "one-sided closed surface, crossing itself (Boy's surface)",
        &[p("rings", "30", "rings of vertices")],
        |v| projective_plane(v.count("rings")?),
    ),
];
