//! Reads fields of N vectors per face: `.rawfield` and `.matching` (Directional), `.rosy`
//! (QuadWild), the CSV of `eikona field`, and NumPy arrays.

use crate::exit::Failure;
use crate::numpy::read_npy;
use eikona::geometry::vector::{cross, norm, scale, sub};
use eikona::polar_field::{FaceVectors, Match};
use eikona_mesh::{Face, TriangleMesh, Vertex};
use std::path::Path;

/// Largest accepted N.
const MOST_DIRECTIONS: u32 = 1000;

/// Reads N vectors per face of a mesh. The N of the file must be `degree`, if given.
pub fn read_directions(
    path: &Path,
    degree: Option<u32>,
    mesh: &TriangleMesh,
) -> Result<FaceVectors, Failure> {
    let field = read_field(path, degree)?;
    let is_rosy = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("rosy"));
    if is_rosy { completed(field, mesh) } else { Ok(field) }
}

fn read_field(path: &Path, degree: Option<u32>) -> Result<FaceVectors, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let parse = match extension.as_deref() {
        Some("npy") => return array(path, degree),
        Some("rawfield") => Lines::rawfield,
        Some("rosy") => Lines::rosy,
        Some("csv") => Lines::csv,
        _ => {
            return Err(Failure::Usage(format!(
                "{}: unknown field format; use .rawfield, .rosy, .csv or .npy",
                path.display()
            )));
        }
    };
    let text = read(path)?;
    with_degree(path, parse(&Lines { path, text: &text })?, degree)
}

fn with_degree(path: &Path, field: FaceVectors, degree: Option<u32>) -> Result<FaceVectors, Failure> {
    match degree.filter(|degree| *degree != field.degree) {
        Some(degree) => Err(Failure::Input(format!(
            "{}: this field has N = {}, not {degree}; leave out -n",
            path.display(),
            field.degree
        ))),
        None => Ok(field),
    }
}

/// Reads an array of shape (F, N, 3) or (F, 3N).
fn array(path: &Path, degree: Option<u32>) -> Result<FaceVectors, Failure> {
    let wrong = |problem: String| Failure::Input(format!("{}: {problem}", path.display()));
    let bytes = std::fs::read(path).map_err(|fault| not_read(path, &fault))?;
    let array = read_npy(&bytes).map_err(|problem| wrong(format!("this array is {problem}")))?;
    let found = match *array.shape.as_slice() {
        [_, n, 3] => n,
        [_, columns] if columns % 3 == 0 => columns / 3,
        _ => {
            return Err(wrong(format!(
                "this array has the shape {:?}; save one of shape (F, N, 3), with N vectors per face",
                array.shape
            )));
        }
    };
    let found = u32::try_from(found).ok().filter(|n| (1..=MOST_DIRECTIONS).contains(n));
    let found = found.ok_or_else(|| wrong(format!("N is out of range; expected 1 to {MOST_DIRECTIONS}")))?;
    if let Some(i) = array.values.iter().position(|x| !x.is_finite()) {
        let face = i / (3 * found as usize);
        return Err(wrong(format!("the value {} of face {face} is not a finite number", array.values[i])));
    }
    let vectors = array.values.chunks(3).map(|v| [v[0], v[1], v[2]]).collect();
    with_degree(path, FaceVectors { degree: found, vectors, ..FaceVectors::default() }, degree)
}

/// Reads shifts between the vectors of neighbouring faces.
pub fn read_matching(path: &Path, degree: u32) -> Result<Vec<Match>, Failure> {
    let text = read(path)?;
    Lines { path, text: &text }.matching(degree)
}

fn read(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|fault| not_read(path, &fault))
}

fn not_read(path: &Path, fault: &std::io::Error) -> Failure {
    Failure::Input(match fault.kind() {
        std::io::ErrorKind::NotFound => {
            format!("{}: no such file; check the name and the folder", path.display())
        }
        _ => format!("{}: {fault}", path.display()),
    })
}

/// A text of numbers, line by line.
struct Lines<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Lines<'_> {
    fn wrong(&self, line: usize, problem: &str) -> Failure {
        Failure::Input(format!("{}: line {}: {problem}", self.path.display(), line + 1))
    }

    /// Returns the lines that are not empty, with their numbers.
    fn rows(&self) -> impl Iterator<Item = (usize, &str)> {
        self.text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty())
    }

    fn numbers<T: std::str::FromStr>(&self, line: usize, text: &str) -> Result<Vec<T>, Failure> {
        let word =
            |word: &str| word.parse().map_err(|_| self.wrong(line, &format!("{word} is not a number")));
        text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty()).map(word).collect()
    }

    fn header<const N: usize>(&self, what: &str) -> Result<[usize; N], Failure> {
        let (line, text) =
            self.rows().next().ok_or_else(|| self.wrong(0, &format!("the file is empty; {what}")))?;
        let numbers: Vec<usize> = self.numbers(line, text)?;
        // An older writer adds a third number.
        match numbers.get(..N).and_then(|first| <[usize; N]>::try_from(first).ok()) {
            Some(header) => Ok(header),
            None => Err(self.wrong(line, what)),
        }
    }

    fn vectors(&self, line: usize, text: &str, count: usize) -> Result<Vec<[f64; 3]>, Failure> {
        let numbers: Vec<f64> = self.numbers(line, text)?;
        if numbers.len() != 3 * count {
            let problem = format!("{} numbers instead of {}", numbers.len(), 3 * count);
            return Err(self.wrong(line, &problem));
        }
        if let Some(x) = numbers.iter().find(|x| !x.is_finite()) {
            return Err(self.wrong(line, &format!("{x} is not a finite number")));
        }
        Ok(numbers.chunks(3).map(|v| [v[0], v[1], v[2]]).collect())
    }

    /// Reads `N rows`, then 3N numbers per row.
    fn rawfield(&self) -> Result<FaceVectors, Failure> {
        let [degree, rows] = self.header("expected N and the number of rows")?;
        let degree = self.degree(degree)?;
        let mut vectors = Vec::new();
        let mut found = 0;
        for (line, text) in self.rows().skip(1) {
            vectors.extend(self.vectors(line, text, degree as usize)?);
            found += 1;
        }
        self.counted(found, rows)?;
        Ok(FaceVectors { degree, vectors, ..FaceVectors::default() })
    }

    /// Reads the number of faces, N = 4, then the first vector per face. The others follow by
    /// quarter turns, which need the normals: they are added by [`completed`].
    fn rosy(&self) -> Result<FaceVectors, Failure> {
        let [rows] = self.header("expected the number of faces")?;
        let (line, text) = self.rows().nth(1).ok_or_else(|| self.wrong(1, "expected N = 4"))?;
        if self.numbers::<usize>(line, text)? != [4] {
            return Err(self.wrong(line, "expected N = 4"));
        }
        let mut vectors = Vec::new();
        let mut found = 0;
        for (line, text) in self.rows().skip(2) {
            vectors.extend(self.vectors(line, text, 1)?);
            found += 1;
        }
        self.counted(found, rows)?;
        Ok(FaceVectors { degree: 4, vectors, ..FaceVectors::default() })
    }

    /// Reads `x,y,z,vx0,vy0,vz0,...`: positions, which are left out, and N vectors.
    fn csv(&self) -> Result<FaceVectors, Failure> {
        const HEADER: &str = "expected the header x,y,z,vx0,vy0,vz0,...";
        let (line, header) = self.rows().next().ok_or_else(|| self.wrong(0, HEADER))?;
        let columns = header.split(',').count();
        if !header.trim().starts_with("x,y,z,vx0,vy0,vz0") || !columns.is_multiple_of(3) {
            return Err(self.wrong(line, HEADER));
        }
        let degree = columns / 3 - 1;
        let mut vectors = Vec::new();
        for (line, text) in self.rows().skip(1) {
            vectors.extend_from_slice(&self.vectors(line, text, degree + 1)?[1..]);
        }
        Ok(FaceVectors { degree: self.degree(degree)?, vectors, ..FaceVectors::default() })
    }

    /// Reads `N rows`, then rows of two faces and a shift: documented as five columns (faces, the
    /// vertices of their edge, shift); writers also use three, and eight with other data in
    /// between.
    fn matching(&self, degree: u32) -> Result<Vec<Match>, Failure> {
        let [n, rows] = self.header("expected N and the number of rows")?;
        if n != degree as usize {
            return Err(self.wrong(0, &format!("this matching has N = {n}, but the field has N = {degree}")));
        }
        let mut matching = Vec::new();
        let mut found = 0;
        for (line, text) in self.rows().skip(1) {
            found += 1;
            let numbers: Vec<i64> = self.numbers(line, text)?;
            if ![3, 5, 8].contains(&numbers.len()) {
                let problem =
                    format!("{} numbers instead of 3, 5 or 8: two faces first, a shift last", numbers.len());
                return Err(self.wrong(line, &problem));
            }
            // Boundary edges have face -1.
            let number = |i: usize| u32::try_from(*numbers.get(i)?).ok();
            if let (Some(f), Some(g), Some(&shift)) = (number(0), number(1), numbers.last()) {
                let has_vertices = numbers.len() > 3;
                let vertices = number(2).zip(number(3)).filter(|_| has_vertices);
                let vertices = vertices.map(|(v, w)| [Vertex(v), Vertex(w)]);
                matching.push(Match { faces: [Face(f), Face(g)], vertices, shift });
            }
        }
        self.counted(found, rows)?;
        Ok(matching)
    }

    fn degree(&self, degree: usize) -> Result<u32, Failure> {
        let found = u32::try_from(degree).ok().filter(|n| (1..=MOST_DIRECTIONS).contains(n));
        found.ok_or_else(|| {
            self.wrong(0, &format!("N = {degree} is out of range; expected 1 to {MOST_DIRECTIONS}"))
        })
    }

    fn counted(&self, found: usize, rows: usize) -> Result<(), Failure> {
        if found == rows {
            return Ok(());
        }
        let last = self.rows().last().map_or(0, |(line, _)| line);
        Err(self.wrong(last, &format!("the file ends after {found} rows, but its header says {rows}")))
    }
}

/// Adds three quarter turns to one vector per face.
fn completed(field: FaceVectors, mesh: &TriangleMesh) -> Result<FaceVectors, Failure> {
    let (found, faces) = (field.vectors.len(), mesh.face_count());
    if found != faces {
        let hint =
            if found == mesh.vertex_count() { ", as many as vertices: one per face is needed" } else { "" };
        return Err(Failure::Input(format!("the field has {found} vectors for {faces} faces{hint}")));
    }
    let mut vectors = Vec::with_capacity(4 * found);
    for (face, v) in mesh.faces().zip(field.vectors) {
        let [a, b, c] = mesh.face_positions(face);
        let normal = cross(sub(b, a), sub(c, a));
        let turned = cross(scale(normal, 1.0 / norm(normal).max(f64::MIN_POSITIVE)), v);
        vectors.extend([v, turned, scale(v, -1.0), scale(turned, -1.0)]);
    }
    Ok(FaceVectors { vectors, ..field })
}
