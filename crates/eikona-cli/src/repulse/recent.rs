//! Whether the last steps got anywhere.

use eikona::repulsive::{Flow, FlowOptions};
use eikona_mesh::{TriangleMesh, counted};
use std::collections::VecDeque;

/// So many steps have to get somewhere.
pub const PATIENCE: usize = 10;
/// By this share they have to lower the objective.
const PROGRESS: f64 = 1e-3;
/// Together they have to bring this much of what one step should bring. (In the example scenes that
/// reach their targets, each step brings all of it.)
const LEAST_GROWTH: f64 = 0.5;

/// The last steps.
#[derive(Default)]
pub struct Recent {
    /// The objective after each of them and how much grew in it. The first is where they started.
    steps: VecDeque<(f64, f64)>,
}

impl Recent {
    /// Adds a step, or the start.
    pub fn push(&mut self, objective: f64, growth: f64) {
        self.steps.push_back((objective, growth));
        if self.steps.len() > PATIENCE + 1 {
            self.steps.pop_front();
        }
    }

    /// Whether enough steps lowered the objective by little, compared with a value.
    fn rests(&self, size: f64) -> bool {
        let ends = self.steps.front().zip(self.steps.back());
        self.steps.len() > PATIENCE && ends.is_some_and(|(from, to)| from.0 - to.0 < PROGRESS * size)
    }

    /// Whether a surface on which nothing grows any more has come to rest.
    pub fn settled(&self, flow: &Flow) -> bool {
        !flow.is_growing() && self.rests(flow.energy())
    }

    /// Whether what should grow or move does not, and the surface does not make room for it either.
    pub fn blocked(&self, flow: &Flow) -> bool {
        let grown: f64 = self.steps.iter().skip(1).map(|(_, growth)| growth).sum();
        flow.is_growing() && grown < LEAST_GROWTH && self.rests(flow.objective().abs())
    }
}

/// Says what is blocked, how far it got, and what to do.
pub fn blocked_sentence(
    start: &TriangleMesh,
    options: &FlowOptions,
    flow: &Flow,
    self_distance: f64,
) -> String {
    let schedules = options.growth.iter().map(|growth| growth.steps);
    let moving = || options.pins.iter().filter(|pin| pin.motion != [0.0; 3]);
    let longest = schedules.chain(moving().map(|pin| pin.steps)).max().unwrap_or(0);
    let time = flow.growth_done() * longest as f64;
    let mut parts: Vec<String> = Vec::new();
    for growth in options.growth.iter().filter(|growth| time < growth.steps as f64) {
        let [from, now] = [start, flow.mesh()].map(|mesh| growth.quantity.of(mesh));
        let target = growth.times * from + growth.plus;
        let share = 100.0 * time / growth.steps as f64;
        let quantity = growth.quantity;
        parts.push(format!(
            "the {quantity} went from {from:.5} to {now:.5}, {share:.1} % of the way to {target:.5}"
        ));
    }
    let waiting: Vec<u64> = moving().map(|pin| pin.steps).filter(|steps| time < *steps as f64).collect();
    if let Some(slowest) = waiting.iter().max() {
        let pins = counted(waiting.len(), "moving pin", "moving pins");
        let share = 100.0 * time / *slowest as f64;
        parts.push(format!("{pins} went {share:.1} % of the way"));
    }
    format!(
        "blocked: {}, and further steps bring no more (self-distance {self_distance:.1e}); ask for a target that \
         leaves more room, give it more steps, weaken obstacles, or remesh to shorter edges",
        parts.join("; ")
    )
}
