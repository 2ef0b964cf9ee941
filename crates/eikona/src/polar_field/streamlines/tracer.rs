//! Steps of a streamline in faces and across edges.

use crate::geometry::{Triangle, unit_of};
use crate::polar_field::bevel::wrapped;
use crate::polar_field::field::polar;
use crate::polar_field::solution::PolarField;
use crate::polar_field::streamlines::StreamlineEnd;
use eikona_mesh::{Face, Halfedge, Located};
use eikona_numeric::{Complex, Scalar};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Longest step relative to the root of the area of a face.
const STEP: f64 = 0.3;
/// Longest step relative to the distance from the zero of the field.
const NEAR_ZERO: f64 = 0.2;
/// Distance from a singular point, relative to the size of the face, at which a line ends.
const REACHED: f64 = 1e-3;
/// Crossings stay this far from vertices, relative to the edge.
const ASIDE: f64 = 1e-6;
/// A step that leaves through the side it is on before this share of it leads out of the face.
const AT_ONCE: f64 = 1e-6;
/// Most slides along edges in a row.
const MOST_SLIDES: usize = 32;
/// Most steps of a walk.
const MOST_STEPS: usize = 1 << 20;
/// A walk is trapped if this many steps together are shorter than a share of the size of the face.
const PATIENCE: usize = 1024;
const PROGRESS: f64 = 0.01;

/// A point in the layout of a face, and a direction there.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub face: Face,
    pub point: Complex,
    /// Angle in the layout of the face.
    pub angle: f64,
    /// Whether the walk runs against one of the N directions. If N is odd, its own direction is
    /// none of them.
    pub against: bool,
}

impl State {
    pub fn turned(self, by: f64) -> State {
        State { angle: self.angle + by, ..self }
    }

    /// Returns the same point with the opposite direction along the line.
    pub fn reversed(self) -> State {
        State { against: !self.against, ..self.turned(PI) }
    }
}

/// The field, ready to be followed.
pub(super) struct Tracer<'a> {
    pub field: &'a PolarField,
    /// Longest step, in the unit of the layouts.
    longest: f64,
    /// The unit of the layouts.
    pub unit: f64,
    /// The singular points in each face.
    singular: HashMap<Face, Vec<Complex>>,
}

impl<'a> Tracer<'a> {
    pub fn new(field: &'a PolarField, longest: f64) -> Tracer<'a> {
        let bevel = &field.domain.bevel;
        let mut singular: HashMap<Face, Vec<Complex>> = HashMap::new();
        for (s, _) in field.singular_points() {
            for face in s.faces(&bevel.mesh) {
                if let Some(weights) = s.weights_in_face(&bevel.mesh, face) {
                    singular.entry(face).or_default().push(bevel.triangles[face.index()].point(weights));
                }
            }
        }
        Tracer { field, longest, unit: unit_of(&bevel.mesh), singular }
    }

    fn triangle(&self, face: Face) -> &Triangle {
        &self.field.domain.bevel.triangles[face.index()]
    }

    /// Returns the state at a place, in that of the N directions; `None` where the field vanishes.
    pub fn start(&self, place: Located, direction: u32) -> Option<State> {
        let bevel = &self.field.domain.bevel;
        let face = *place.faces(&bevel.mesh).first()?;
        let weights = place.weights_in_face(&bevel.mesh, face)?;
        let power = self.field.values.power_at(face, weights);
        let n = f64::from(self.field.degree);
        let angle = (power.arg() + TAU * f64::from(direction)) / n;
        let point = self.triangle(face).point(weights);
        (power.norm() > 0.0).then_some(State { face, point, angle, against: false })
    }

    /// Returns the place of a state on the mesh.
    pub fn located(&self, state: &State) -> Located {
        let weights = weights_of(self.triangle(state.face), state.point);
        Located::in_face(&self.field.domain.bevel.mesh, state.face, weights)
    }

    /// Returns the directions in space along a state, and normal to the surface.
    pub fn frame(&self, state: &State) -> [[f64; 3]; 2] {
        let [along, across, normal] = self.field.domain.bevel.frame(state.face);
        let (c, s) = (state.angle.cos(), state.angle.sin());
        [[0, 1, 2].map(|k| c * along[k] + s * across[k]), normal]
    }

    /// Returns the position of a state in space, in the unit of the layouts.
    pub fn position(&self, state: &State) -> [f64; 3] {
        self.located(state).position(&self.field.domain.bevel.mesh).map(|x| x / self.unit)
    }

    pub fn walk(&self, state: State) -> Walk<'_> {
        self.resumed(Paused { state, steps: 0, recent: 0.0, slides: 0, side: None })
    }

    /// Goes on with a walk.
    pub fn resumed(&self, paused: Paused) -> Walk<'_> {
        Walk { tracer: self, paused }
    }

    /// Whether a step has come back to where a walk began.
    pub fn is_back(&self, start: &State, now: &State, step: f64) -> bool {
        start.face == now.face
            && (start.point - now.point).norm() <= 0.75 * step
            && wrapped(start.angle - now.angle).abs() < 0.1
    }

    /// Returns the direction at the point of a state that is nearest to its angle: one of the N
    /// directions, or the opposite of one.
    fn direction(&self, state: &State) -> f64 {
        let (base, m) = self.base(state.face, state.point);
        let n = f64::from(self.field.degree);
        let reverse = if state.against { n * PI } else { 0.0 };
        state.angle + wrapped(m * base.arg() + reverse - n * state.angle) / n
    }

    /// The linear field at a point of a face, and its power.
    fn base(&self, face: Face, point: Complex) -> (Complex, f64) {
        let values = &self.field.values;
        let weights = weights_of(self.triangle(face), point);
        let sum =
            (0..3).fold(Complex::ZERO, |sum, k| sum + values.base[face.halfedge(k).index()] * weights[k]);
        (sum, f64::from(values.powers[face]))
    }

    /// A lower bound of the distance from the zero of the linear field.
    fn distance_from_zero(&self, face: Face, point: Complex) -> f64 {
        let b = [0, 1, 2].map(|k| self.field.values.base[face.halfedge(k).index()]);
        let triangle = self.triangle(face);
        // The largest change per length is at most the sum over two sides at the first corner.
        let height = |side: usize| 2.0 * triangle.area / triangle.lengths[side];
        let slope = (b[1] - b[0]).norm() / height(2) + (b[2] - b[0]).norm() / height(0);
        let size = self.base(face, point).0.norm();
        if slope > 0.0 { size / slope } else { f64::INFINITY }
    }

    /// Moves along the field in the plane of a face, by the classical Runge-Kutta step.
    fn moved(&self, state: &State, by: f64) -> State {
        let State { point, angle, .. } = *state;
        let direction = |point: Complex, angle: f64| self.direction(&State { point, angle, ..*state });
        let a1 = direction(point, angle);
        let a2 = direction(point + polar(0.5 * by, a1), a1);
        let a3 = direction(point + polar(0.5 * by, a2), a2);
        let a4 = direction(point + polar(by, a3), a3);
        let sum = polar(1.0, a1) + (polar(1.0, a2) + polar(1.0, a3)) * 2.0 + polar(1.0, a4);
        let to = point + sum * (by / 6.0);
        State { point: to, angle: direction(to, a4), ..*state }
    }
}

/// Barycentric coordinates of a point in the plane of a triangle.
pub(super) fn weights_of(triangle: &Triangle, point: Complex) -> [f64; 3] {
    let [_, b, c] = triangle.corners();
    let third = point.im / c.im;
    let second = (point.re - third * c.re) / b.re;
    [1.0 - second - third, second, third]
}

/// Where a walk is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paused {
    pub state: State,
    /// Steps so far.
    steps: usize,
    /// Length of the steps since their number was a multiple of [`PATIENCE`].
    recent: f64,
    /// Slides along edges, in a row.
    slides: usize,
    /// The side of the face on which the walk is.
    side: Option<usize>,
}

/// A walk along a streamline.
pub(super) struct Walk<'a> {
    tracer: &'a Tracer<'a>,
    paused: Paused,
}

impl Walk<'_> {
    pub fn state(&self) -> &State {
        &self.paused.state
    }

    pub fn paused(self) -> Paused {
        self.paused
    }

    /// Takes a step of at most this length, which ends inside the face or on its boundary. Returns
    /// the new node and the length of the step, or why there is no step.
    pub fn step(&mut self, most: f64) -> Result<(Located, f64), StreamlineEnd> {
        if self.paused.steps == MOST_STEPS {
            return Err(StreamlineEnd::Steps);
        }
        self.paused.steps += 1;
        let (node, by) = self.step_in_face(most)?;
        self.paused.recent += by;
        if self.paused.steps.is_multiple_of(PATIENCE) {
            // Directions that jump can lead around a vertex, or to and fro, forever.
            let size = self.tracer.triangle(self.paused.state.face).area.sqrt();
            if self.paused.recent < PROGRESS * size {
                return Err(StreamlineEnd::Trapped);
            }
            self.paused.recent = 0.0;
        }
        Ok((node, by))
    }

    fn step_in_face(&mut self, most: f64) -> Result<(Located, f64), StreamlineEnd> {
        let tracer = self.tracer;
        let face = self.paused.state.face;
        let triangle = tracer.triangle(face);
        let size = triangle.area.sqrt();
        if let Some(points) = tracer.singular.get(&face)
            && points.iter().any(|p| (*p - self.paused.state.point).norm() < REACHED * size)
        {
            return Err(StreamlineEnd::Singularity);
        }
        let from_zero = tracer.distance_from_zero(face, self.paused.state.point);
        if from_zero < REACHED * size {
            return Err(StreamlineEnd::Singularity);
        }
        let by = (STEP * size).min(NEAR_ZERO * from_zero).min(tracer.longest).min(most);
        let next = tracer.moved(&self.paused.state, by);
        let weights = weights_of(triangle, next.point);
        // The side that the walk is on must be left first; rounding may put it beyond.
        let outside = |w: [f64; 3]| {
            (0..3).filter(|&k| w[(k + 2) % 3] < 0.0).min_by(|a, b| w[(a + 2) % 3].total_cmp(&w[(b + 2) % 3]))
        };
        let Some(_) = outside(weights) else {
            self.paused.state = next;
            (self.paused.side, self.paused.slides) = (None, 0);
            return Ok((tracer.located(&self.paused.state), by));
        };
        let (side, share) = self.exit(by);
        let at_exit = tracer.moved(&self.paused.state, share * by);
        if self.paused.side == Some(side) && share <= 2.0 * AT_ONCE {
            return self.slide(side);
        }
        let by = share * by;
        self.cross(side, at_exit)?;
        Ok((tracer.located(&self.paused.state), by))
    }

    /// Returns the side through which a step leaves the face, and the share of the step before.
    fn exit(&self, by: f64) -> (usize, f64) {
        let triangle = self.tracer.triangle(self.paused.state.face);
        // A walk that leads away from the side it is on may be beyond that side by rounding.
        let left = self.paused.side.filter(|&side| self.leads_in(side)).map(|side| (side + 2) % 3);
        let lowest = |share: f64| {
            let point = self.tracer.moved(&self.paused.state, share * by).point;
            let mut w = weights_of(triangle, point);
            if let Some(corner) = left.filter(|_| share < AT_ONCE) {
                w[corner] = f64::INFINITY;
            }
            let k = (0..3).fold(0, |low, k| if w[k] < w[low] { k } else { low });
            (w[k], k)
        };
        let (mut inside, mut outside) = (0.0, 1.0);
        let (mut value, mut corner) = lowest(1.0);
        let mut before = lowest(0.0).0.max(0.0);
        // The Illinois method: false position, with the value of an end that stays halved.
        let mut stayed = 0;
        for _ in 0..60 {
            let guess = inside + (outside - inside) * before / (before - value);
            let share = if guess > inside && guess < outside { guess } else { 0.5 * (inside + outside) };
            let (w, k) = lowest(share);
            if w < 0.0 {
                (outside, value, corner) = (share, w, k);
                before *= if stayed == 1 { 0.5 } else { 1.0 };
                stayed = 1;
            } else {
                (inside, before) = (share, w);
                value *= if stayed == 2 { 0.5 } else { 1.0 };
                stayed = 2;
            }
            if outside - inside < 1e-13 || (-1e-14..=0.0).contains(&value) && stayed == 1 {
                break;
            }
        }
        ((corner + 1) % 3, outside)
    }

    /// Returns whether the direction at the walk's point leads from a side into the face.
    fn leads_in(&self, side: usize) -> bool {
        let along = self.tracer.triangle(self.paused.state.face).directions()[side];
        (polar(1.0, self.paused.state.angle) * along.conj()).im > 0.0
    }

    /// Goes on in the face beyond a side.
    fn cross(&mut self, side: usize, at: State) -> Result<(), StreamlineEnd> {
        let tracer = self.tracer;
        let bevel = &tracer.field.domain.bevel;
        let h = at.face.halfedge(side);
        let weights = weights_of(tracer.triangle(at.face), at.point);
        let along =
            (weights[(side + 1) % 3] / (weights[side] + weights[(side + 1) % 3])).clamp(ASIDE, 1.0 - ASIDE);
        let Some(twin) = bevel.twin[h] else {
            let end = on_side(h, along);
            self.paused.state.point = tracer.triangle(at.face).point(end);
            return Err(StreamlineEnd::Boundary);
        };
        let turn = |h: Halfedge| tracer.triangle(h.face()).directions()[h.side()];
        let angle = at.angle + (-turn(twin) * turn(h).conj()).arg();
        let face = twin.face();
        let point = tracer.triangle(face).point(on_side(twin, 1.0 - along));
        let state = State { face, point, angle, ..at };
        self.paused.state = State { angle: tracer.direction(&state), ..state };
        self.paused.side = Some(twin.side());
        Ok(())
    }

    /// Moves along the side that the walk is on, if the directions in both faces lead to it.
    fn slide(&mut self, side: usize) -> Result<(Located, f64), StreamlineEnd> {
        self.paused.slides += 1;
        if self.paused.slides > MOST_SLIDES {
            return Err(StreamlineEnd::Trapped);
        }
        let tracer = self.tracer;
        let triangle = tracer.triangle(self.paused.state.face);
        let ahead = (polar(1.0, self.paused.state.angle) * triangle.directions()[side].conj()).re;
        let h = self.paused.state.face.halfedge(side);
        let w = weights_of(triangle, self.paused.state.point);
        let along = w[(side + 1) % 3] / (w[side] + w[(side + 1) % 3]);
        let to = (along + 0.1 * ahead.signum()).clamp(ASIDE, 1.0 - ASIDE);
        // A little inside the face, so that the next step can leave the side.
        let mut weights = on_side(h, to);
        weights[(side + 2) % 3] = ASIDE;
        weights[side] = (weights[side] - ASIDE).max(0.0);
        let by = (to - along).abs() * triangle.lengths[side];
        if by == 0.0 {
            return Err(StreamlineEnd::Trapped);
        }
        self.paused.state.point = triangle.point(weights);
        self.paused.state.angle = tracer.direction(&self.paused.state);
        self.paused.side = None;
        Ok((tracer.located(&self.paused.state), by))
    }

    /// Walks straight on for some distance, by unfolding. `None` if the boundary is in the way.
    pub fn straight(mut self, distance: f64) -> Option<State> {
        let mut left = distance;
        loop {
            let triangle = self.tracer.triangle(self.paused.state.face);
            let [from, to] = [0.0, left]
                .map(|by| weights_of(triangle, self.paused.state.point + polar(by, self.paused.state.angle)));
            let leaves = (0..3)
                .filter(|&k| to[k] < 0.0 && self.paused.side.is_none_or(|side| (side + 2) % 3 != k))
                .map(|k| (from[k].max(0.0) / (from[k].max(0.0) - to[k]), k))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((share, corner)) = leaves else {
                self.paused.state.point += polar(left, self.paused.state.angle);
                return Some(self.paused.state);
            };
            let angle = self.paused.state.angle;
            let at =
                State { point: self.paused.state.point + polar(share * left, angle), ..self.paused.state };
            let (h, side) = (self.paused.state.face.halfedge((corner + 1) % 3), (corner + 1) % 3);
            let twin = self.tracer.field.domain.bevel.twin[h]?;
            left *= 1.0 - share;
            self.cross(side, at).ok()?;
            let turn = |h: Halfedge| self.tracer.triangle(h.face()).directions()[h.side()];
            self.paused.state.angle = angle + (-turn(twin) * turn(h).conj()).arg();
        }
    }
}

/// Barycentric coordinates of a point along a halfedge.
fn on_side(h: Halfedge, along: f64) -> [f64; 3] {
    let mut weights = [0.0; 3];
    weights[h.side()] = 1.0 - along;
    weights[(h.side() + 1) % 3] = along;
    weights
}
