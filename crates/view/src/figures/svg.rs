//! A drawing as SVG text, and the same as PNG.

use crate::ViewError;
use crate::compact::base64;
use resvg::{tiny_skia, usvg};
use std::fmt::Write as _;
use std::sync::Arc;

/// The font of PNG figures; SVG figures name others first, so that they look like the text around them.
const FONT: &[u8] = include_bytes!("../../fonts/DejaVuSans.ttf");
const FAMILIES: &str = "Helvetica, Arial, 'DejaVu Sans', sans-serif";

/// Width of a character on average, in font sizes: for deciding whether a text fits.
const CHARACTER: f64 = 0.54;

/// Ink of text.
pub(crate) const TEXT: &str = "#1c232d";
/// Ink of axes and lesser text.
pub(crate) const FAINT: &str = "#667282";
/// Ink of grids.
pub(crate) const GRID: &str = "#d5dbe4";
/// Shade of every other phase.
pub(crate) const BAND: &str = "#f1f4f8";
/// Ink of limits.
pub(crate) const LIMIT: &str = "#c8372d";

/// Where a text begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing in the making; lengths in points, y downwards.
pub(crate) struct Drawing {
    pub width: f64,
    pub height: f64,
    body: String,
}

impl Drawing {
    /// A white sheet.
    pub fn new(width: f64, height: f64) -> Self {
        let mut drawing = Self {
            width,
            height,
            body: String::new(),
        };
        drawing.rect([0.0, 0.0], [width, height], "#ffffff", 0.0);
        drawing
    }

    fn add(&mut self, element: std::fmt::Arguments) {
        writeln!(self.body, "{element}").expect("a string takes all text");
    }

    /// A filled rectangle with rounded corners.
    pub fn rect(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], fill: &str, round: f64) {
        self.add(format_args!(
            r#"<rect x="{x:.2}" y="{y:.2}" width="{w:.2}" height="{h:.2}" rx="{round:.1}" fill="{fill}"/>"#
        ));
    }

    /// A line through points.
    pub fn line(&mut self, points: &[[f64; 2]], stroke: &str, width: f64, dashed: bool) {
        let mut path = String::new();
        for [x, y] in points {
            write!(path, "{x:.2},{y:.2} ").expect("a string takes all text");
        }
        let dash = if dashed {
            r#" stroke-dasharray="4 3""#
        } else {
            ""
        };
        self.add(format_args!(
            r#"<polyline points="{}" fill="none" stroke="{stroke}" stroke-width="{width}" stroke-linejoin="round"{dash}/>"#,
            path.trim_end()
        ));
    }

    /// A text whose middle is at height `y`.
    pub fn text(&mut self, [x, y]: [f64; 2], text: &str, size: f64, fill: &str, anchor: Anchor) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (baseline, text) = (y + 0.36 * size, escaped(text));
        self.add(format_args!(
            r#"<text x="{x:.2}" y="{baseline:.2}" font-size="{size}" fill="{fill}" text-anchor="{anchor}">{text}</text>"#
        ));
    }

    /// A text that reads upwards around its middle.
    pub fn upright_text(&mut self, [x, y]: [f64; 2], text: &str, size: f64, fill: &str) {
        let text = escaped(text);
        self.add(format_args!(
            r#"<text transform="translate({:.2} {y:.2}) rotate(-90)" font-size="{size}" fill="{fill}" text-anchor="middle">{text}</text>"#,
            x + 0.36 * size
        ));
    }

    /// A PNG picture.
    pub fn image(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], png: &[u8]) {
        let data = base64(png);
        self.add(format_args!(
            r#"<image x="{x:.2}" y="{y:.2}" width="{w:.2}" height="{h:.2}" href="data:image/png;base64,{data}"/>"#
        ));
    }

    /// The SVG file.
    pub fn svg(&self) -> String {
        let (width, height, body) = (self.width, self.height, &self.body);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}pt\" height=\"{height:.0}pt\" viewBox=\"0 0 {width:.2} {height:.2}\" \
             font-family=\"{FAMILIES}\">\n{body}</svg>\n"
        )
    }

    /// The PNG file, so many pixels per point.
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, ViewError> {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(FONT.to_vec());
        fonts.set_sans_serif_family("DejaVu Sans");
        let options = usvg::Options {
            fontdb: Arc::new(fonts),
            font_family: "DejaVu Sans".into(),
            ..usvg::Options::default()
        };
        let failed = |what: String| ViewError::Figure { what };
        // Only the embedded font is there, so it is the one that is named.
        let text = self
            .svg()
            .replace(FAMILIES, "DejaVu Sans")
            .replace("pt\"", "\"");
        let tree =
            usvg::Tree::from_str(&text, &options).map_err(|error| failed(error.to_string()))?;
        let [width, height] = [self.width, self.height].map(|x| (x * scale).ceil() as u32);
        let mut sheet = tiny_skia::Pixmap::new(width, height)
            .ok_or_else(|| failed(format!("no sheet of {width} by {height} pixels")))?;
        // The drawing ends within the last pixels.
        sheet.fill(tiny_skia::Color::WHITE);
        let scale = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
        resvg::render(&tree, scale, &mut sheet.as_mut());
        sheet
            .encode_png()
            .map_err(|error| failed(error.to_string()))
    }
}

/// RGB pixels as a PNG file.
pub(crate) fn png_of(picture: &crate::render::Picture) -> Result<Vec<u8>, ViewError> {
    let rgba = picture
        .rgb
        .chunks_exact(3)
        .flat_map(|p| [p[0], p[1], p[2], 255]);
    let size = tiny_skia::IntSize::from_wh(picture.width as u32, picture.height as u32);
    size.and_then(|size| tiny_skia::Pixmap::from_vec(rgba.collect(), size))
        .ok_or_else(|| "an empty picture".to_owned())
        .and_then(|sheet| sheet.encode_png().map_err(|error| error.to_string()))
        .map_err(|what| ViewError::Figure { what })
}

/// The text, or as much of it as fits into a width, or nothing.
pub(crate) fn fitted(text: &str, size: f64, width: f64) -> String {
    let room = (width / (CHARACTER * size)).floor().max(0.0) as usize;
    let length = text.chars().count();
    if length <= room {
        text.to_owned()
    } else if room < 3 {
        String::new()
    } else {
        text.chars().take(room - 1).chain(['…']).collect()
    }
}

/// Round numbers from `low` to `high`, about `count` of them.
pub(crate) fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
    let rough = ((high - low) / count).max(1e-9);
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    let step = step.into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

/// A tick as text, without digits that say nothing.
pub(crate) fn tick_text(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.replace('-', "−")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(-11.0, 23.0, 4.0), [-10.0, 0.0, 10.0, 20.0]);
        assert_eq!(tick_text(-10.0), "−10");
        assert_eq!(tick_text(0.25), "0.25");
    }

    #[test]
    fn a_drawing_becomes_a_png_with_its_text() {
        let dark = |text: &str| {
            let mut drawing = Drawing::new(80.0, 20.0);
            drawing.text([4.0, 10.0], text, 12.0, "#000000", Anchor::Start);
            let png = drawing.png(2.0).unwrap();
            let sheet = tiny_skia::Pixmap::decode_png(&png).unwrap();
            assert_eq!((sheet.width(), sheet.height()), (160, 40));
            sheet.pixels().iter().filter(|p| p.red() < 100).count()
        };
        assert_eq!(dark(""), 0);
        assert!(dark("τ ≤ 3 N m") > 100);
    }

    #[test]
    fn a_png_is_opaque_to_its_last_pixel() {
        let png = Drawing::new(80.3, 20.1).png(2.0).unwrap();
        let sheet = tiny_skia::Pixmap::decode_png(&png).unwrap();
        assert_eq!((sheet.width(), sheet.height()), (161, 41));
        assert!(
            sheet
                .pixels()
                .iter()
                .all(|p| p.alpha() == 255 && p.red() > 200)
        );
    }
}
