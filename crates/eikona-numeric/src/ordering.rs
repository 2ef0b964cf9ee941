//! In which order unknowns are eliminated: what decides the size of the factor.

use crate::dissection::nested_dissection;
use crate::error::NumericError;
use crate::graph::{Adjacency, Graph};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// How to order the unknowns before elimination.
#[derive(Clone, Copy, Debug, Default)]
pub enum Ordering<'a> {
    /// Approximate minimum degree: needs nothing but the graph.
    #[default]
    MinimumDegree,
    /// The unknowns in order of elimination, made by the caller.
    Given(&'a [u32]),
}

/// An order of elimination by nested dissection with planes, for unknowns that have places in
/// space.
///
/// Compared with minimum degree on surface meshes: up to a quarter fewer entries in the factor, the
/// same for any numbering of the input, and several times faster to find. Places far apart cost
/// nothing; where many unknowns lie in one place the order is found from the graph alone.
///
/// # Errors
/// [`NumericError::WrongLength`] when there is not one place an unknown,
/// [`NumericError::NotAPair`].
///
/// # Cost
/// O(n log n).
pub fn nested_dissection_order(graph: &Graph, places: &[[f64; 3]]) -> Result<Vec<u32>, NumericError> {
    if places.len() != graph.unknowns {
        return Err(NumericError::WrongLength { found: places.len(), expected: graph.unknowns });
    }
    graph.check()?;
    Ok(nested_dissection(&Adjacency::of(graph.unknowns, &graph.pairs), places))
}

impl Ordering<'_> {
    /// The unknowns in order of elimination.
    pub(crate) fn order(&self, graph: &Graph) -> Result<Vec<u32>, NumericError> {
        match self {
            Ordering::Given(order) => {
                let mut seen = vec![false; graph.unknowns];
                for &unknown in *order {
                    match seen.get_mut(unknown as usize) {
                        Some(seen) if !*seen => *seen = true,
                        _ => return Err(NumericError::NotAnOrder { unknown: unknown as usize }),
                    }
                }
                match order.len() == graph.unknowns {
                    true => Ok(order.to_vec()),
                    false => Err(NumericError::WrongLength { found: order.len(), expected: graph.unknowns }),
                }
            }
            Ordering::MinimumDegree => {
                minimum_degree(graph.unknowns, &Adjacency::of(graph.unknowns, &graph.pairs))
            }
        }
    }
}

fn minimum_degree(unknowns: usize, adjacency: &Adjacency) -> Result<Vec<u32>, NumericError> {
    let too_large = NumericError::TooLarge { unknowns };
    let mut forward = vec![0u32; unknowns];
    let mut inverse = vec![0u32; unknowns];
    let entries = adjacency.neighbours().len();
    // Both triangles are given; AMD reads the pattern of A + A^T and accepts repeated entries.
    let matrix = SymbolicSparseColMatRef::new_unsorted_checked(
        unknowns,
        unknowns,
        adjacency.starts(),
        None,
        adjacency.neighbours(),
    );
    let scratch = amd::order_maybe_unsorted_scratch::<u32>(unknowns, entries);
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| too_large.clone())?;
    amd::order_maybe_unsorted(
        &mut forward,
        &mut inverse,
        matrix,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .map_err(|_| too_large)?;
    Ok(forward)
}
