//! Setters of option structs.

/// Defines a setter per field: `with_threads(2)` sets `threads`.
///
/// The structs are `#[non_exhaustive]` so that options can be added, which rules out struct
/// literals in other crates.
macro_rules! setters {
    ($options:ty { $($setter:ident: $field:ident = $value:ty),+ $(,)? }) => {
        impl $options {
            $(
                #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $setter(mut self, value: $value) -> Self {
                    self.$field = value;
                    self
                }
            )+
        }
    };
}
pub(crate) use setters;
