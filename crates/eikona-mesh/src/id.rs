//! Typed element ids: a vertex index can not be used where a face index is meant.

use std::fmt;

/// An element of a mesh, named by its index. Implemented by [`Vertex`], [`Edge`], [`Halfedge`],
/// [`Corner`] and [`Face`].
pub trait ElementId: Copy + Eq + Ord + std::hash::Hash + fmt::Debug {
    /// The kind of element in words ("vertex").
    const KIND: &'static str;
    /// The id of the element with this 0-based index. The index must be below `u32::MAX`.
    fn from_index(index: usize) -> Self;
    /// The 0-based index of the element.
    fn index(self) -> usize;
}

macro_rules! element_id {
    ($(#[$doc:meta])* $name:ident, $kind:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// The 0-based index, ready to address a slice.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl ElementId for $name {
            const KIND: &'static str = $kind;
            #[inline]
            fn from_index(index: usize) -> Self {
                debug_assert!(index < u32::MAX as usize);
                $name(index as u32)
            }
            #[inline]
            fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{} {}", $kind, self.0)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{} {}", $kind, self.0)
            }
        }
    };
}

element_id!(
    /// A vertex, by its place in the input.
    Vertex,
    "vertex"
);
element_id!(
    /// An undirected edge. Edge `i` is the `i`-th one met when the faces are walked in order, each
    /// by its corners 01, 12, 20.
    Edge,
    "edge"
);
element_id!(
    /// A side of a face: halfedge `3 f + k` runs from corner `k` of face `f` to corner `k + 1`.
    Halfedge,
    "halfedge"
);
element_id!(
    /// A corner of a face: corner `3 f + k` is corner `k` of face `f`.
    Corner,
    "corner"
);
element_id!(
    /// A face, by its place in the input.
    Face,
    "face"
);

impl Halfedge {
    /// The face that this halfedge is a side of.
    #[inline]
    pub const fn face(self) -> Face {
        Face(self.0 / 3)
    }
    /// Its place (0, 1, 2) among the sides of its face.
    #[inline]
    pub const fn side(self) -> usize {
        (self.0 % 3) as usize
    }
    /// The following side of the same face.
    #[inline]
    pub const fn next(self) -> Halfedge {
        Halfedge(if self.0 % 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }
    /// The preceding side of the same face.
    #[inline]
    pub const fn previous(self) -> Halfedge {
        Halfedge(if self.0.is_multiple_of(3) { self.0 + 2 } else { self.0 - 1 })
    }
    /// The corner at which it starts.
    #[inline]
    pub const fn corner(self) -> Corner {
        Corner(self.0)
    }
}

impl Corner {
    /// The face that this corner belongs to.
    #[inline]
    pub const fn face(self) -> Face {
        Face(self.0 / 3)
    }
    /// The side of the face that starts here.
    #[inline]
    pub const fn halfedge(self) -> Halfedge {
        Halfedge(self.0)
    }
}

impl Face {
    /// Side `k` (0, 1 or 2), from corner `k` to corner `k + 1`.
    #[inline]
    pub const fn halfedge(self, k: usize) -> Halfedge {
        Halfedge(3 * self.0 + k as u32)
    }
    /// Corner `k` (0, 1 or 2).
    #[inline]
    pub const fn corner(self, k: usize) -> Corner {
        Corner(3 * self.0 + k as u32)
    }
}
