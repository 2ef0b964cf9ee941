//! Choice of the diffusion time (SHM section 6).

use crate::geometry::{Triangle, mean_edge_length};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::options::DiffusionTime;
use eikona_mesh::TriangleMesh;

/// Diffusion time of a solver, and the reason for it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenTime {
    /// Diffusion time `t`, a squared length.
    pub time: f64,
    /// `t` in units of `h^2`.
    pub coefficient: f64,
    /// Spacing `h`: half the mean edge length, the mean distance between edge midpoints (SHM
    /// section 6).
    pub edge_spacing: f64,
    /// The reason, as a phrase for the user.
    pub reason: String,
}

/// Coefficients that [`DiffusionTime::Coefficient`] allows. Below this range, nothing diffuses
/// beyond the edges of the source; above it, the mass matrix is lost to rounding of the Laplacian.
pub const TIME_COEFFICIENTS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

pub(crate) fn choose_time(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    wanted: DiffusionTime,
) -> Result<ChosenTime, SignedHeatError> {
    let edge_spacing = 0.5 * mean_edge_length(mesh, triangles);
    let (coefficient, reason) = match wanted {
        DiffusionTime::Coefficient(c) if TIME_COEFFICIENTS.contains(&c) => {
            (c, "the given coefficient".to_string())
        }
        DiffusionTime::Coefficient(value) => {
            return Err(SignedHeatError::Option {
                name: "time coefficient",
                value,
                bound: "from 1e-9 to 1e9",
            });
        }
        DiffusionTime::Automatic => of_size(triangles, edge_spacing, SHARE_OF_SIZE),
        DiffusionTime::SmoothCurves => of_size(triangles, edge_spacing, SHARE_FOR_SMOOTH_CURVES),
        DiffusionTime::ForGaps => (GAPS_COEFFICIENT, "automatic: the curves have large gaps".to_string()),
        DiffusionTime::ForRoughGaps => {
            (ROUGH_GAPS_COEFFICIENT, "automatic: the curves have large gaps and are rough".to_string())
        }
    };
    Ok(ChosenTime { time: coefficient * edge_spacing * edge_spacing, coefficient, edge_spacing, reason })
}

// Deviation: the paper uses 1 for all curves. These values are measured by
// `examples/broken_curves`.
const GAPS_COEFFICIENT: f64 = 1.5;
const ROUGH_GAPS_COEFFICIENT: f64 = 5.0;

/// Coefficients for curves without gaps, relative to the size of the surface over the spacing.
/// Errors on circles fall with larger values, but in general the distance has ridges, which
/// diffusion rounds: with 0.1, the errors of the whole curves of `examples/broken_curves` are twice
/// as large.
const SHARE_OF_SIZE: f64 = 0.005;
const SHARE_FOR_SMOOTH_CURVES: f64 = 0.1;

/// Returns `share` of the size over the spacing, but at least 1, and the reason.
fn of_size(triangles: &[Triangle], spacing: f64, share: f64) -> (f64, String) {
    let size = triangles.iter().map(|t| t.area).sum::<f64>().sqrt();
    let coefficient = share * size / spacing;
    if coefficient < 1.0 {
        return (1.0, "automatic: the paper's coefficient, for curves with no or small gaps".to_string());
    }
    let reason = format!(
        "automatic, for curves with no or small gaps: {share} of the surface's size (square root of its area, {size:.6e}) over the edge \
         spacing {spacing:.6e}"
    );
    (coefficient, reason)
}
