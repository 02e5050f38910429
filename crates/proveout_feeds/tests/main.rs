//! Tests of the force model and of the feeds, against closed forms and laws.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

mod files;
mod forces;
mod solving;

use std::path::Path;

use proveout_feeds::{Material, SliceCut};
use proveout_tool::{Tool, ToolLibrary};

/// A flat end mill of 10 mm; `more` are further lines of its entry.
fn flat(more: &str) -> Tool {
    let text = format!(
        "[[tool]]\nnumber = 1\nname = \"F10\"\nkind = \"flat\"\ndiameter_mm = 10\nflute_length_mm = 30\ngauge_length_mm = 60\n{more}"
    );
    ToolLibrary::from_text(Path::new("tools.toml"), &text).unwrap().tools.remove(0)
}

fn material(convention: &str, kc11: f64, exponent: f64, more: &str) -> Material {
    let text = format!(
        "name = \"m\"\nsource = \"test\"\nconvention = \"{convention}\"\nkc11_n_mm2 = {kc11}\nexponent = {exponent}\n\
         axial_ratio = 0\nuncertainty_percent = 10\n{more}"
    );
    Material::from_text(Path::new("m.toml"), &text).unwrap()
}

/// A cut of the depth `depth` over a range of angles, degrees, at a feed across the axis, mm/s.
fn cut(depth: f64, range: [f64; 2], feed: f64) -> SliceCut {
    SliceCut {
        height: [0.0, depth],
        range: Some(range.map(f64::to_radians)),
        around: false,
        feed_across: feed,
        feed_down: 0.0,
    }
}
