//! A sheet as SVG. Numbers have two decimals, so that the same drawing is the same text.

use super::sheet::{Mark, Place, SMALLER, Sheet, Stroke, drop_of};
use crate::paper::typeset::{Run, Script};
use crate::storage;
use crate::storage::picture::encode_png;
use plotters::style::RGBColor;
use std::fmt::Write;

/// The text of the SVG.
pub(super) fn text(sheet: &Sheet) -> String {
    let (width, height) = (number(sheet.width), number(sheet.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    for mark in &sheet.marks {
        match mark {
            Mark::Line { points, stroke } => line(&mut out, points, stroke),
            Mark::Fill { points, colour, opacity } => {
                let _ = writeln!(
                    out,
                    "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"{}\"/>",
                    places(points),
                    hex(*colour),
                    number(*opacity)
                );
            }
            Mark::Words { at, runs, size, colour, upright } => words(&mut out, *at, runs, *size, *colour, *upright),
            Mark::Picture { place: [x, y, width, height], image } => {
                let _ = writeln!(
                    out,
                    "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
                     href=\"data:image/png;base64,{}\"/>",
                    number(*x),
                    number(*y),
                    number(*width),
                    number(*height),
                    encode_png(image).map(|bytes| base64(&bytes)).unwrap_or_default()
                );
            }
        }
    }
    out.push_str("</svg>\n");
    out
}

fn line(out: &mut String, points: &[Place], stroke: &Stroke) {
    let dash = stroke.dash.map_or(String::new(), |[on, off]| format!(" stroke-dasharray=\"{} {}\"", number(on), number(off)));
    let _ = writeln!(
        out,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dash}/>",
        places(points),
        hex(stroke.colour),
        number(stroke.width)
    );
}

fn words(out: &mut String, [x, y]: Place, runs: &[Run], size: f64, colour: RGBColor, upright: bool) {
    let (x, y) = (number(x), number(y));
    let turn = if upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
    let _ = write!(out, "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\"{turn}>", number(size), hex(colour));
    // Simple viewers place the pieces of a line badly; most lines have but one.
    if let [Run { text, script: Script::Base }] = runs {
        let _ = writeln!(out, "{}</text>", escaped(text));
        return;
    }
    let mut level = 0.0;
    for run in runs {
        let now = drop_of(run.script) * size;
        let small = if run.script == Script::Base { size } else { SMALLER * size };
        let _ = write!(out, "<tspan dy=\"{}\" font-size=\"{}\">{}</tspan>", number(now - level), number(small), escaped(&run.text));
        level = now;
    }
    out.push_str("</text>\n");
}

fn places(points: &[Place]) -> String {
    let mut text = String::new();
    for [x, y] in points {
        let _ = write!(text, "{},{} ", number(*x), number(*y));
    }
    text.truncate(text.trim_end().len());
    text
}

/// Two decimals at most.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn hex(colour: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2)
}

/// Text on one line as it may stand in XML and HTML, also between quotes.
pub(in crate::storage) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in storage::line(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// Bytes as text (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k)) as usize & 63];
            out.push(if k <= three.len() { char::from(letter) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // The examples of RFC 4648.
        for (plain, coded) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn text_cannot_break_out_of_its_place() {
        assert_eq!(escaped("<a href=\"x\">&'\u{7}"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;\\u{7}");
    }
}
