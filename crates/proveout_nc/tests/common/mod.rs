//! Helpers shared by the tests of posts.

#![allow(
    clippy::unwrap_used,
    dead_code,
    unreachable_pub,
    reason = "helpers of tests: fail by panic, not all used by every test"
)]

use proveout_nc::post::{PostError, PostSettings, post_for};
use proveout_nc::{AxisValues, Command, Dialect, Feed, Motion, Op, Program, Settings};

/// Cases of a property; `PROVEOUT_NC_CASES` raises them.
pub fn cases(default: u32) -> u32 {
    std::env::var("PROVEOUT_NC_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(default)
}

pub fn ops(dialect: Dialect, text: &str, settings: &Settings) -> Vec<Command> {
    let settings = Settings { dialect, ..settings.clone() };
    let program = Program::from_text("program", text, &settings).unwrap_or_else(|e| panic!("{dialect:?}: {e}\n{text}"));
    program.map(|c| c.unwrap_or_else(|e| panic!("{dialect:?}: {e}\n{text}"))).collect()
}

pub fn post(commands: &[Command], to: Dialect, settings: PostSettings) -> Result<String, PostError> {
    let mut text = Vec::new();
    let mut post = post_for(to, settings, &mut text)?;
    for command in commands {
        post.write(command)?;
    }
    post.finish()?;
    drop(post);
    Ok(String::from_utf8(text).unwrap())
}

/// Motions with the feed that is in force.
fn motions(commands: &[Command]) -> Vec<(&Op, Option<Feed>)> {
    let mut feed = None;
    let mut list = Vec::new();
    for command in commands {
        match &command.op {
            Op::Feed(f) => feed = Some(*f),
            op @ Op::Rapid(_) => list.push((op, None)),
            op @ (Op::Linear(_) | Op::Arc(_)) => list.push((op, feed)),
            _ => {}
        }
    }
    list
}

/// A helix of several turns comes back as one block a turn where the control has no word for turns: joins
/// them.
fn joined(a: &[(&Op, Option<Feed>)], b: &[(&Op, Option<Feed>)]) -> Vec<(Op, Option<Feed>)> {
    let mut b = b.iter();
    let mut list = Vec::new();
    for (op, _) in a {
        let Some((other, feed)) = b.next() else { break };
        let mut whole = (*other).clone();
        if let (Op::Arc(want), Op::Arc(arc)) = (op, &mut whole) {
            while arc.sweep < want.sweep - 0.1 {
                let Some((Op::Arc(next), _)) = b.next() else { break };
                arc.sweep += next.sweep;
                arc.motion = next.motion.clone();
            }
        }
        list.push((whole, *feed));
    }
    list.extend(b.map(|(op, feed)| ((*op).clone(), *feed)));
    list
}

/// Axes that one program knows and the other does not are compared where they are programmed: knowledge about
/// an axis at rest is no motion.
fn near(a: &AxisValues, b: &AxisValues, programmed: u16, length: f64, text: &str) {
    for axis in 0..9 {
        let (Some(a), Some(b)) = (a.get(axis), b.get(axis)) else { continue };
        let limit = if (3..6).contains(&axis) { 0.0007f64.to_radians() } else { length };
        assert!((a - b).abs() < limit, "axis {axis}: {a} {b}\n{text}");
    }
    for axis in (0..3).filter(|axis| programmed >> axis & 1 == 1) {
        assert_eq!(a.get(axis).is_some(), b.get(axis).is_some(), "axis {axis}\n{text}");
    }
}

fn same_motion(a: &Motion, b: &Motion, length: f64, text: &str) {
    assert_eq!(a.machine_coordinates, b.machine_coordinates, "{text}");
    near(&a.end_base, &b.end_base, a.programmed, length, text);
    if let (Some(a), Some(b)) = (a.tool_axis_base, b.tool_axis_base) {
        // Six decimals of three components.
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 3e-6), "{a:?} {b:?}\n{text}");
    }
}

/// The same motions with the same feeds, lengths within `length` mm.
pub fn same_commands(first: &[Command], second: &[Command], length: f64, text: &str) {
    let (a, b) = (motions(first), motions(second));
    let b = joined(&a, &b);
    assert_eq!(a.len(), b.len(), "{text}");
    for ((a, feed_a), (b, feed_b)) in a.into_iter().zip(b) {
        match (a, &b) {
            (Op::Rapid(a), Op::Rapid(b)) | (Op::Linear(a), Op::Linear(b)) => same_motion(a, b, length, text),
            (Op::Arc(a), Op::Arc(b)) => {
                same_motion(&a.motion, &b.motion, length, text);
                let near = |a: f64, b: f64, limit: f64| assert!((a - b).abs() < limit, "{a} {b}\n{text}");
                for i in 0..3 {
                    near(a.normal_base[i], b.normal_base[i], 1e-6);
                }
                // Rounding of both ends moves the center of a short arc by the inverse of its half chord;
                // said by its radius, the center of an arc near a half turn by the inverse of its height over
                // the chord.
                let (s, c) = (0.5 * a.sweep.min(std::f64::consts::TAU)).sin_cos();
                let lever = (1.0 / s.abs().max(1e-3)).max(1.0 / c.abs().max(0.17));
                near(a.radius, b.radius, 4.0 * length * lever);
                near(a.sweep, b.sweep, 8.0 * length * lever / a.radius);
            }
            // An arc that is shorter than the last decimal.
            (Op::Arc(a), Op::Linear(b)) => same_motion(&a.motion, b, length, text),
            (a, b) => panic!("{a:?}\n{b:?}\n{text}"),
        }
        match (feed_a, feed_b) {
            (Some(Feed::PerTime(a)), Some(Feed::PerTime(b))) => assert!((a - b).abs() < 1e-3 * a + 0.002, "{text}"),
            (Some(Feed::PerRevolution(a)), Some(Feed::PerRevolution(b))) => assert!((a - b).abs() < 1e-3, "{text}"),
            (a, b) => assert_eq!(a, b, "{text}"),
        }
    }
}
