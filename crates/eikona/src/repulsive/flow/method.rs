//! The descent methods.

use crate::option_name::option_names;
use crate::repulsive::metric::LocalOrder;

/// How the flow chooses the direction of a step.
///
/// All methods share constraints, line search, collision detection and remeshing. All but the first
/// are for comparison (RS section 8.2): their steps get shorter on finer meshes. The last one
/// descends another energy.
///
/// As text, they are named as in the scene files of the authors' program:
///
/// ```
/// use eikona::repulsive::Method;
/// let names = ["hs", "l2", "h1", "h2", "aqp", "h1-lbfgs", "bqn", "willmore"];
/// let methods = Method::ALL.map(|method| method.to_string());
/// assert_eq!(methods, names);
/// assert_eq!("h1-lbfgs".parse(), Ok(Method::H1Lbfgs));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum Method {
    /// Steepest descent in the fractional inner product of [`Metric`](crate::repulsive::Metric).
    #[default]
    #[serde(rename = "hs")]
    Fractional,
    /// Steepest descent in L2, with the lumped mass. Pins that move carry nothing along.
    #[serde(rename = "l2")]
    L2,
    /// Steepest descent in H1, with the cotan Laplacian and a small mass.
    #[serde(rename = "h1")]
    H1,
    /// Steepest descent in H2, with the bi-Laplacian: the Laplacian of H1, twice.
    #[serde(rename = "h2")]
    H2,
    /// Accelerated quadratic proxy: a step in H1 from a point beyond the surface, on the line from
    /// the previous one.
    ///
    /// Reference: Kovalsky, Galun and Lipman, *Accelerated Quadratic Proxy for Geometric
    /// Optimization*, 2016, algorithm 1 with kappa = 100.
    ///
    /// Deviations: constraints are projected onto, as in the other methods, instead of penalised;
    /// the extrapolation is shortened until it neither collides nor raises the objective. Without
    /// the latter, it runs into the barrier of the energy (RS figure 12).
    #[serde(rename = "aqp")]
    Aqp,
    /// L-BFGS that starts from the inverse of the Laplacian of H1, with the last 20 steps.
    ///
    /// Reference: Liu, Bouaziz and Kavan, *Quasi-Newton Methods for Real-time Simulation of
    /// Hyperelastic Materials*, 2017.
    ///
    /// Deviations: the inverse of the Laplacian is scaled to the last step, since it has another
    /// unit than the Hessian. Constraints are projected onto instead of penalised: the Schur
    /// complement is that of L-BFGS, and gradients are those of the Lagrangian.
    #[serde(rename = "h1-lbfgs")]
    H1Lbfgs,
    /// Blended quasi-Newton: L-BFGS where the change of the gradient is blended with that which the
    /// Laplacian predicts.
    ///
    /// Reference: Zhu, Bridson and Kaufman, *Blended Cured Quasi-Newton for Distortion
    /// Optimization*, 2018, section 4; without their barriers against inverted faces, as in RS.
    ///
    /// Deviations: those of [`H1Lbfgs`](Self::H1Lbfgs), and the Laplacian is scaled to the
    /// curvature of the objective along the step. The published scale is for elastic energies.
    #[serde(rename = "bqn")]
    Bqn,
    /// Steepest descent of the [Willmore energy](crate::repulsive::PotentialKind::Willmore) instead
    /// of the tangent-point energy, in H2 (RS figures 2 and 4). It is blind to surfaces that come
    /// close to each other: only collision detection keeps them apart, and surfaces may intersect
    /// at the start if that is off. Energies of steps are Willmore energies.
    #[serde(rename = "willmore")]
    Willmore,
}

option_names!(
    Method,
    "hs" => Method::Fractional,
    "l2" => Method::L2,
    "h1" => Method::H1,
    "h2" => Method::H2,
    "aqp" => Method::Aqp,
    "h1-lbfgs" => Method::H1Lbfgs,
    "bqn" => Method::Bqn,
    "willmore" => Method::Willmore,
);

/// What a method remembers of earlier steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Remembers {
    Nothing,
    /// The surface before the last step.
    Surface,
    /// Steps, and what they did to the gradient.
    Steps,
}

impl Method {
    /// All methods, the default first.
    pub const ALL: [Method; 8] = [
        Method::Fractional,
        Method::L2,
        Method::H1,
        Method::H2,
        Method::Aqp,
        Method::H1Lbfgs,
        Method::Bqn,
        Method::Willmore,
    ];

    /// The inner product; `None` for the fractional one.
    pub(super) fn local_order(self) -> Option<LocalOrder> {
        match self {
            Method::Fractional => None,
            Method::L2 => Some(LocalOrder::Zero),
            Method::H1 | Method::Aqp | Method::H1Lbfgs | Method::Bqn => Some(LocalOrder::One),
            Method::H2 | Method::Willmore => Some(LocalOrder::Two),
        }
    }

    pub(super) fn remembers(self) -> Remembers {
        match self {
            Method::Fractional | Method::L2 | Method::H1 | Method::H2 | Method::Willmore => {
                Remembers::Nothing
            }
            Method::Aqp => Remembers::Surface,
            Method::H1Lbfgs | Method::Bqn => Remembers::Steps,
        }
    }

    /// Whether steps depend on earlier ones.
    pub(super) fn has_history(self) -> bool {
        self.remembers() != Remembers::Nothing
    }
}
