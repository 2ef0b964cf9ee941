//! `eikona make`: generates shapes, optionally damaged, and whole or broken curves on them.

use crate::exit::Failure;
use crate::input::parse_format;
use crate::number::{brief, finite, share, zero_or_more};
use crate::session::{General, Session, check_outputs, print_bytes};
use clap::Args;
use eikona::contour::{Wave, polylines, wavy_plane_cut};
use eikona::curves::{DEFAULT_TOLERANCE, trace_polyline};
use eikona::spatial::Bvh;
use eikona_mesh::io::{MeshFormat, MeshOut};
use eikona_mesh::shapes::{self, shape_descriptions};
use eikona_mesh::{
    CurveFile, CurveFormat, CurveKind, Quality, SpacePolyline, SurfaceCurves, TriangleMesh, counted, damage,
    format_curves,
};
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Arguments of `eikona make`.
#[derive(Args, Clone, Debug, Default)]
#[command(after_help = "Without SHAPE, lists all shapes and their parameters.

Examples:
  eikona make torus major=1 minor=0.4 nu=120 nv=48 -o torus.ply
  eikona make geodesic_sphere frequency=30 -o sphere.obj --jitter 0.2 --flip-faces 0.1
  eikona make clay_animal -o animal.ply --broken-curve loop.json --cut axis=x,at=0.2 --keep 0.1 --drop 0.05
  eikona make torus -o torus.ply --curve-out knot.json --curve torus-knot,p=2,q=3,major=1,minor=0.4")]
pub struct MakeArguments {
    /// Shape to generate
    #[arg(value_name = "SHAPE")]
    pub shape: Option<String>,
    /// Parameters of the shape
    #[arg(value_name = "key=value")]
    pub parameters: Vec<String>,
    /// Output mesh: .ply, .obj, .off, .stl, .glb, .gltf, .vtp; - for standard output
    #[arg(short, long, value_name = "MESH")]
    pub output: Option<PathBuf>,
    /// Format of the mesh on standard output
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    pub out_format: Option<MeshFormat>,
    #[command(flatten)]
    pub damage: DamageArguments,
    #[command(flatten)]
    pub curve: CurveArguments,
}

/// Deliberate damage.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Damage (applied in this order)")]
pub struct DamageArguments {
    /// Move each vertex randomly by up to A times its shortest edge
    #[arg(long, value_name = "A", allow_hyphen_values = true, value_parser = zero_or_more)]
    pub jitter: Option<f64>,
    /// Remove N round patches of faces
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub holes: Option<usize>,
    /// Remove this share of the faces
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = share)]
    pub remove_faces: Option<f64>,
    /// Flip this share of the faces
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = share)]
    pub flip_faces: Option<f64>,
    /// Renumber vertices and faces randomly
    #[arg(long)]
    pub shuffle: bool,
    /// Give each face its own vertices
    #[arg(long)]
    pub unweld: bool,
    /// Random seed [default: 1 for damage; curves are broken evenly without a seed]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// A curve on the mesh.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Curves")]
pub struct CurveArguments {
    /// Write the whole curve, from --cut or --curve
    #[arg(long, value_name = "C.json")]
    pub curve_out: Option<PathBuf>,
    /// Write the curve broken into pieces
    #[arg(long, value_name = "C.json")]
    pub broken_curve: Option<PathBuf>,
    /// Generate a curve in space: circle, latitude, wavy-latitude, torus-knot, trefoil or
    /// figure-eight, with its parameters. (To use a curve file, pass it to `eikona sdf`.)
    #[arg(long, value_name = "NAME[,key=value..]", conflicts_with = "cut")]
    pub curve: Option<String>,
    /// Cut the mesh with a plane, given by its axis and position (a coordinate, or a share such as
    /// 30%). wave=A makes the plane rise and fall by A, waves=N times per turn about the middle of
    /// the mesh or about=x:y:z
    #[arg(long, value_name = "axis=z,at=0.3[,wave=A,..]", allow_hyphen_values = true)]
    pub cut: Option<String>,
    /// Length of each piece, as a share of the curve's length [default: 0.1]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = parse_keep)]
    pub keep: Option<f64>,
    /// Length of each gap, as a share of the curve's length; 0 leaves the curve whole [default:
    /// 0.05]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = share)]
    pub drop: Option<f64>,
}

fn parse_keep(text: &str) -> Result<f64, String> {
    share(text).ok().filter(|x| *x > 0.0).ok_or("expected a share above 0 and at most 1".into())
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &MakeArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("make", general);
    let Some(shape) = &arguments.shape else {
        print_bytes(list_shapes().as_bytes())?;
        return session.finish();
    };
    let Some(output) = &arguments.output else {
        return Err(Failure::Usage(format!(
            "no output is given; write the mesh with: eikona make {shape} -o {shape}.ply"
        )));
    };
    let curves = &arguments.curve;
    let outputs = [Some(output.as_path()), curves.curve_out.as_deref(), curves.broken_curve.as_deref()];
    let outputs: Vec<&Path> = outputs.into_iter().chain([general.report.as_deref()]).flatten().collect();
    check_outputs(&outputs, &[])?;
    let format = mesh_format(output, arguments.out_format)?;
    check_curves(curves)?;
    check_seed(arguments)?;

    let parameters = key_values(arguments.parameters.iter().map(String::as_str))?;
    let mesh = session.phase("make", || shapes::make(shape, &parameters))?;
    let mesh = session.phase("damage", || damaged(mesh, &arguments.damage))?;
    session.report.options.insert("shape".into(), json!(shape));
    session.report.options.insert("parameters".into(), json!(parameters));
    session.report.options.insert("seed".into(), json!(arguments.damage.seed));
    session.report.result.insert("vertices".into(), json!(mesh.vertex_count()));
    session.report.result.insert("faces".into(), json!(mesh.face_count()));
    let vertices = counted(mesh.vertex_count(), "vertex", "vertices");
    session.note(&format!("{shape}: {vertices}, {}", counted(mesh.face_count(), "face", "faces")));

    session.mesh_output("mesh", output, Some(format), &MeshOut::from(&mesh))?;
    write_curves(arguments, &mesh, &mut session)?;
    session.finish()
}

fn mesh_format(output: &Path, given: Option<MeshFormat>) -> Result<MeshFormat, Failure> {
    if given.is_some() && output != Path::new("-") {
        return Err(Failure::Usage(format!(
            "--out-format sets the format of standard output, but the mesh goes to {}, whose name sets its \
             format; leave --out-format out",
            output.display()
        )));
    }
    if output == Path::new("-") {
        let missing = || {
            Failure::Usage(
                "the format of standard output is not given; add --out-format with \
         ply, obj, off, stl, glb, gltf or vtp"
                    .into(),
            )
        };
        return given.ok_or_else(missing);
    }
    MeshFormat::from_path(output).ok_or_else(|| {
        Failure::Usage(format!(
            "{}: unknown mesh format; use .ply, .obj, .off, .stl, .glb, .gltf or .vtp",
            output.display()
        ))
    })
}

fn list_shapes() -> String {
    let mut text = String::from("Shapes (eikona make SHAPE [key=value]... -o MESH):\n\n");
    for shape in shape_descriptions() {
        let _ = writeln!(text, "{}: {}", shape.name, shape.summary);
        for p in shape.parameters {
            let _ = writeln!(text, "    {:<20} {}", format!("{}={}", p.name, p.default), p.meaning);
        }
    }
    text
}

fn key_values<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec<(&'a str, &'a str)>, Failure> {
    words
        .map(|word| {
            word.split_once('=').map(|(k, v)| (k.trim(), v.trim())).ok_or_else(|| {
                Failure::Usage(format!("{word:?} is not a parameter; write parameters as key=value"))
            })
        })
        .collect()
}

fn damaged(mut mesh: TriangleMesh, damages: &DamageArguments) -> Result<TriangleMesh, Failure> {
    /// Radius of a hole in rings of faces.
    const HOLE_RINGS: usize = 2;
    let seed = damages.seed.unwrap_or(1);
    if let Some(amount) = damages.jitter {
        mesh = damage::jitter(&mesh, amount, seed)?;
    }
    if let Some(count) = damages.holes {
        mesh = damage::holes(&mesh, count, HOLE_RINGS, seed)?.mesh;
    }
    if let Some(share) = damages.remove_faces {
        mesh = damage::remove_faces(&mesh, share, seed)?.mesh;
    }
    if let Some(share) = damages.flip_faces {
        mesh = damage::flip_faces(&mesh, share, seed)?.mesh;
    }
    if damages.shuffle {
        mesh = damage::shuffle(&mesh, seed)?.mesh;
    }
    if damages.unweld {
        mesh = damage::unweld(&mesh)?.mesh;
    }
    Ok(mesh)
}

/// Checks the curve options before the mesh is generated.
fn check_curves(wanted: &CurveArguments) -> Result<(), Failure> {
    let named = wanted.curve.as_deref().map(named_curve).transpose()?.is_some();
    let cut = wanted.cut.as_deref().map(parse_cut).transpose()?.is_some();
    let described = named || cut;
    let outputs = [wanted.curve_out.as_deref(), wanted.broken_curve.as_deref()];
    let mut outputs = outputs.into_iter().flatten().peekable();
    if outputs.peek().is_some() && !described {
        return Err(Failure::Usage(
            "a curve file is requested, but no curve; add --cut axis=z,at=0.3 (the cut of the mesh with a \
             plane) or --curve circle"
                .into(),
        ));
    }
    if outputs.peek().is_none() && (described || wanted.keep.is_some() || wanted.drop.is_some()) {
        return Err(Failure::Usage(
            "a curve is described, but no curve file requested; add --curve-out C.json (whole) or \
             --broken-curve C.json (in pieces)"
                .into(),
        ));
    }
    if wanted.broken_curve.is_none() && (wanted.keep.is_some() || wanted.drop.is_some()) {
        return Err(Failure::Usage(
            "--keep and --drop have no effect on --curve-out, which writes the whole curve; write the \
             pieces with --broken-curve C.json"
                .into(),
        ));
    }
    outputs.try_for_each(|path| curve_format(path).map(|_| ()))
}

/// Fails for a seed if nothing is random.
fn check_seed(arguments: &MakeArguments) -> Result<(), Failure> {
    let damage = &arguments.damage;
    let shares = [damage.jitter, damage.remove_faces, damage.flip_faces].iter().any(Option::is_some);
    let random = shares || damage.holes.is_some() || damage.shuffle || arguments.curve.broken_curve.is_some();
    match damage.seed {
        Some(seed) if !random => Err(Failure::Usage(format!(
            "--seed {seed} has no effect: nothing is random; leave it out, or add --jitter, --holes, \
             --remove-faces, --flip-faces, --shuffle or --broken-curve"
        ))),
        _ => Ok(()),
    }
}

fn write_curves(
    arguments: &MakeArguments,
    mesh: &TriangleMesh,
    session: &mut Session,
) -> Result<(), Failure> {
    let wanted = &arguments.curve;
    let (lines, curves) = match (&wanted.curve, &wanted.cut) {
        (Some(name), _) => (vec![named_curve(name)?], Vec::new()),
        (None, Some(cut)) => {
            let cut = parse_cut(cut)?;
            let curves = session.phase("cut", || cut_mesh(mesh, &cut))?;
            (polylines(mesh, &curves).map_err(|e| Failure::Failed(e.to_string()))?, curves)
        }
        (None, None) => return Ok(()),
    };
    if let Some(path) = &wanted.curve_out {
        let mut file = CurveFile::default();
        file.curves.curves = curves;
        if file.curves.curves.is_empty() {
            file.polylines = lines.iter().map(|l| space_polyline(l)).collect();
        }
        output_curves(path, &file, mesh, session)?;
    }
    if let Some(path) = &wanted.broken_curve {
        let pieces = session.phase("break", || broken(&lines, arguments))?;
        let bvh = Bvh::new(mesh);
        let mut file = CurveFile { curves: SurfaceCurves::default(), ..CurveFile::default() };
        for piece in pieces.iter().map(|p| space_polyline(p)) {
            let traced = trace_polyline(
                mesh,
                &bvh,
                &piece.points,
                piece.closed,
                CurveKind::Signed,
                DEFAULT_TOLERANCE,
            )?;
            file.curves.curves.push(traced.curve);
        }
        session.note(&match pieces.as_slice() {
            [_] => "curve: 1 piece".to_string(),
            all => format!("curve: {} pieces", all.len()),
        });
        session.report.result.insert("pieces".into(), json!(pieces.len()));
        output_curves(path, &file, mesh, session)?;
    }
    Ok(())
}

fn space_polyline(points: &[[f64; 3]]) -> SpacePolyline {
    let closed = points.len() > 2 && points.first() == points.last();
    let points = points[..points.len() - usize::from(closed)].to_vec();
    SpacePolyline { kind: CurveKind::Signed, closed, points }
}

pub fn output_curves(
    path: &Path,
    file: &CurveFile,
    mesh: &TriangleMesh,
    session: &mut Session,
) -> Result<(), Failure> {
    let text = format_curves(file, curve_format(path)?, mesh)
        .map_err(|e| Failure::Usage(format!("{}: {e}", path.display())))?;
    session.output("curve", path, text.into_bytes())
}

pub fn curve_format(path: &Path) -> Result<CurveFormat, Failure> {
    CurveFormat::from_extension(path).ok_or_else(|| {
        Failure::Usage(format!("{}: unknown curve format; use .json, .obj or .txt", path.display()))
    })
}

fn broken(lines: &[Vec<[f64; 3]>], arguments: &MakeArguments) -> Result<Vec<Vec<[f64; 3]>>, Failure> {
    let (keep, drop) = (arguments.curve.keep.unwrap_or(0.1), arguments.curve.drop.unwrap_or(0.05));
    if drop == 0.0 {
        return Ok(lines.to_vec());
    }
    let mut pieces = Vec::new();
    for line in lines {
        pieces.extend(match arguments.damage.seed {
            Some(seed) => shapes::break_polyline_at_random(line, keep, drop, seed)?,
            None => shapes::break_polyline(line, keep, drop)?,
        });
    }
    Ok(pieces)
}

/// The values of a comma-separated list of `key=value`, without unknown or repeated keys.
struct Keys<'a> {
    what: &'a str,
    values: Vec<(&'a str, &'a str)>,
}

impl<'a> Keys<'a> {
    fn parse(what: &'a str, words: &[&'a str], known: &[&str]) -> Result<Keys<'a>, Failure> {
        let values = key_values(words.iter().copied())?;
        if let Some((key, _)) = values.iter().find(|(k, _)| !known.contains(k)) {
            return Err(Failure::Usage(format!(
                "{what} has no parameter {key:?}; its parameters are {}",
                known.join(", ")
            )));
        }
        let twice = |&(i, (key, _)): &(usize, &(&str, &str))| values[..i].iter().any(|(k, _)| k == key);
        if let Some((_, (key, value))) = values.iter().enumerate().find(twice) {
            return Err(Failure::Usage(format!("{what}: {key}={value} repeats {key}; give it once")));
        }
        Ok(Keys { what, values })
    }
    fn text(&self, key: &str) -> Option<&'a str> {
        self.values.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
    }
    fn number<T: std::str::FromStr>(&self, key: &str, default: T) -> Result<T, Failure> {
        let Some(text) = self.text(key) else { return Ok(default) };
        text.parse().map_err(|_| Failure::Usage(format!("{}: {key}={text} is not a valid number", self.what)))
    }
}

/// Names of curves for `make --curve`.
pub const CURVE_NAMES: [&str; 6] =
    ["circle", "latitude", "wavy-latitude", "torus-knot", "trefoil", "figure-eight"];

fn named_curve(text: &str) -> Result<Vec<[f64; 3]>, Failure> {
    let words: Vec<&str> = text.split(',').collect();
    let (name, parameters) = words.split_first().map_or(("", &[][..]), |(n, p)| (*n, p));
    let keys = |known: &[&str]| Keys::parse(name, parameters, known);
    Ok(match name {
        "circle" => {
            let k = keys(&["radius", "n"])?;
            shapes::circle(k.number("radius", 1.0)?, k.number("n", 200)?)?
        }
        "latitude" => {
            let k = keys(&["latitude", "n"])?;
            shapes::latitude_circle(k.number("latitude", 0.3)?, k.number("n", 200)?)?
        }
        "wavy-latitude" => {
            let k = keys(&["latitude", "amplitude", "waves", "n"])?;
            let (latitude, amplitude) = (k.number("latitude", 0.2)?, k.number("amplitude", 0.3)?);
            shapes::wavy_latitude(latitude, amplitude, k.number("waves", 5)?, k.number("n", 400)?)?
        }
        "torus-knot" => {
            let k = keys(&["p", "q", "major", "minor", "n"])?;
            let (major, minor) = (k.number("major", 1.0)?, k.number("minor", 0.4)?);
            shapes::torus_knot(k.number("p", 2)?, k.number("q", 3)?, major, minor, k.number("n", 400)?)?
        }
        "trefoil" => shapes::trefoil(keys(&["n"])?.number("n", 400)?)?,
        "figure-eight" => shapes::figure_eight_knot(keys(&["n"])?.number("n", 400)?)?,
        _ => {
            let known = CURVE_NAMES.join(", ");
            let is_file = Path::new(text).exists() || CurveFormat::from_extension(Path::new(text)).is_some();
            return Err(Failure::Usage(if is_file {
                format!(
                    "--curve {text}: `make` expects the name of a curve ({known}), not a file; for the \
                     distance to the curves of a file: eikona sdf MESH --curve {text} -o distance.ply"
                )
            } else {
                format!("--curve {text}: no curve is named {name:?}; choose one of {known}")
            }));
        }
    })
}

fn parse_point(text: &str) -> Result<[f64; 3], Failure> {
    let numbers: Option<Vec<f64>> = text.split(':').map(|x| x.parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| {
        Failure::Usage(format!("--cut: about={text} is not a point; give three coordinates such as 0:0.5:1"))
    })
}

/// A requested cut of a mesh with a plane.
struct Cut {
    axis: usize,
    place: Place,
    about: Option<[f64; 3]>,
    wave: Wave,
}

/// Position of a plane along its axis.
enum Place {
    Coordinate(f64),
    /// Share of the bounding box, from its lower end.
    Share(f64),
}

fn parse_cut(text: &str) -> Result<Cut, Failure> {
    let words: Vec<&str> = text.split(',').collect();
    let keys = Keys::parse("--cut", &words, &["axis", "at", "wave", "waves", "about"])?;
    let axis = match keys.text("axis").unwrap_or("z") {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        other => {
            return Err(Failure::Usage(format!("--cut: axis={other} is not an axis; give one of x, y, z")));
        }
    };
    let at = keys.text("at").unwrap_or("50%");
    let number = |text: &str| {
        finite(text).map_err(|_| {
            Failure::Usage(format!(
                "--cut: at={at} is not a position; give a coordinate such as 0.3 or a share such as 30%"
            ))
        })
    };
    let place = match at.strip_suffix('%') {
        Some(percent) => Place::Share(number(percent)? / 100.0),
        None => Place::Coordinate(number(at)?),
    };
    let about = keys.text("about").map(parse_point).transpose()?;
    let wave = Wave { amplitude: keys.number("wave", 0.0)?, count: keys.number("waves", 3)? };
    if keys.text("wave").is_none()
        && let Some(key) = ["about", "waves"].into_iter().find(|key| keys.text(key).is_some())
    {
        return Err(Failure::Usage(format!(
            "--cut: {key} has no effect on a flat plane; add wave=A, the height of the wave"
        )));
    }
    Ok(Cut { axis, place, about, wave })
}

fn cut_mesh(mesh: &TriangleMesh, cut: &Cut) -> Result<Vec<eikona_mesh::Curve>, Failure> {
    let Some([low, high]) = Quality::of(mesh).bounding_box else {
        return Err(Failure::Usage("--cut: the mesh has no faces to cut; choose other parameters".into()));
    };
    let axis = cut.axis;
    let at = match cut.place {
        Place::Coordinate(x) => x,
        Place::Share(share) => low[axis] + share * (high[axis] - low[axis]),
    };
    let mut point = cut.about.unwrap_or([0, 1, 2].map(|k| 0.5 * (low[k] + high[k])));
    point[axis] = at;
    let normal = [0, 1, 2].map(|k| if k == axis { 1.0 } else { 0.0 });
    let curves = wavy_plane_cut(mesh, point, normal, cut.wave)?;
    if curves.is_empty() {
        return Err(Failure::Usage(format!(
            "--cut: the plane {}={} does not meet the mesh, which lies between {} and {}; choose a position \
             between them",
            ["x", "y", "z"][axis],
            brief(at),
            brief(low[axis]),
            brief(high[axis])
        )));
    }
    Ok(curves)
}
