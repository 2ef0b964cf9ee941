//! Values on the elements of a mesh, indexed by typed element ids.

use crate::id::{Corner, Edge, ElementId, Face, Halfedge, Vertex};
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

/// One value of type `T` for each element of kind `I`.
///
/// ```
/// use eikona_mesh::{Vertex, VertexField};
/// let height = VertexField::from(vec![0.0, 0.5, 1.0]);
/// assert_eq!(height[Vertex(2)], 1.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Field<I, T> {
    values: Vec<T>,
    kind: PhantomData<fn(I)>,
}

/// One value per vertex.
pub type VertexField<T> = Field<Vertex, T>;
/// One value per edge.
pub type EdgeField<T> = Field<Edge, T>;
/// One value per halfedge.
pub type HalfedgeField<T> = Field<Halfedge, T>;
/// One value per face corner.
pub type CornerField<T> = Field<Corner, T>;
/// One value per face.
pub type FaceField<T> = Field<Face, T>;

impl<I: ElementId, T> Field<I, T> {
    /// Returns the number of elements.
    pub fn len(&self) -> usize {
        self.values.len()
    }
    /// Returns whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
    /// Returns the values in the order of the elements.
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }
    /// Returns the values in the order of the elements, mutably.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.values
    }
    /// Returns the values in the order of the elements, consuming the field.
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }
    /// Iterates over pairs of element and value.
    pub fn iter(&self) -> impl Iterator<Item = (I, &T)> {
        self.values.iter().enumerate().map(|(i, v)| (I::from_index(i), v))
    }
    /// Returns the value of an element, or `None` if the mesh has no such element.
    pub fn get(&self, element: I) -> Option<&T> {
        self.values.get(element.index())
    }
}

impl<I: ElementId, T: Clone> Field<I, T> {
    /// Creates a field with the same value everywhere.
    pub fn constant(count: usize, value: T) -> Self {
        vec![value; count].into()
    }
}

impl<I, T> From<Vec<T>> for Field<I, T> {
    fn from(values: Vec<T>) -> Self {
        Field { values, kind: PhantomData }
    }
}

impl<I: ElementId, T> Index<I> for Field<I, T> {
    type Output = T;
    #[inline]
    fn index(&self, element: I) -> &T {
        &self.values[element.index()]
    }
}

impl<I: ElementId, T> IndexMut<I> for Field<I, T> {
    #[inline]
    fn index_mut(&mut self, element: I) -> &mut T {
        &mut self.values[element.index()]
    }
}
