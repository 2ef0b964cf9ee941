//! Evenly spaced streamlines (Jobard and Lefer 1997), on a surface.

use crate::geometry::unit_of;
use crate::geometry::vector::{distance, dot, sub};
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::solution::PolarField;
use crate::polar_field::streamlines::tracer::{State, Tracer};
use crate::polar_field::streamlines::{Streamline, StreamlineEnd, joined};
use eikona_mesh::Located;
use eikona_numeric::check_stopped;
use std::collections::{HashMap, VecDeque};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Distance at which a line ends near another one, relative to the separation.
const CLOSE: f64 = 0.5;
/// Shorter lines are left out, relative to the separation.
const SHORT: f64 = 1.5;
/// Points of the same line within this length, relative to the separation, are no neighbours.
const OWN: f64 = 1.5;
/// A line that passes its seed at this distance or less is closed, relative to the separation.
const BESIDE: f64 = 0.2;
/// Longest line to each side, relative to the separation.
const LONGEST: f64 = 2000.0;
/// Cosine of the angle between normals beyond which points are on different sheets.
const SAME_SHEET: f64 = 0.3;

/// A point of a line that is there.
#[derive(Clone, Copy, Debug)]
struct Sample {
    position: [f64; 3],
    along: [f64; 3],
    normal: [f64; 3],
    line: u32,
    /// Length along the line from its seed.
    length: f64,
}

type Cell = [i64; 3];

/// The lines so far, in a grid of cells as wide as the separation.
pub(super) struct Spacing<'a> {
    tracer: Tracer<'a>,
    separation: f64,
    /// Lines whose directions differ by more than the angle of this cosine may cross.
    parallel: f64,
    cells: HashMap<Cell, Vec<Sample>>,
}

impl<'a> Spacing<'a> {
    pub fn new(field: &'a PolarField, separation: f64) -> Spacing<'a> {
        // The N directions are on N lines if N is odd, and on N / 2 if it is even.
        let n = f64::from(field.degree());
        let between = if field.degree().is_multiple_of(2) { TAU / n } else { PI / n };
        let parallel = if field.degree() <= 2 { 0.0 } else { (0.5 * between).cos() };
        let separation = separation / unit_of(field.mesh());
        Spacing { tracer: Tracer::new(field, 0.3 * separation), separation, parallel, cells: HashMap::new() }
    }

    /// Traces lines: beside lines that are there as long as there is room, then from faces far from
    /// all of them.
    pub fn lines(mut self) -> Result<Vec<Streamline>, PolarFieldError> {
        let field = self.tracer.field;
        let mut lines = Vec::new();
        let mut waiting: VecDeque<State> = VecDeque::new();
        let families = if field.degree().is_multiple_of(2) { field.degree() / 2 } else { field.degree() };
        for face in field.mesh().faces() {
            check_stopped()?;
            for k in 0..families {
                let middle = Located::Face(face, [1.0 / 3.0; 3]);
                waiting.extend(self.tracer.start(middle, k));
                while let Some(seed) = waiting.pop_front() {
                    check_stopped()?;
                    if self.has_room(&seed, self.separation * 0.999, u32::MAX, 0.0) {
                        lines.extend(self.line(seed, lines.len() as u32, families, &mut waiting));
                    }
                }
            }
        }
        Ok(lines)
    }

    /// Traces a line and adds seeds beside it.
    fn line(
        &mut self,
        seed: State,
        number: u32,
        families: u32,
        waiting: &mut VecDeque<State>,
    ) -> Option<Streamline> {
        let mut visited = vec![(seed, 0.0)];
        let ahead = self.half(seed, number, 1.0, &mut visited);
        let behind = if ahead.1 == StreamlineEnd::Closed {
            (Vec::new(), StreamlineEnd::Closed)
        } else {
            self.half(seed.reversed(), number, -1.0, &mut visited)
        };
        let length = visited.iter().fold([0.0f64; 2], |[a, b], (_, l)| [a.min(*l), b.max(*l)]);
        if length[1] - length[0] < SHORT * self.separation {
            self.remove(number, &visited);
            return None;
        }
        self.add(&seed, number, 0.0);
        let mut last = f64::NEG_INFINITY;
        visited.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (state, length) in visited.iter().filter(|(_, length)| *length != 0.0) {
            if length - last < 0.5 * self.separation {
                continue;
            }
            last = *length;
            for side in [FRAC_PI_2, -FRAC_PI_2] {
                // The direction there is that of the field, of each family.
                let beside = self.tracer.walk(state.turned(side)).straight(self.separation);
                let Some(beside) = beside else { continue };
                let place = self.tracer.located(&beside);
                waiting.extend((0..families).filter_map(|k| self.tracer.start(place, k)));
            }
        }
        Some(joined(self.tracer.located(&seed), ahead, behind))
    }

    /// Traces half of a line, and marks its points.
    fn half(
        &mut self,
        seed: State,
        number: u32,
        sign: f64,
        visited: &mut Vec<(State, f64)>,
    ) -> (Vec<Located>, StreamlineEnd) {
        let mut nodes = Vec::new();
        let mut walked = 0.0;
        let most = LONGEST * self.separation;
        let mut paused = self.tracer.walk(seed).paused();
        loop {
            let mut walk = self.tracer.resumed(paused);
            let (node, by) = match walk.step(most - walked) {
                Ok(step) => step,
                Err(StreamlineEnd::Boundary) => {
                    nodes.push(self.tracer.located(walk.state()));
                    return (nodes, StreamlineEnd::Boundary);
                }
                Err(end) => return (nodes, end),
            };
            paused = walk.paused();
            let state = paused.state;
            walked += by;
            let length = sign * walked;
            if sign > 0.0 && walked > 2.0 * self.separation && self.returns(&seed, &state) {
                return (nodes, StreamlineEnd::Closed);
            }
            if !self.has_room(&state, CLOSE * self.separation, number, length) {
                return (nodes, StreamlineEnd::Neighbor);
            }
            nodes.push(node);
            visited.push((state, length));
            self.add(&state, number, length);
            if walked >= most {
                return (nodes, StreamlineEnd::Length);
            }
        }
    }

    /// Whether a line comes back to its seed: it is little behind it, and hardly beside it.
    fn returns(&self, seed: &State, state: &State) -> bool {
        let [p, q] = [seed, state].map(|s| self.tracer.position(s));
        let [[t, _], [u, _]] = [seed, state].map(|s| self.tracer.frame(s));
        let ahead = dot(sub(p, q), t);
        let beside = distance(p, q).powi(2) - ahead * ahead;
        (0.0..0.75 * self.separation).contains(&ahead)
            && beside < (BESIDE * self.separation).powi(2)
            && dot(t, u) > 0.9
    }

    fn sample(&self, state: &State, line: u32, length: f64) -> Sample {
        let position = self.tracer.position(state);
        let [along, normal] = self.tracer.frame(state);
        Sample { position, along, normal, line, length }
    }

    fn cell(&self, position: [f64; 3]) -> Cell {
        position.map(|x| (x / self.separation).floor() as i64)
    }

    fn add(&mut self, state: &State, line: u32, length: f64) {
        let sample = self.sample(state, line, length);
        self.cells.entry(self.cell(sample.position)).or_default().push(sample);
    }

    fn remove(&mut self, line: u32, visited: &[(State, f64)]) {
        for (state, _) in visited {
            let cell = self.cell(self.tracer.position(state));
            if let Some(samples) = self.cells.get_mut(&cell) {
                samples.retain(|sample| sample.line != line);
            }
        }
    }

    /// Whether no line of about the same direction is closer than this.
    fn has_room(&self, state: &State, within: f64, line: u32, length: f64) -> bool {
        let own = self.sample(state, line, length);
        let [x, y, z] = self.cell(own.position);
        let is_near = |other: &Sample| {
            (other.line != line || (other.length - length).abs() > OWN * self.separation)
                && distance(own.position, other.position) < within
                && dot(own.normal, other.normal) > SAME_SHEET
                && dot(own.along, other.along).abs() >= self.parallel
        };
        let around =
            (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        !around.filter_map(|cell| self.cells.get(&cell)).flatten().any(is_near)
    }
}
