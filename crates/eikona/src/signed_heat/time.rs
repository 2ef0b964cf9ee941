//! How long to diffuse.

use crate::geometry::{Triangle, mean_edge_length};
use crate::signed_heat::error::SignedHeatError;
use crate::signed_heat::options::DiffusionTime;
use eikona_mesh::TriangleMesh;

/// The diffusion time of a solver, and why it is that.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenTime {
    /// `t`, a squared length.
    pub time: f64,
    /// `t` in units of `h^2`.
    pub coefficient: f64,
    /// `h`: half the mean edge length, the mean distance between edge midpoints (SHM section 6).
    pub edge_spacing: f64,
    /// Why this time, in a sentence.
    pub reason: String,
}

/// The coefficients that [`DiffusionTime::Coefficient`] allows. Below, nothing leaves the edges of
/// the source; above, the mass matrix drowns in the rounding of the Laplacian.
pub const TIME_COEFFICIENTS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

pub(crate) fn choose_time(
    mesh: &TriangleMesh,
    triangles: &[Triangle],
    wanted: DiffusionTime,
) -> Result<ChosenTime, SignedHeatError> {
    let edge_spacing = 0.5 * mean_edge_length(mesh, triangles);
    let (coefficient, reason) = match wanted {
        DiffusionTime::Coefficient(c) if TIME_COEFFICIENTS.contains(&c) => {
            (c, "the coefficient given".to_string())
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
        DiffusionTime::AutomaticForGaps => {
            (GAPS_COEFFICIENT, "automatic: much of the curves is missing".to_string())
        }
        DiffusionTime::AutomaticForRoughGaps => (
            ROUGH_GAPS_COEFFICIENT,
            "automatic: much of the curves is missing, and they are rough".to_string(),
        ),
    };
    Ok(ChosenTime { time: coefficient * edge_spacing * edge_spacing, coefficient, edge_spacing, reason })
}

// Deviation: the paper has 1 for all curves. These are measured by `examples/broken_curves`.
const GAPS_COEFFICIENT: f64 = 1.5;
const ROUGH_GAPS_COEFFICIENT: f64 = 5.0;

/// Shares of the size of the surface in the time. On circles errors fall with larger shares, but on
/// curves in general the distance has ridges, which diffusion rounds: with 0.1 the errors of the
/// whole curves of `examples/broken_curves` are twice as large.
const SHARE_OF_SIZE: f64 = 0.005;
const SHARE_FOR_SMOOTH_CURVES: f64 = 0.1;

/// `share` of the size over the spacing, but at least 1.
fn of_size(triangles: &[Triangle], spacing: f64, share: f64) -> (f64, String) {
    let size = triangles.iter().map(|t| t.area).sum::<f64>().sqrt();
    let coefficient = share * size / spacing;
    if coefficient < 1.0 {
        return (1.0, "automatic: the paper's, for curves of which little is missing".to_string());
    }
    let reason = format!(
        "automatic, for curves of which little is missing: {share} of the surface's size (square root of its area, {size:.6e}) over the edge \
         spacing {spacing:.6e}"
    );
    (coefficient, reason)
}
