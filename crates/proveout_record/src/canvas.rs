//! A picture of points with letters and lines, and its PNG.

use crate::{color::NEUTRAL_INK, error::RecordError, font};

/// Points of a font's point.
const LETTER: usize = 2;

/// A picture of 8-bit colors, x fastest from the upper left.
pub(crate) struct Canvas {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) colors: Vec<u8>,
}

impl Canvas {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, colors: vec![255; 3 * width * height] }
    }

    pub(crate) fn dot(&mut self, x: isize, y: isize, color: [u8; 3]) {
        if (0..self.width as isize).contains(&x) && (0..self.height as isize).contains(&y) {
            let at = 3 * (y as usize * self.width + x as usize);
            self.colors[at..at + 3].copy_from_slice(&color);
        }
    }

    pub(crate) fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], color: [u8; 3]) {
        for v in y..y + height {
            for u in x..x + width {
                self.dot(u as isize, v as isize, color);
            }
        }
    }

    /// The border of a rectangle, one point outside of it.
    pub(crate) fn frame(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
        self.fill([x - 1, y - 1], [width + 2, 1], NEUTRAL_INK);
        self.fill([x - 1, y + height], [width + 2, 1], NEUTRAL_INK);
        self.fill([x - 1, y - 1], [1, height + 2], NEUTRAL_INK);
        self.fill([x + width, y - 1], [1, height + 2], NEUTRAL_INK);
    }

    pub(crate) fn text(&mut self, [x, y]: [usize; 2], text: &str) {
        for (k, c) in text.chars().enumerate() {
            for (j, row) in font::rows(c).into_iter().enumerate() {
                for i in 0..font::SIZE[0] {
                    if row >> (font::SIZE[0] - 1 - i) & 1 == 1 {
                        let at = [x + LETTER * (k * font::ADVANCE + i), y + LETTER * j];
                        self.fill(at, [LETTER, LETTER], NEUTRAL_INK);
                    }
                }
            }
        }
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// [`RecordError::Picture`] where the encoder refuses.
    pub(crate) fn png(&self) -> Result<Vec<u8>, RecordError> {
        let fail = |e: png::EncodingError| RecordError::Picture { message: e.to_string() };
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(fail)?;
        writer.write_image_data(&self.colors).map_err(fail)?;
        writer.finish().map_err(fail)?;
        Ok(out)
    }

    /// A thick line round a middle, at an angle from x upward.
    pub(crate) fn line(&mut self, [x, y]: [f64; 2], half: f64, angle: f64) {
        let (sin, cos) = angle.sin_cos();
        let steps = (8.0 * half) as i32;
        for k in -steps..=steps {
            let t = half * f64::from(k) / f64::from(steps);
            for w in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                self.dot(
                    (x + t * cos + w * sin).round() as isize,
                    (y - t * sin + w * cos).round() as isize,
                    NEUTRAL_INK,
                );
            }
        }
    }
}

/// Points that a text takes up.
pub(crate) fn width_of(text: &str) -> usize {
    text.chars().count() * font::ADVANCE * LETTER
}
