//! A signed distance given by samples on a regular grid.

use super::surface::Vec3;
use crate::geometry::vector::{norm, scale};
use crate::repulsive::error::RepulsiveError;
use std::sync::Arc;

/// A signed distance sampled on a regular grid, trilinear between the samples. Cheap to clone.
///
/// Outside of the grid's box, its size grows by the distance from the box, and its sign is that at
/// the closest point of the box.
///
/// ```
/// use eikona::repulsive::SampledDistance;
/// // x - 1 on the cube from 0 to 2.
/// let plane = |k: usize| (k / 9) as f64 - 1.0;
/// let values: Vec<f64> = (0..27).map(plane).collect();
/// let distance = SampledDistance::new([0.0; 3], [1.0; 3], [3; 3], values)?;
/// assert_eq!(distance.at([1.75, 0.25, 0.5]), (0.75, [1.0, 0.0, 0.0]));
/// assert_eq!(distance.at([3.0, 0.5, 0.5]), (2.0, [1.0, 0.0, 0.0]));
/// assert_eq!(distance.at([-1.0, 0.5, 0.5]), (-2.0, [1.0, 0.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SampledDistance {
    origin: Vec3,
    spacing: Vec3,
    shape: [usize; 3],
    values: Arc<Vec<f64>>,
}

impl SampledDistance {
    /// Takes `shape = [nx, ny, nz]` samples, of which that at
    /// `origin + [i, j, k] * spacing` is `values[(i * ny + j) * nz + k]`: row-major, like an array
    /// of NumPy. Values are negative inside.
    ///
    /// # Errors
    /// [`RepulsiveError::GridShape`] if there are fewer than two samples along an axis, or another
    /// number of values; [`RepulsiveError::GridValue`] if a value is not finite;
    /// [`RepulsiveError::ImplicitShape`] unless the origin is finite and the spacing positive.
    ///
    /// ```
    /// use eikona::repulsive::{RepulsiveError, SampledDistance};
    /// let fault = SampledDistance::new([0.0; 3], [1.0; 3], [2; 3], vec![0.0; 7]).unwrap_err();
    /// assert_eq!(fault, RepulsiveError::GridShape { shape: [2; 3], values: 7 });
    /// ```
    pub fn new(
        origin: [f64; 3],
        spacing: [f64; 3],
        shape: [usize; 3],
        values: Vec<f64>,
    ) -> Result<SampledDistance, RepulsiveError> {
        let count = shape.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        if shape.iter().any(|&n| n < 2) || count != Some(values.len()) {
            return Err(RepulsiveError::GridShape { shape, values: values.len() });
        }
        for k in 0..3 {
            let end = origin[k] + spacing[k] * (shape[k] - 1) as f64;
            if !(spacing[k] > 0.0 && spacing[k].is_finite()) {
                return Err(RepulsiveError::ImplicitShape {
                    what: "the spacing of a grid",
                    value: spacing[k],
                });
            }
            if !(origin[k].is_finite() && end.is_finite()) {
                return Err(RepulsiveError::ImplicitShape { what: "the origin of a grid", value: origin[k] });
            }
        }
        if let Some(bad) = values.iter().position(|x| !x.is_finite()) {
            let sample = [bad / (shape[1] * shape[2]), bad / shape[2] % shape[1], bad % shape[2]];
            return Err(RepulsiveError::GridValue { sample, value: values[bad] });
        }
        Ok(SampledDistance { origin, spacing, shape, values: Arc::new(values) })
    }

    /// Returns the distance at a point and its gradient, which are not numbers if the point's
    /// coordinates are none.
    ///
    /// The gradient jumps at the faces of the grid's cells; there it is that of one of them.
    pub fn at(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let places = [0, 1, 2].map(|k| self.place(k, point[k]));
        let (value, mut gradient) = self.interpolated(places);
        let away = places.map(|place| place.beyond);
        let far = norm(away);
        if far == 0.0 {
            return (value, gradient);
        }
        let sign = if value < 0.0 { -1.0 } else { 1.0 };
        let outwards = scale(away, sign / far);
        for k in 0..3 {
            // The closest point of the box does not follow across its sides.
            gradient[k] = if away[k] == 0.0 { gradient[k] } else { outwards[k] };
        }
        (value + sign * far, gradient)
    }

    /// The value at the closest point of the box: its sign is that of [`at`](Self::at), and it
    /// changes by at most [`steepest`](Self::steepest) per length, outside of the box too.
    pub(super) fn in_box(&self, point: [f64; 3]) -> f64 {
        self.interpolated([0, 1, 2].map(|k| self.place(k, point[k]))).0
    }

    /// A bound of the slope: in each cell, derivatives are means of differences along edges.
    pub(super) fn steepest(&self) -> f64 {
        let [nx, ny, nz] = self.shape;
        let value = |i: usize, j: usize, k: usize| self.values[(i * ny + j) * nz + k];
        let mut steepest = 0.0f64;
        for i in 0..nx - 1 {
            for j in 0..ny - 1 {
                for k in 0..nz - 1 {
                    let mut slopes = [0.0f64; 3];
                    for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        let differences = [
                            value(i + 1, j + a, k + b) - value(i, j + a, k + b),
                            value(i + a, j + 1, k + b) - value(i + a, j, k + b),
                            value(i + a, j + b, k + 1) - value(i + a, j + b, k),
                        ];
                        (0..3).for_each(|axis| slopes[axis] = slopes[axis].max(differences[axis].abs()));
                    }
                    steepest = steepest.max(norm([0, 1, 2].map(|axis| slopes[axis] / self.spacing[axis])));
                }
            }
        }
        steepest
    }

    fn place(&self, axis: usize, x: f64) -> Place {
        let cells = self.shape[axis] - 1;
        let along = (x - self.origin[axis]) / self.spacing[axis];
        let inside = along.clamp(0.0, cells as f64);
        let cell = (inside as usize).min(cells - 1);
        let outside = along < 0.0 || along > cells as f64;
        let end = self.origin[axis] + inside * self.spacing[axis];
        Place { cell, share: inside - cell as f64, beyond: if outside { x - end } else { 0.0 } }
    }

    fn interpolated(&self, places: [Place; 3]) -> (f64, Vec3) {
        let (mut value, mut gradient) = (0.0, [0.0; 3]);
        for corner in 0..8 {
            let upper = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [i, j, k] = [0, 1, 2].map(|axis| places[axis].cell + upper[axis]);
            let sample = self.values[(i * self.shape[1] + j) * self.shape[2] + k];
            let weight = [0, 1, 2].map(|axis| {
                let share = places[axis].share;
                if upper[axis] == 1 { share } else { 1.0 - share }
            });
            value += sample * weight[0] * weight[1] * weight[2];
            for axis in 0..3 {
                let slope = if upper[axis] == 1 { 1.0 } else { -1.0 } / self.spacing[axis];
                gradient[axis] += sample * slope * weight[(axis + 1) % 3] * weight[(axis + 2) % 3];
            }
        }
        (value, gradient)
    }
}

/// Where a coordinate lies on an axis of the grid.
#[derive(Clone, Copy, Debug)]
struct Place {
    cell: usize,
    /// How far in the cell, from 0 to 1.
    share: f64,
    /// How far outside of the box, with sign.
    beyond: f64,
}
