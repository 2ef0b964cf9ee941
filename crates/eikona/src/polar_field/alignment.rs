//! Fields that follow guides (PLPF appendix B.2).
//!
//! Once the prescribed sums hold, the phase of the power at a corner is known up to a function on
//! corners. So a guide is a set of conditions on single values of that function: at stations along
//! it, the phase is N times the angle of the tangent, up to whole turns.
//!
//! Deviation: the paper constrains the rotation from station to station and leaves the phases of
//! separate curves to a second solve; here all curves, boundaries and creases are conditions of one
//! kind, and follow each other through the phases. The conditions are linearised where the scales
//! make the phase along an edge a curved function; the method of multipliers measures the phase of
//! the field itself, so that what remains is rounding.

use crate::geometry::vector::{Vec3, add, dot, normalize, scale};
use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation, wrapped};
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::field::{Phased, Values};
use crate::polar_field::guides::{Path, Stretch, power};
use crate::polar_field::smoothness::{CornerLaplacian, Pull, Target};
use eikona_mesh::Face;
use eikona_numeric::{Complex, Scalar, check_stopped};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Weight of a condition that must hold, in the first step of the method of multipliers.
const FIRM: f64 = 1e4;
/// Most steps of the method of multipliers.
const MOST_STEPS: usize = 60;
/// Steps without progress that end it.
const PATIENCE: usize = 8;
/// Errors of the phase, in radians, that end it.
const SMALL: f64 = 1e-10;
/// Directions with a shorter mean than this cancel.
const OPPOSITE: f64 = 1e-6;
/// A corner of a closed path may take a whole turn of the power if the power of the tangent turns
/// by more than this there.
const CORNER: f64 = 0.8 * PI;

/// Bent runs of this length, relative to the root of the area of their face, have one station.
const SHORT: f64 = 0.2;
/// Squared length of pieces, relative to the area of their face, below which no firmer hold is
/// taken.
const SHORTEST: f64 = 1e-5;
/// Derivatives of a phase that change by more than this are computed anew.
const STALE: f64 = 0.1;

/// How well the field follows a path.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Followed {
    /// The curve, boundary loop or crease, in words.
    pub guide: String,
    /// Largest angle between the tangent and the nearest of the N directions, in radians, at both
    /// ends and in the middle of each straight piece.
    pub largest_error: f64,
    /// Root mean square of this angle along the path.
    pub mean_error: f64,
    /// The face of the largest angle.
    pub worst_face: Face,
}

/// A point at which the phase is determined.
#[derive(Clone, Copy, Debug)]
struct Station {
    path: usize,
    face: Face,
    weights: [f64; 3],
    /// The N-th power of the tangent.
    wanted: Complex,
    /// The length of the guide that it stands for.
    length: f64,
    /// The tangent in space.
    heading: Vec3,
}

impl Station {
    /// Returns the pull on the phases at the corners: the derivatives of the phase at the station.
    fn pull(&self, values: &Values, strength: f64) -> Pull {
        let weights = values.phase_derivatives(self.face, self.weights).unwrap_or(self.weights);
        Pull { face: self.face, weights, strength }
    }
}

impl Pull {
    fn differs_from(&self, other: &Pull) -> bool {
        (0..3).any(|k| (self.weights[k] - other.weights[k]).abs() > STALE)
    }
}

/// What a field is to follow, and how firmly.
pub(crate) struct Following<'a> {
    pub paths: &'a [Path],
    pub degree: u32,
    /// Weight of the mean squared error; `None` if the field must follow exactly.
    pub weight: Option<f64>,
}

impl Following<'_> {
    /// Turns the smoothest rotation to the guides. `evaluate` returns the field of a rotation.
    ///
    /// # Cost
    /// A factorisation, and per step a solve and an evaluation.
    pub fn turned(
        &self,
        bevel: &BeveledMesh,
        laplacian: &CornerLaplacian,
        targets: &[Target],
        smoothest: Rotation,
        mut evaluate: impl FnMut(&Phased) -> Result<Values, PolarFieldError>,
    ) -> Result<Phased, PolarFieldError> {
        let phased = |x: &[f64]| {
            let mut theta = smoothest.clone();
            theta.add(1.0, &bevel.differences(x));
            let first = bevel.topology.components.iter().map(|c| c.first_face.halfedge(0).index());
            Phased { theta, start: first.map(|corner| x[corner]).collect() }
        };
        let mut x = vec![0.0; bevel.mesh.halfedge_count()];
        let stations = stations(bevel, self.paths, self.degree);
        if stations.is_empty() {
            return Ok(phased(&x));
        }
        let size = bevel.triangles.iter().map(|t| t.area).sum::<f64>().sqrt();
        // The two stations of a short piece differ little, so that they take a firmer hold.
        let firm = |s: &Station| {
            let share = s.length * s.length / bevel.triangles[s.face.index()].area;
            FIRM / share.clamp(SHORTEST, 1.0)
        };
        let strength = |s: &Station| self.weight.map_or(firm(s), |weight| weight * s.length / size);
        let pulls_on =
            |values: &Values| -> Vec<Pull> { stations.iter().map(|s| s.pull(values, strength(s))).collect() };
        let values = evaluate(&phased(&x))?;
        let mut pulls = pulls_on(&values);
        let mut pulled = laplacian.pulled(bevel, targets, &pulls)?;
        let mut missing = self.first_errors(bevel, &stations, &errors(&stations, &values))?;
        let mut forces = vec![0.0; stations.len()];
        let mut best = (f64::INFINITY, 0, x.clone());
        for step in 0..MOST_STEPS {
            check_stopped()?;
            let mut rhs = vec![0.0; x.len()];
            for ((pull, force), missing) in pulls.iter().zip(&forces).zip(&missing) {
                pull.push(force + pull.strength * (pull.value(&x) + missing), &mut rhs);
            }
            let next = pulled.solve(&rhs)?;
            let moved = largest(next.iter().zip(&x).map(|(a, b)| a - b));
            x = next;
            let values = evaluate(&phased(&x))?;
            missing = errors(&stations, &values);
            let now = largest(missing.iter().copied());
            if now < best.0 || self.weight.is_some() {
                best = (now, step, x.clone());
            }
            if now <= SMALL || step >= best.1 + PATIENCE || self.weight.is_some() && moved <= SMALL {
                break;
            }
            if self.weight.is_none() {
                for ((force, pull), missing) in forces.iter_mut().zip(&pulls).zip(&missing) {
                    *force += pull.strength * missing;
                }
            }
            let new = pulls_on(&values);
            if pulls.iter().zip(&new).any(|(old, new)| old.differs_from(new)) {
                pulls = new;
                pulled = laplacian.pulled(bevel, targets, &pulls)?;
            }
        }
        Ok(phased(&best.2))
    }

    /// Chooses whole turns: the errors change as little as possible along a path, and those of all
    /// paths of a component are as close as possible to those of the longest.
    fn first_errors(
        &self,
        bevel: &BeveledMesh,
        stations: &[Station],
        errors: &[f64],
    ) -> Result<Vec<f64>, PolarFieldError> {
        let mut chosen = vec![0.0; errors.len()];
        // Per component: length and mean error of the longest path.
        let mut longest: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        let mut means = Vec::new();
        let mut begin = 0;
        for same in stations.chunk_by(|a, b| a.path == b.path) {
            let range = begin..begin + same.len();
            begin = range.end;
            let path = &self.paths[same[0].path];
            let (errors, chosen_here) = (&errors[range.clone()], &mut chosen[range.clone()]);
            unwrap_along(path.is_closed, self.degree, same, errors, chosen_here)
                .map_err(|turns| self.unfollowable(path, turns))?;
            let length: f64 = same.iter().map(|s| s.length).sum();
            let mean =
                same.iter().zip(&chosen[range.clone()]).map(|(s, e)| s.length * e).sum::<f64>() / length;
            let component = bevel.component_of(Cycle::Face(same[0].face));
            let known = longest.entry(component).or_insert((length, mean));
            if length > known.0 {
                *known = (length, mean);
            }
            means.push((range, component, mean));
        }
        for (range, component, mean) in means {
            let reference = longest.get(&component).map_or(0.0, |(_, mean)| *mean);
            let turns = TAU * ((mean - reference) / TAU).round();
            chosen[range].iter_mut().for_each(|error| *error -= turns);
        }
        Ok(chosen)
    }

    fn unfollowable(&self, path: &Path, turns: i64) -> PolarFieldError {
        let turns = turns as f64 / f64::from(self.degree);
        PolarFieldError::Unfollowable { guide: path.name.clone(), turns }
    }

    /// Measures how well the field follows each path.
    pub fn followed(&self, values: &Values) -> Vec<Followed> {
        let n = f64::from(self.degree);
        let of_path = |path: &Path| {
            let mut followed = Followed {
                guide: path.name.clone(),
                largest_error: 0.0,
                mean_error: 0.0,
                worst_face: path.stretches[0].face,
            };
            let (mut sum, mut total) = (0.0, 0.0);
            for stretch in &path.stretches {
                for (t, share) in [(0.0, 0.25), (0.5, 0.5), (1.0, 0.25)] {
                    let wanted = power(stretch.direction, self.degree);
                    let error = phase_error(values, stretch.face, stretch.at(t), wanted).abs() / n;
                    sum += share * stretch.length * error * error;
                    if error > followed.largest_error {
                        followed.largest_error = error;
                        followed.worst_face = stretch.face;
                    }
                }
                total += stretch.length;
            }
            followed.mean_error = (sum / total).sqrt();
            followed
        };
        self.paths.iter().filter(|path| !path.stretches.is_empty()).map(of_path).collect()
    }
}

impl Stretch {
    fn at(&self, t: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| (1.0 - t) * self.ends[0][k] + t * self.ends[1][k])
    }

    /// Returns the direction in space.
    fn heading(&self, bevel: &BeveledMesh) -> Vec3 {
        let corners = bevel.mesh.face_positions(self.face);
        let step = [0, 1, 2].map(|k| self.ends[1][k] - self.ends[0][k]);
        let along = (0..3).fold([0.0; 3], |sum, k| add(sum, scale(corners[k], step[k])));
        normalize(along).unwrap_or(along)
    }
}

/// Stretches of a path in one face, each from the end of the one before.
struct Run {
    path: usize,
    stretches: Vec<Stretch>,
}

impl Run {
    fn length(&self) -> f64 {
        self.stretches.iter().map(|s| s.length).sum()
    }

    /// Returns the middle, and the mean of the power of the tangent.
    fn mean(&self, degree: u32) -> ([f64; 3], Complex) {
        let length = self.length();
        let mut weights = [0.0; 3];
        let mut sum = Complex::ZERO;
        for stretch in &self.stretches {
            let middle = stretch.at(0.5);
            (0..3).for_each(|k| weights[k] += stretch.length / length * middle[k]);
            sum += power(stretch.direction, degree) * (stretch.length / length);
        }
        (weights, sum)
    }
}

/// Places the stations, in the order of the paths.
///
/// A face has three degrees of freedom. One run through it has a station at each end (or one in the
/// middle, if it is bent and short), two or three runs have one each, and more of them share one.
fn stations(bevel: &BeveledMesh, paths: &[Path], degree: u32) -> Vec<Station> {
    let mut of_face: BTreeMap<Face, Vec<Run>> = BTreeMap::new();
    let mut order: Vec<(Face, usize)> = Vec::new();
    for (p, path) in paths.iter().enumerate() {
        for stretch in &path.stretches {
            let runs = of_face.entry(stretch.face).or_default();
            let continues = |run: &&mut Run| {
                run.path == p && run.stretches.last().is_some_and(|s| s.ends[1] == stretch.ends[0])
            };
            match runs.iter_mut().find(continues) {
                Some(run) => run.stretches.push(*stretch),
                None => {
                    order.push((stretch.face, runs.len()));
                    runs.push(Run { path: p, stretches: vec![*stretch] });
                }
            }
        }
    }
    let mut stations = Vec::new();
    for (face, number) in order {
        let runs = &of_face[&face];
        let Run { path, stretches } = &runs[number];
        let mut place = |weights, wanted: Complex, length, along: &Stretch| {
            let heading = along.heading(bevel);
            let size = wanted.norm();
            // Opposite directions have no mean.
            if size > OPPOSITE {
                let wanted = wanted * (1.0 / size);
                stations.push(Station { path: *path, face, weights, wanted, length, heading });
            }
        };
        match (runs.len(), stretches.as_slice()) {
            (1, [first, .., last])
                if runs[number].length() > SHORT * bevel.triangles[face.index()].area.sqrt() =>
            {
                let half = 0.5 * runs[number].length();
                place(first.ends[0], power(first.direction, degree), half, first);
                place(last.ends[1], power(last.direction, degree), half, last);
            }
            (1, [only]) => {
                let wanted = power(only.direction, degree);
                only.ends.into_iter().for_each(|end| place(end, wanted, 0.5 * only.length, only));
            }
            (1..=3, [first, ..]) => {
                let (middle, mean) = runs[number].mean(degree);
                place(middle, mean, runs[number].length(), first);
            }
            (count, [first, ..]) if number == 0 => {
                let means = runs.iter().map(|run| run.mean(degree));
                let share = 1.0 / count as f64;
                let (mut middle, mut sum) = ([0.0; 3], Complex::ZERO);
                for (weights, mean) in means {
                    (0..3).for_each(|k| middle[k] += share * weights[k]);
                    sum += mean * share;
                }
                place(middle, sum, runs.iter().map(Run::length).sum(), first);
            }
            _ => {}
        }
    }
    stations.sort_by_key(|station| station.path);
    stations
}

/// By how much the phase of the field must be turned at a point, within half a turn.
fn phase_error(values: &Values, face: Face, weights: [f64; 3], wanted: Complex) -> f64 {
    (wanted * values.power_at(face, weights).conj()).arg()
}

fn errors(stations: &[Station], values: &Values) -> Vec<f64> {
    stations.iter().map(|s| phase_error(values, s.face, s.weights, s.wanted)).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |m, x| m.max(x.abs()))
}

/// Adds whole turns so that the errors change by less than half a turn from station to station.
///
/// Around a closed path, the errors must come back to where they started. If they do not, whole
/// turns are added at the sharpest corners, where another of the N directions may go on. If there
/// are too few, the number of missing turns is the error.
fn unwrap_along(
    is_closed: bool,
    degree: u32,
    stations: &[Station],
    errors: &[f64],
    chosen: &mut [f64],
) -> Result<(), i64> {
    for i in 0..errors.len() {
        chosen[i] = if i == 0 { errors[0] } else { chosen[i - 1] + wrapped(errors[i] - chosen[i - 1]) };
    }
    let (Some(first), Some(last)) = (chosen.first(), chosen.last()) else { return Ok(()) };
    if !is_closed {
        return Ok(());
    }
    let mut turns = ((last + wrapped(first - last) - first) / TAU).round() as i64;
    // The corners, with the station after each. At the one between the last and the first station,
    // any number of turns is between the ends already.
    let turn = |a: &Station, b: &Station| dot(a.heading, b.heading).clamp(-1.0, 1.0).acos();
    let mut corners: Vec<(f64, usize)> = (0..stations.len())
        .map(|i| (turn(&stations[i.checked_sub(1).unwrap_or(stations.len() - 1)], &stations[i]), i))
        .collect();
    corners.retain(|(angle, _)| f64::from(degree) * angle > CORNER);
    corners.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, at) in corners {
        if turns != 0 {
            let turn = TAU * turns.signum() as f64;
            chosen[at..].iter_mut().filter(|_| at > 0).for_each(|error| *error -= turn);
            turns -= turns.signum();
        }
    }
    if turns == 0 { Ok(()) } else { Err(turns) }
}
