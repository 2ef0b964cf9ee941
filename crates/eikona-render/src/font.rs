//! Stroke font for colour bars: ASCII letters, digits and signs as lines and arcs.

/// Cap height in glyph units.
const CAP: f64 = 7.0;
/// Gap between glyphs.
const GAP: f64 = 1.5;
/// Stroke width.
const STROKE: f64 = 0.92;

/// Returns width and strokes of a glyph. `M x y` moves the pen, `L x y` draws a line, `A cx cy rx
/// ry from to` draws an arc (degrees), to which no line leads; the pen stays at its end. y points
/// upwards from the baseline.
fn glyph(c: char) -> Option<(f64, &'static str)> {
    Some(match c {
        ' ' => (1.6, ""),
        '0' => (4.0, "A 2 3.5 2 3.5 0 360"),
        '1' => (4.0, "M 0.7 5.6 L 2.4 7 L 2.4 0"),
        '2' => (4.0, "A 2 5.05 1.9 1.95 165 -38 L 0.1 0 L 4 0"),
        '3' => (4.0, "A 1.9 5.25 1.75 1.75 150 -90 A 1.85 1.75 2.05 1.75 90 -150"),
        '4' => (4.2, "M 3.2 0 L 3.2 7 L 0 2.1 L 4.3 2.1"),
        '5' => (4.0, "M 3.6 7 L 0.75 7 L 0.42 3.95 A 1.9 2.3 2.1 2.3 135 -150"),
        '6' => (4.0, "A 2 2.2 2 2.2 0 360 A 4 2.2 4 4.8 180 105"),
        '7' => (4.0, "M 0 7 L 4 7 L 1.4 0"),
        '8' => (4.0, "A 2 5.25 1.7 1.75 0 360 A 2 1.75 2 1.75 0 360"),
        '9' => (4.0, "A 2 4.8 2 2.2 0 360 A 0 4.8 4 4.8 0 -75"),
        '.' => (0.8, "M 0.4 0.1 L 0.4 0.1"),
        ',' => (0.9, "M 0.5 0.2 L 0.1 -1.2"),
        ':' => (0.8, "M 0.4 0.3 L 0.4 0.3 M 0.4 3.8 L 0.4 3.8"),
        '-' => (3.4, "M 0.2 3.2 L 3.2 3.2"),
        '+' => (3.8, "M 0.1 3.2 L 3.7 3.2 M 1.9 1.4 L 1.9 5"),
        '=' => (3.8, "M 0.1 2.3 L 3.7 2.3 M 0.1 4.3 L 3.7 4.3"),
        '<' => (3.6, "M 3.5 5.2 L 0.2 3.2 L 3.5 1.2"),
        '>' => (3.6, "M 0.1 5.2 L 3.4 3.2 L 0.1 1.2"),
        '/' => (3.2, "M 0 -0.8 L 3.2 7.4"),
        '|' => (0.8, "M 0.4 -1.2 L 0.4 7.6"),
        '_' => (4.0, "M 0 -0.9 L 4 -0.9"),
        '*' => (3.2, "M 1.6 3 L 1.6 6.6 M 0.1 3.9 L 3.1 5.7 M 0.1 5.7 L 3.1 3.9"),
        '^' => (3.2, "M 0.1 4.8 L 1.6 7.2 L 3.1 4.8"),
        '\'' => (0.8, "M 0.4 7.2 L 0.4 5.4"),
        '%' => (6.0, "A 1.3 5.6 1.3 1.5 0 360 A 4.7 1.4 1.3 1.5 0 360 M 5 7.1 L 1 -0.1"),
        '(' => (1.7, "A 2.6 3 2.5 4.9 118 242"),
        ')' => (1.7, "A -0.9 3 2.5 4.9 62 -62"),
        '[' => (1.6, "M 1.6 7.6 L 0.1 7.6 L 0.1 -1.4 L 1.6 -1.4"),
        ']' => (1.6, "M 0 7.6 L 1.5 7.6 L 1.5 -1.4 L 0 -1.4"),
        'a' => (3.8, "A 1.9 2.4 1.9 2.4 0 360 M 3.8 4.8 L 3.8 0"),
        'b' => (3.8, "M 0 7.2 L 0 0 A 1.9 2.4 1.9 2.4 0 360"),
        'c' => (3.4, "A 2 2.4 2 2.4 48 312"),
        'd' => (3.8, "A 1.9 2.4 1.9 2.4 0 360 M 3.8 7.2 L 3.8 0"),
        'e' => (3.9, "M 0.05 2.5 L 3.85 2.5 A 1.95 2.4 1.9 2.4 0 312"),
        'f' => (2.5, "M 1 0 L 1 5.7 A 2.3 5.7 1.3 1.5 180 80 M 0 4.6 L 2.4 4.6"),
        'g' => (3.8, "A 1.9 2.4 1.9 2.4 0 360 M 3.8 4.8 L 3.8 -0.4 A 1.9 -0.4 1.9 1.75 0 -150"),
        'h' => (3.6, "M 0 7.2 L 0 0 A 1.8 2.9 1.8 1.9 180 0 L 3.6 0"),
        'i' => (0.6, "M 0.3 4.8 L 0.3 0 M 0.3 6.7 L 0.3 6.7"),
        'j' => (1.2, "M 1 4.8 L 1 -0.6 A -0.1 -0.6 1.1 1.4 0 -100 M 1 6.7 L 1 6.7"),
        'k' => (3.4, "M 0 7.2 L 0 0 M 3.2 4.8 L 0 1.9 M 1.2 3 L 3.4 0"),
        'l' => (0.6, "M 0.3 7.2 L 0.3 0"),
        'm' => (5.6, "M 0 4.8 L 0 0 A 1.4 3.2 1.4 1.6 180 0 L 2.8 0 A 4.2 3.2 1.4 1.6 180 0 L 5.6 0"),
        'n' => (3.6, "M 0 4.8 L 0 0 A 1.8 2.9 1.8 1.9 180 0 L 3.6 0"),
        'o' => (4.0, "A 2 2.4 2 2.4 0 360"),
        'p' => (3.8, "M 0 4.8 L 0 -2.1 A 1.9 2.4 1.9 2.4 0 360"),
        'q' => (3.8, "M 3.8 4.8 L 3.8 -2.1 A 1.9 2.4 1.9 2.4 0 360"),
        'r' => (2.2, "M 0 4.8 L 0 0 A 1.6 2.9 1.6 1.9 180 70"),
        's' => (3.3, "A 1.7 3.6 1.5 1.2 35 270 A 1.65 1.2 1.6 1.2 90 -145"),
        't' => (2.6, "M 1.1 6.3 L 1.1 1.3 A 2.3 1.3 1.2 1.3 180 280 M 0 4.6 L 2.5 4.6"),
        'u' => (3.6, "M 0 4.8 L 0 1.9 A 1.8 1.9 1.8 1.9 180 360 M 3.6 4.8 L 3.6 0"),
        'v' => (3.8, "M 0 4.8 L 1.9 0 L 3.8 4.8"),
        'w' => (5.6, "M 0 4.8 L 1.4 0 L 2.8 4.4 L 4.2 0 L 5.6 4.8"),
        'x' => (3.6, "M 0 4.8 L 3.6 0 M 3.6 4.8 L 0 0"),
        'y' => (3.8, "M 0 4.8 L 1.9 0 M 3.8 4.8 L 1.07 -2.1"),
        'z' => (3.6, "M 0.1 4.8 L 3.5 4.8 L 0 0 L 3.6 0"),
        'A' => (4.8, "M 0 0 L 2.4 7 L 4.8 0 M 0.8 2.4 L 4 2.4"),
        'B' => {
            (4.1, "M 0 0 L 0 7 L 2 7 A 2 5.3 1.7 1.7 90 -90 L 0 3.6 M 2.1 3.6 A 2.1 1.8 2 1.8 90 -90 L 0 0")
        }
        'C' => (4.7, "A 2.7 3.5 2.7 3.5 45 315"),
        'D' => (4.5, "M 0 0 L 0 7 L 1.5 7 A 1.5 3.5 3 3.5 90 -90 L 0 0"),
        'E' => (4.0, "M 4 7 L 0 7 L 0 0 L 4 0 M 0 3.6 L 3.4 3.6"),
        'F' => (3.8, "M 3.8 7 L 0 7 L 0 0 M 0 3.6 L 3.2 3.6"),
        'G' => (5.2, "A 2.7 3.5 2.7 3.5 45 318 M 3 3.3 L 5 3.3 L 5 1"),
        'H' => (4.4, "M 0 0 L 0 7 M 4.4 0 L 4.4 7 M 0 3.6 L 4.4 3.6"),
        'I' => (0.8, "M 0.4 0 L 0.4 7"),
        'J' => (3.0, "M 2.8 7 L 2.8 1.8 A 1.4 1.8 1.4 1.8 0 -170"),
        'K' => (4.2, "M 0 0 L 0 7 M 4 7 L 0 2.6 M 1.4 4.1 L 4.2 0"),
        'L' => (3.6, "M 0 7 L 0 0 L 3.6 0"),
        'M' => (5.6, "M 0 0 L 0 7 L 2.8 2 L 5.6 7 L 5.6 0"),
        'N' => (4.5, "M 0 0 L 0 7 L 4.5 0 L 4.5 7"),
        'O' => (5.4, "A 2.7 3.5 2.7 3.5 0 360"),
        'P' => (4.1, "M 0 0 L 0 7 L 2.2 7 A 2.2 5.1 1.9 1.9 90 -90 L 0 3.2"),
        'Q' => (5.4, "A 2.7 3.5 2.7 3.5 0 360 M 3.3 1.8 L 5.3 -0.4"),
        'R' => (4.2, "M 0 0 L 0 7 L 2.2 7 A 2.2 5.2 1.8 1.8 90 -90 L 0 3.4 M 2.2 3.4 L 4.2 0"),
        'S' => (4.2, "A 2.1 5.2 1.9 1.8 40 270 A 2.1 1.7 2.1 1.7 90 -145"),
        'T' => (4.6, "M 0 7 L 4.6 7 M 2.3 7 L 2.3 0"),
        'U' => (4.4, "M 0 7 L 0 2.2 A 2.2 2.2 2.2 2.2 180 360 L 4.4 7"),
        'V' => (4.8, "M 0 7 L 2.4 0 L 4.8 7"),
        'W' => (6.6, "M 0 7 L 1.6 0 L 3.3 6.4 L 5 0 L 6.6 7"),
        'X' => (4.4, "M 0 7 L 4.4 0 M 4.4 7 L 0 0"),
        'Y' => (4.4, "M 0 7 L 2.2 3.3 L 4.4 7 M 2.2 3.3 L 2.2 0"),
        'Z' => (4.2, "M 0.1 7 L 4.1 7 L 0 0 L 4.2 0"),
        _ => return None,
    })
}

/// Returns the width of a line of text with cap height `size`.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let advance: f64 = text.chars().filter_map(glyph).map(|g| g.0 + GAP).sum();
    (advance - GAP).max(0.0) * size / CAP
}

/// Returns half the stroke width of text with cap height `size`.
pub(crate) fn stroke_radius(size: f64) -> f64 {
    STROKE * size / CAP / 2.0
}

/// Returns the strokes of a line of text as segments in pixels, y downwards, starting at `x` on the
/// baseline `y`.
pub(crate) fn text_segments(text: &str, x: f64, y: f64, size: f64) -> Vec<[[f64; 2]; 2]> {
    let unit = size / CAP;
    let mut segments = Vec::new();
    let mut left = x;
    for (advance, strokes) in text.chars().filter_map(glyph) {
        let at = |px: f64, py: f64| [left + px * unit, y - py * unit];
        let mut words = strokes.split_whitespace();
        let mut pen = at(0.0, 0.0);
        while let Some(command) = words.next() {
            let mut number = || words.next().and_then(|w| w.parse::<f64>().ok()).unwrap_or(0.0);
            match command {
                "A" => {
                    let (cx, cy, rx, ry, from, to) =
                        (number(), number(), number(), number(), number(), number());
                    let steps = ((to - from).abs() / 12.0).ceil().max(1.0) as usize;
                    for i in 0..=steps {
                        let angle = (from + (to - from) * i as f64 / steps as f64).to_radians();
                        let next = at(cx + rx * angle.cos(), cy + ry * angle.sin());
                        if i > 0 {
                            segments.push([pen, next]);
                        }
                        pen = next;
                    }
                }
                _ => {
                    let next = at(number(), number());
                    if command == "L" {
                        segments.push([pen, next]);
                    }
                    pen = next;
                }
            }
        }
        left += (advance + GAP) * unit;
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_letters_digits_and_number_signs_have_glyphs() {
        for c in ('a'..='z').chain('A'..='Z').chain('0'..='9').chain("+-.e".chars()) {
            assert!(!text_segments(&c.to_string(), 0.0, 0.0, 7.0).is_empty(), "{c}");
        }
    }

    #[test]
    fn capitals_have_the_cap_height_and_width() {
        for c in 'A'..='Z' {
            let s = c.to_string();
            let points: Vec<[f64; 2]> = text_segments(&s, 0.0, 0.0, 14.0).concat();
            let top = points.iter().map(|p| -p[1]).fold(0.0, f64::max);
            let right = points.iter().map(|p| p[0]).fold(0.0, f64::max);
            assert!((top - 14.0).abs() < 0.3, "{c} {top}");
            assert!(right <= text_width(&s, 14.0) + 0.9, "{c} {right}");
        }
    }
}
