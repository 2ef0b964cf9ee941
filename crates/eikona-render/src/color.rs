//! Colour spaces (sRGB, linear light, Oklab) and colour maps.

use crate::error::RenderError;
use std::sync::LazyLock;

/// RGB in linear light.
pub(crate) type Linear = [f32; 3];

pub(crate) fn srgb_to_linear(c: u8) -> f32 {
    let c = c as f64 / 255.0;
    (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
}

pub(crate) fn linear_to_srgb(x: f32) -> u8 {
    let x = x.clamp(0.0, 1.0) as f64;
    let c = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * c).round() as u8
}

pub(crate) fn to_linear(c: [u8; 3]) -> Linear {
    c.map(srgb_to_linear)
}

pub(crate) fn mix(a: Linear, b: Linear, t: f32) -> Linear {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)
}

/// Default surface colour: warm light clay.
pub(crate) const CLAY: [u8; 3] = [214, 208, 199];
/// Colour of faces without a value.
pub(crate) const MISSING: [u8; 3] = [176, 176, 178];

/// Categorical colours of labels, assigned cyclically to 1, 2, ... 12, so that -1 has the last but
/// one: the seven chromatic colours of Okabe and Ito (2008) and five of our own. Small positive
/// labels are warm and negative ones cool, as in [`ColorMap::signed`].
const CATEGORIES: [[u8; 3]; 12] = [
    [230, 159, 0],
    [213, 94, 0],
    [204, 121, 167],
    [140, 107, 177],
    [240, 228, 66],
    [150, 98, 62],
    [246, 171, 171],
    [64, 96, 90],
    [0, 158, 115],
    [0, 114, 178],
    [86, 180, 233],
    [166, 206, 140],
];

/// Returns the sRGB colour of a label: light grey for 0, else one of twelve, assigned cyclically
/// (orange for 1, light blue for -1).
///
/// ```
/// use eikona_render::label_color;
/// assert_eq!((label_color(1), label_color(13)), ([230, 159, 0], [230, 159, 0]));
/// assert_eq!((label_color(0), label_color(-1)), ([206, 206, 203], [86, 180, 233]));
/// ```
pub fn label_color(label: i64) -> [u8; 3] {
    if label == 0 {
        return [206, 206, 203];
    }
    CATEGORIES[(i128::from(label) - 1).rem_euclid(CATEGORIES.len() as i128) as usize]
}

/// [`label_color`] in linear light, from a table because it is called per sample.
pub(crate) fn label_linear(label: i64) -> Linear {
    static TABLE: LazyLock<Vec<Linear>> =
        LazyLock::new(|| (0..=CATEGORIES.len() as i64).map(|l| to_linear(label_color(l))).collect());
    let turn = (i128::from(label) - 1).rem_euclid(CATEGORIES.len() as i128) as usize + 1;
    TABLE[if label == 0 { 0 } else { turn }]
}

/// Colour map from [0, 1] to colours, piecewise linear in Oklab (Ottosson 2020), a perceptually
/// uniform space.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorMap {
    name: &'static str,
    diverging: bool,
    table: Vec<Linear>,
}

const TABLE: usize = 512;

impl ColorMap {
    /// Names of the colour maps, for [`ColorMap::by_name`].
    ///
    /// `signed` (blue, white, orange; for signed distances, 0 in the middle), `viridis`, `magma`,
    /// `lagoon` (pale to deep blue), `phase` (cyclic, for angles) and `gray`.
    pub const NAMES: [&'static str; 6] = ["signed", "viridis", "magma", "lagoon", "phase", "gray"];

    /// Returns the colour map of this name.
    ///
    /// ```
    /// use eikona_render::ColorMap;
    /// assert_eq!(ColorMap::by_name("viridis")?.color(0.0), [68, 1, 84]);
    /// # Ok::<(), eikona_render::RenderError>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError::UnknownColorMap`] with all names.
    pub fn by_name(name: &str) -> Result<ColorMap, RenderError> {
        match name {
            "signed" => Ok(Self::signed()),
            "viridis" => Ok(Self::viridis()),
            "magma" => {
                Ok(Self::from_stops("magma", false, &[0x000004, 0x51127c, 0xb73779, 0xfc8961, 0xfcfdbf]))
            }
            "lagoon" => {
                Ok(Self::from_stops("lagoon", false, &[0xf6f4ec, 0xb9dfd6, 0x62b3c4, 0x2f74a8, 0x24356f]))
            }
            "phase" => Ok(Self::from_stops(
                "phase",
                false,
                &[0xd9534a, 0xd39b2c, 0x6fae5a, 0x35a6a8, 0x4a7fd0, 0xa565bd, 0xd9534a],
            )),
            "gray" => Ok(Self::from_stops("gray", false, &[0x202020, 0xf4f4f4])),
            _ => Err(RenderError::UnknownColorMap { name: name.to_owned(), choices: Self::NAMES.join(", ") }),
        }
    }

    /// Returns the diverging map from blue through white to orange.
    ///
    /// ```
    /// let map = eikona_render::ColorMap::signed();
    /// assert!(map.is_diverging());
    /// assert_eq!(map.color(0.5), [248, 246, 241]);
    /// ```
    pub fn signed() -> ColorMap {
        const STOPS: [u32; 9] =
            [0x21497f, 0x3672b5, 0x67a8db, 0xb0d4ec, 0xf8f6f1, 0xfcd3a6, 0xf2a154, 0xd97420, 0xa24f12];
        Self::from_stops("signed", true, &STOPS)
    }

    /// Returns viridis, from dark violet through green to yellow, interpolated from nine colours of
    /// the published map (van der Walt and Smith 2015).
    pub fn viridis() -> ColorMap {
        const STOPS: [u32; 9] =
            [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];
        Self::from_stops("viridis", false, &STOPS)
    }

    fn from_stops(name: &'static str, diverging: bool, stops: &[u32]) -> ColorMap {
        let rgb = |c: u32| to_linear([(c >> 16) as u8, (c >> 8) as u8, c as u8]);
        let lab: Vec<[f64; 3]> = stops.iter().map(|&c| oklab(rgb(c))).collect();
        let table = (0..=TABLE)
            .map(|i| {
                let s = i as f64 / TABLE as f64 * (lab.len() - 1) as f64;
                let k = (s as usize).min(lab.len() - 2);
                let t = s - k as f64;
                from_oklab([0, 1, 2].map(|c| lab[k][c] + t * (lab[k + 1][c] - lab[k][c])))
            })
            .collect();
        ColorMap { name, diverging, table }
    }

    /// Returns the name.
    pub fn name(&self) -> &'static str {
        self.name
    }
    /// Returns whether the map is diverging: its midpoint represents 0, and automatic ranges are
    /// symmetric.
    pub fn is_diverging(&self) -> bool {
        self.diverging
    }
    /// Returns the sRGB colour at `t`, which is clamped to [0, 1] (NaN to 0).
    pub fn color(&self, t: f64) -> [u8; 3] {
        self.linear(t).map(linear_to_srgb)
    }
    pub(crate) fn linear(&self, t: f64) -> Linear {
        let s = t.clamp(0.0, 1.0) * TABLE as f64; // NaN stays NaN; the cast makes it index 0
        let k = (s as usize).min(TABLE - 1);
        let fraction = if s.is_nan() { 0.0 } else { s - k as f64 };
        mix(self.table[k], self.table[k + 1], fraction as f32)
    }
}

/// Linear sRGB to Oklab.
fn oklab(c: Linear) -> [f64; 3] {
    let [r, g, b] = c.map(f64::from);
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    [
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    ]
}

/// Oklab to linear sRGB, clamped to the gamut.
fn from_oklab([lightness, a, b]: [f64; 3]) -> Linear {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
    .map(|x| x.clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trip() {
        for c in 0..=255u8 {
            assert_eq!(linear_to_srgb(srgb_to_linear(c)), c);
        }
    }

    #[test]
    fn oklab_round_trip_and_white() {
        let white = oklab([1.0; 3]);
        assert!((white[0] - 1.0).abs() < 1e-6 && white[1].abs() < 1e-6 && white[2].abs() < 1e-6);
        let c = [0.2, 0.5, 0.7];
        let back = from_oklab(oklab(c));
        assert!((0..3).all(|k| (back[k] - c[k]).abs() < 1e-5));
    }

    #[test]
    fn maps_have_names_and_monotone_lightness() {
        for name in ColorMap::NAMES {
            let map = ColorMap::by_name(name).unwrap();
            assert_eq!(map.name(), name);
            assert_eq!(map.color(f64::NAN), map.color(0.0));
            assert_eq!(map.color(f64::INFINITY), map.color(1.0));
        }
        assert!(ColorMap::by_name("jet").is_err());
        let lightness = |map: &ColorMap, i: usize| oklab(map.linear(i as f64 / 100.0))[0];
        let viridis = ColorMap::viridis();
        assert!((0..100).all(|i| lightness(&viridis, i) < lightness(&viridis, i + 1)));
        let signed = ColorMap::signed();
        assert!((0..50).all(|i| lightness(&signed, i) < lightness(&signed, i + 1)));
        assert!((50..100).all(|i| lightness(&signed, i) > lightness(&signed, i + 1)));
        let [r, g, b] = signed.color(0.5);
        assert!(r > 240 && g > 240 && b > 235, "the middle is white");
    }

    #[test]
    fn labels_of_both_signs_have_colors() {
        let colors: std::collections::BTreeSet<_> = (-6..=5).map(label_color).collect();
        assert_eq!(colors.len(), 12, "small labels have distinct colours");
        assert_eq!(label_color(1), label_color(13));
        for label in [i64::MIN, -1, 0, 1, 12, 13, i64::MAX] {
            assert_eq!(label_linear(label), to_linear(label_color(label)));
        }
    }
}
