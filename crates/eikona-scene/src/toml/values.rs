//! Values of the document with the ranges of their numbers, and values of several forms.

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;
use toml::Spanned;

/// A finite number.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(try_from = "f64")]
pub struct Finite(pub f64);

/// A number above 0.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(try_from = "f64")]
pub struct AboveZero(pub f64);

/// A number of 0 or more.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(try_from = "f64")]
pub struct ZeroOrMore(pub f64);

/// A whole number of 1 or more.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(try_from = "u64")]
pub struct Count(pub u64);

impl TryFrom<f64> for Finite {
    type Error = String;
    fn try_from(x: f64) -> Result<Finite, String> {
        x.is_finite().then_some(Finite(x)).ok_or(format!("{x}: expected a finite number"))
    }
}

impl TryFrom<f64> for AboveZero {
    type Error = String;
    fn try_from(x: f64) -> Result<AboveZero, String> {
        let fine = x > 0.0 && x.is_finite();
        fine.then_some(AboveZero(x)).ok_or(format!("{x}: expected a number above 0"))
    }
}

impl TryFrom<f64> for ZeroOrMore {
    type Error = String;
    fn try_from(x: f64) -> Result<ZeroOrMore, String> {
        let fine = x >= 0.0 && x.is_finite();
        fine.then_some(ZeroOrMore(x)).ok_or(format!("{x}: expected a number of 0 or more"))
    }
}

impl TryFrom<u64> for Count {
    type Error = String;
    fn try_from(n: u64) -> Result<Count, String> {
        (n > 0).then_some(Count(n)).ok_or(format!("{n}: expected a whole number of 1 or more"))
    }
}

/// `true`, `false`, or something with more to say.
#[derive(Clone, Debug)]
pub enum Switch<T> {
    /// Only on or off.
    Plain(bool),
    /// On, with details.
    With(T),
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Switch<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Switch<T>, D::Error> {
        struct Form<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Form<T> {
            type Value = Switch<T>;
            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                write!(out, "true, false or details")
            }
            fn visit_bool<E: Error>(self, on: bool) -> Result<Switch<T>, E> {
                Ok(Switch::Plain(on))
            }
            fn visit_str<E: Error>(self, word: &str) -> Result<Switch<T>, E> {
                T::deserialize(StrDeserializer::new(word)).map(Switch::With)
            }
            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Switch<T>, M::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Switch::With)
            }
        }
        deserializer.deserialize_any(Form(PhantomData))
    }
}

/// A surface: the name of a file, or a table.
#[derive(Clone, Debug, Default)]
pub struct SurfaceEntry {
    /// The name of a file.
    pub file: Option<String>,
    /// The name of a shape.
    pub shape: Option<Spanned<String>>,
    /// A factor.
    pub scale: Option<Spanned<Finite>>,
    /// A displacement.
    pub offset: Option<[Finite; 3]>,
    /// All other keys: the parameters of the shape.
    pub parameters: Vec<(Spanned<String>, String)>,
}

impl<'de> Deserialize<'de> for SurfaceEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<SurfaceEntry, D::Error> {
        struct Form;
        impl<'de> Visitor<'de> for Form {
            type Value = SurfaceEntry;
            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                write!(out, "a file name, or a table such as {{ shape = \"torus\", minor = 0.3 }}")
            }
            fn visit_str<E: Error>(self, file: &str) -> Result<SurfaceEntry, E> {
                Ok(SurfaceEntry { file: Some(file.into()), ..SurfaceEntry::default() })
            }
            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<SurfaceEntry, M::Error> {
                let mut entry = SurfaceEntry::default();
                while let Some(key) = map.next_key::<Spanned<String>>()? {
                    match key.get_ref().as_str() {
                        "file" => entry.file = Some(map.next_value()?),
                        "shape" => entry.shape = Some(map.next_value()?),
                        "scale" => entry.scale = Some(map.next_value()?),
                        "move" => entry.offset = Some(map.next_value()?),
                        _ => entry.parameters.push((key, map.next_value::<Text>()?.0)),
                    }
                }
                Ok(entry)
            }
        }
        deserializer.deserialize_any(Form)
    }
}

/// One or several surfaces.
#[derive(Clone, Debug)]
pub enum Surfaces {
    /// One.
    One(SurfaceEntry),
    /// Several.
    Many(Vec<Spanned<SurfaceEntry>>),
}

impl<'de> Deserialize<'de> for Surfaces {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Surfaces, D::Error> {
        struct Form;
        impl<'de> Visitor<'de> for Form {
            type Value = Surfaces;
            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                write!(out, "a file name, a table such as {{ shape = \"torus\" }}, or a list of these")
            }
            fn visit_str<E: Error>(self, file: &str) -> Result<Surfaces, E> {
                SurfaceEntry::deserialize(StrDeserializer::new(file)).map(Surfaces::One)
            }
            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Surfaces, M::Error> {
                SurfaceEntry::deserialize(MapAccessDeserializer::new(map)).map(Surfaces::One)
            }
            fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Surfaces, S::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = list.next_element()? {
                    entries.push(entry);
                }
                Ok(Surfaces::Many(entries))
            }
        }
        deserializer.deserialize_any(Form)
    }
}

/// A word or number as text, as on the command line.
struct Text(String);

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Text, D::Error> {
        struct Form;
        impl Visitor<'_> for Form {
            type Value = Text;
            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                write!(out, "a number or a word")
            }
            fn visit_str<E: Error>(self, word: &str) -> Result<Text, E> {
                Ok(Text(word.into()))
            }
            fn visit_i64<E: Error>(self, n: i64) -> Result<Text, E> {
                Ok(Text(n.to_string()))
            }
            fn visit_u64<E: Error>(self, n: u64) -> Result<Text, E> {
                Ok(Text(n.to_string()))
            }
            fn visit_f64<E: Error>(self, x: f64) -> Result<Text, E> {
                Finite::try_from(x).map(|x| Text(x.0.to_string())).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Form)
    }
}
