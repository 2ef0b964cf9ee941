//! Contradictions between the lines of a scene, whichever grammar it is written in.

use super::faults::{Faults, once};
use super::model::{Goal, Growth, ObstacleShape, Scene, Target};
use std::collections::HashMap;

/// Adds what contradicts itself.
pub fn contradictions(scene: &Scene, faults: &mut Faults) {
    pinned_twice(scene, faults);
    minimised_twice(scene, faults);
    goal_without_obstacle(scene, faults);
}

fn pinned_twice(scene: &Scene, faults: &mut Faults) {
    let mut lines = HashMap::new();
    for pin in &scene.constraints.pins {
        if let Some(earlier) = lines.insert(pin.value.vertex, pin.line) {
            let what = format!("pin of vertex {}", pin.value.vertex);
            faults.take(pin.line, once(Some(earlier), pin.line, &what));
        }
    }
}

fn minimised_twice(scene: &Scene, faults: &mut Faults) {
    for (i, term) in scene.terms.iter().enumerate() {
        let quantity = term.value.quantity;
        let earlier = scene.terms[..i].iter().find(|earlier| earlier.value.quantity == quantity);
        let what = format!("minimize {}", quantity.name());
        faults.take(term.line, once(earlier.map(|earlier| earlier.line), term.line, &what));
    }
}

/// A volume that is to become that of an obstacle needs exactly one.
fn goal_without_obstacle(scene: &Scene, faults: &mut Faults) {
    let Some(volume) = scene.constraints.volume else { return };
    let Target::Growth(Growth { goal: Goal::Obstacle { .. }, .. }) = volume.value else { return };
    let meshes = scene.obstacles.iter().filter(|o| matches!(o.value.shape, ObstacleShape::Mesh { .. }));
    let lines: Vec<String> = meshes.map(|obstacle| obstacle.line.to_string()).collect();
    match lines.as_slice() {
        [_] => {}
        // Unless the line that adds it is at fault.
        [] if !faults.is_empty() => {}
        [] => faults.add(
            volume.line,
            "the volume is to become that of an obstacle, but there is no obstacle mesh; add one",
        ),
        several => faults.add(
            volume.line,
            format!(
                "the volume is to become that of an obstacle, but there are {} obstacle meshes (lines {}); \
                 keep one",
                several.len(),
                several.join(", ")
            ),
        ),
    }
}
