//! Typed element ids: a vertex index can not be used where a face index is expected.

use serde::ser::{Serialize, SerializeMap, Serializer};
use std::fmt;

/// The id of a mesh element. Implemented by [`Vertex`], [`Edge`], [`Halfedge`], [`Corner`] and
/// [`Face`].
pub trait ElementId: Copy + Eq + Ord + std::hash::Hash + fmt::Debug {
    /// The name of the element kind ("vertex").
    const KIND: &'static str;
    /// Creates the id with this 0-based index. The index must be below `u32::MAX`.
    fn from_index(index: usize) -> Self;
    /// Returns the 0-based index of the element.
    fn index(self) -> usize;
}

macro_rules! element_id {
    ($(#[$doc:meta])* $name:ident, $kind:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// Returns the 0-based index.
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

        /// As in `{"face":7}`, the form in which points on the surface name a vertex.
        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry($kind, &self.0)?;
                map.end()
            }
        }
    };
}

element_id!(
    /// A vertex, numbered by its position in the input.
    Vertex,
    "vertex"
);
element_id!(
    /// An undirected edge. Edge `i` is the `i`-th one met when the faces are visited in order, each
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
    /// A face, numbered by its position in the input.
    Face,
    "face"
);

impl Halfedge {
    /// Returns the face of this halfedge.
    #[inline]
    pub const fn face(self) -> Face {
        Face(self.0 / 3)
    }
    /// Returns its index (0, 1, 2) among the sides of its face.
    #[inline]
    pub const fn side(self) -> usize {
        (self.0 % 3) as usize
    }
    /// Returns the next halfedge of the same face.
    #[inline]
    pub const fn next(self) -> Halfedge {
        Halfedge(if self.0 % 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }
    /// Returns the previous halfedge of the same face.
    #[inline]
    pub const fn previous(self) -> Halfedge {
        Halfedge(if self.0.is_multiple_of(3) { self.0 + 2 } else { self.0 - 1 })
    }
    /// Returns the corner at which it starts.
    #[inline]
    pub const fn corner(self) -> Corner {
        Corner(self.0)
    }
}

impl Corner {
    /// Returns the face of this corner.
    #[inline]
    pub const fn face(self) -> Face {
        Face(self.0 / 3)
    }
    /// Returns the halfedge that starts at this corner.
    #[inline]
    pub const fn halfedge(self) -> Halfedge {
        Halfedge(self.0)
    }
}

impl Face {
    /// Returns side `k` (0, 1 or 2), from corner `k` to corner `k + 1`.
    #[inline]
    pub const fn halfedge(self, k: usize) -> Halfedge {
        Halfedge(3 * self.0 + k as u32)
    }
    /// Returns corner `k` (0, 1 or 2).
    #[inline]
    pub const fn corner(self, k: usize) -> Corner {
        Corner(3 * self.0 + k as u32)
    }
}
