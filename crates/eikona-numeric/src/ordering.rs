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
    /// Nested dissection by planes, for unknowns that have a place in space. See the benchmark `ordering` for the choice.
    Dissection {
        /// A place for each unknown.
        places: &'a [[f64; 3]],
    },
}

impl Ordering<'_> {
    /// The unknowns in order of elimination.
    pub(crate) fn order(&self, graph: &Graph, adjacency: &Adjacency) -> Result<Vec<u32>, NumericError> {
        match self {
            Ordering::Dissection { places } if places.len() != graph.unknowns => {
                Err(NumericError::WrongLength { found: places.len(), expected: graph.unknowns })
            }
            Ordering::Dissection { places } => Ok(nested_dissection(adjacency, places)),
            Ordering::MinimumDegree => minimum_degree(graph.unknowns, adjacency),
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
