//! Contours of which the path, the depth or the verdict is known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proveout_nc::{Dialect, Overcut, OvercutKind};

use crate::gouge_free::program::{Block, Contour, DIALECTS, Form, Read};
use crate::gouge_free::shape::{Point, Shape, far};
use crate::gouge_free::{judge, walls};

fn contour(from: Point, start: Point, blocks: Vec<Block>, to: Point, left: bool, radius: f64) -> Contour {
    Contour { from, start, blocks, to, left, radius, digits: 9 }
}

fn taken(form: &Form, c: &Contour) -> Read {
    let text = form.text(c);
    let read = form.read(&text, Some(c.radius)).unwrap_or_else(|error| panic!("{error}\n{text}"));
    judge(form, c, &text, &read);
    read
}

fn kinds(read: &Read) -> Vec<OvercutKind> {
    read.overcuts.iter().map(|(_, overcut)| overcut.kind).collect()
}

/// Those that do not belong to entry and exit.
fn inner(read: &Read) -> Vec<OvercutKind> {
    kinds(read).into_iter().filter(|k| !matches!(k, OvercutKind::Entry | OvercutKind::Exit)).collect()
}

/// Two half circles above the first axis that meet in the origin, run to the right.
fn bumps(from: Point, left: bool, radius: f64) -> Contour {
    let blocks = vec![
        Block::Arc([0.0, 0.0], [-5.0, 0.0], false),
        Block::Arc([10.0, 0.0], [5.0, 0.0], false),
        Block::Line([10.0, -20.0]),
    ];
    let to = if left { [30.0, -20.0] } else { [-10.0, -20.0] };
    contour(from, [-10.0, 0.0], blocks, to, left, radius)
}

#[test]
fn a_cusp_of_two_arcs_is_an_inside_corner_above_them() {
    for dialect in DIALECTS {
        for radius in [0.5f64, 1.0, 2.0, 7.0] {
            // The equidistants, circles of 5 mm plus the radius, meet above the cusp.
            let peak = [0.0, ((5.0 + radius).powi(2) - 25.0).sqrt()];
            let read = taken(&Form::plain(dialect), &bumps([-40.0, 0.0], true, radius));
            assert!(kinds(&read).is_empty(), "{dialect:?} {radius} {read:?}");
            let arcs: Vec<_> = read.pieces.iter().filter(|(_, s)| matches!(s, Shape::Arc(..))).collect();
            let meet = arcs.windows(2).any(|a| far(a[0].1.at(1.0), peak) < 1e-9 && far(a[1].1.at(0.0), peak) < 1e-9);
            assert!(meet, "{dialect:?} {radius} {read:?}");
        }
    }
}

#[test]
fn a_cusp_of_two_arcs_is_an_outside_corner_below_them() {
    for dialect in DIALECTS {
        let read = taken(&Form::plain(dialect), &bumps([-5.0, -20.0], false, 2.0));
        // Inside of the half circles, on 3 mm; around the cusp over its other side.
        let around = read.pieces.iter().any(|(_, s)| {
            let p = s.at(0.5);
            far(p, [0.0, 0.0]) < 2.0 * 2f64.sqrt() + 1e-9 && p[1] < -1.9 && p[0].abs() < 1e-9
        });
        assert!(around, "{dialect:?} {read:?}");
    }
}

#[test]
fn a_rounded_cusp_is_one_still() {
    // The text leaves a sliver or an overlap of at most a tenth of a micrometer between the two arcs.
    for turn in [-3e-3, -1e-4, -1e-7, -1e-9, 0.0, 1e-9, 1e-7, 1e-4, 3e-3] {
        let (sine, cosine) = f64::sin_cos(turn);
        // The second bump, turned about the cusp.
        let turned = |p: Point| [cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1]];
        let mut c = bumps([-40.0, 0.0], true, 2.0);
        c.blocks[1] = Block::Arc(turned([10.0, 0.0]), turned([5.0, 0.0]), false);
        c.blocks[2] = Block::Line(turned([10.0, -20.0]));
        for dialect in DIALECTS {
            let read = taken(&Form::plain(dialect), &c);
            assert!(inner(&read).is_empty(), "{dialect:?} {turn} {read:?}");
            let above = read.pieces.iter().any(|(_, s)| far(s.at(1.0), [0.0, 24f64.sqrt()]) < 0.1);
            assert!(above, "{dialect:?} {turn} {read:?}");
        }
    }
}

/// Directions of the joints of a path: the change of heading from one piece to the next.
fn turns(read: &Read) -> Vec<f64> {
    let pairs = read.pieces.windows(2);
    let turn = |pair: &[(u32, Shape)]| {
        let (s, t) = (pair[0].1.heading(1.0), pair[1].1.heading(0.0));
        (s[0] * t[1] - s[1] * t[0]).atan2(s[0] * t[0] + s[1] * t[1])
    };
    pairs.map(turn).collect()
}

#[test]
fn near_tangent_corners_leave_no_spikes_and_no_crumbs() {
    // Two blocks of 20 mm length that meet in the origin at a small angle: lines, and arcs of 30 mm that bend
    // either way.
    let angles = [0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 4e-3, 0.01, 0.02, 0.05];
    for (w, side, first, second) in angles.iter().flat_map(|w| {
        let signs = [1.0, -1.0];
        let bends = [0.0, 1.0, -1.0];
        signs.into_iter().flat_map(move |s| bends.into_iter().flat_map(move |a| bends.map(|b| (*w, s, a, b))))
    }) {
        let turn: f64 = side * w;
        let block = |bend: f64, heading: f64, forth: f64| {
            // From the origin along the heading, or against it.
            let (sine, cosine) = heading.sin_cos();
            if bend == 0.0 {
                return (Block::Line([forth * 20.0 * cosine, forth * 20.0 * sine]), None);
            }
            let center: Point = [-bend * 30.0 * sine, bend * 30.0 * cosine];
            let (s, c) = (bend * forth * 20.0 / 30.0).sin_cos();
            let d = [-center[0], -center[1]];
            let end = [center[0] + c * d[0] - s * d[1], center[1] + s * d[0] + c * d[1]];
            (Block::Arc(end, center, bend > 0.0), Some(center))
        };
        let before = block(first, 0.0, -1.0);
        let start = before.0.end();
        let one = before.1.map_or(Block::Line([0.0; 2]), |center| Block::Arc([0.0; 2], center, first > 0.0));
        let two = block(second, turn, 1.0).0;
        for (dialect, radius) in DIALECTS.into_iter().flat_map(|d| [(d, 0.3), (d, 5.0)]) {
            for left in [true, false] {
                let up = if left { 1.0 } else { -1.0 };
                let headings = [-first * 20.0 / 30.0, turn + second * 20.0 / 30.0];
                let off = |p: Point, h: f64| [p[0] - up * 12.0 * h.sin(), p[1] + up * 12.0 * h.cos()];
                let c =
                    contour(off(start, headings[0]), start, vec![one, two], off(two.end(), headings[1]), left, radius);
                let form = Form::plain(dialect);
                let read = form.read(&form.text(&c), Some(radius)).unwrap();
                if dialect == Dialect::Siemens840d && radius > 1.0 {
                    judge(&form, &c, &form.text(&c), &read);
                }
                assert!(kinds(&read).is_empty(), "{w} {side} {first} {second} {dialect:?} {read:?}");
                let inner = &read.pieces[1..read.pieces.len() - 1];
                // Pieces of their own only where the tool would swerve by 1e-5 mm without them: one arc, or
                // two lines of half its length. The path never turns by more than the corner and what the
                // equidistants bend next to it.
                let shortest = inner.iter().map(|(_, s)| s.length()).fold(f64::INFINITY, f64::min);
                assert!(
                    shortest > 0.49 * (8e-5 * radius).sqrt(),
                    "{shortest} {w} {side} {first} {second} {dialect:?} {read:?}"
                );
                let entry = usize::from(dialect == Dialect::LinuxCnc);
                let all = turns(&read);
                for turn in &all[1 + entry.min(all.len() - 2)..all.len() - 1] {
                    assert!(turn.abs() <= 1.5 * w + 1e-6, "{turn} {w} {side} {first} {second} {dialect:?} {read:?}");
                }
            }
        }
    }
}

/// A slot of the given width that opens into a circle of 5 mm, in so many arcs, run with the inside on the
/// left.
fn keyhole(width: f64, radius: f64, arcs: usize) -> Contour {
    let (x, y) = (0.5 * width, (25.0 - 0.25 * width * width).sqrt());
    let (first, sweep) = (y.atan2(-x), TAU - 2.0 * x.atan2(y));
    let mut blocks = vec![Block::Line([-x, y])];
    for k in 1..=arcs {
        let angle = first + sweep * k as f64 / arcs as f64;
        blocks.push(Block::Arc([5.0 * angle.cos(), 5.0 * angle.sin()], [0.0; 2], true));
    }
    blocks.push(Block::Line([x, 30.0]));
    contour([radius - x, 40.0], [-x, 30.0], blocks, [x - radius, 40.0], true, radius)
}

#[test]
fn a_narrow_place_within_the_look_ahead_is_refused_and_reported_beyond() {
    for dialect in DIALECTS {
        for (ahead, arcs) in [(false, 1), (false, 2), (false, 3), (false, 4), (true, 3), (true, 4), (true, 5)] {
            let form = Form { ahead, ..Form::plain(dialect) };
            let read = taken(&form, &keyhole(4.1, 2.0, arcs));
            assert!(kinds(&read).is_empty(), "{dialect:?} {read:?}");
            // The corner at the end of the neck belongs to the first arc too, and cuts the last one.
            let narrow = keyhole(3.0, 2.0, arcs);
            if form.look_ahead() + 1 >= arcs {
                let error = form.read(&form.text(&narrow), Some(2.0)).unwrap_err();
                assert!(error.code == "nc-compensation" && error.message.contains("does not fit: along"), "{error}");
                // On the way around the corner of the neck; the tangents of a Fanuc meet beyond it.
                let fanuc = matches!(dialect, Dialect::Fanuc | Dialect::Haas | Dialect::Iso);
                let depth = if fanuc && arcs == 3 { "0.2241" } else { "1.0000" };
                assert!(error.message.contains(&format!("cuts {depth} mm into the contour of line")), "{error}");
                assert!(error.help.unwrap().contains("smaller tool"));
                continue;
            }
            let read = taken(&form, &narrow);
            let overcut: Vec<&(u32, Overcut)> =
                read.overcuts.iter().filter(|(_, o)| o.kind == OvercutKind::Narrow).collect();
            let deepest = overcut.iter().map(|(_, o)| o.depth).fold(0.0, f64::max);
            assert!((deepest - 1.0).abs() < 1e-6, "{dialect:?} {arcs} {read:?}");
            assert!(overcut[0].1.to_string().contains("does not fit between"), "{}", overcut[0].1);
            assert!(inner(&read).iter().all(|k| *k == OvercutKind::Narrow), "{read:?}");
        }
    }
}

#[test]
fn leading_in_and_out_on_arcs_is_no_fault() {
    // A full circle of 20 mm from inside, onto it and off it on quarter circles of 10 mm.
    for dialect in DIALECTS.into_iter().filter(|d| *d != Dialect::Apt) {
        let blocks = vec![
            Block::Arc([20.0, 0.0], [10.0, 0.0], true),
            Block::Arc([20.0, 0.0], [0.0, 0.0], true),
            Block::Arc([10.0, 10.0], [10.0, 0.0], true),
        ];
        let c = contour([10.0, 0.0], [10.0, -10.0], blocks, [10.0, 0.0], true, 3.0);
        let read = taken(&Form::plain(dialect), &c);
        let all = kinds(&read);
        assert!(all.contains(&OvercutKind::Overlap), "{all:?}");
        assert!(!all.contains(&OvercutKind::Narrow) && !all.contains(&OvercutKind::ContourEnd), "{dialect:?} {read:?}");
        let circle = read.pieces.iter().find(|(_, s)| matches!(s, Shape::Arc(_, r, ..) if (r - 17.0).abs() < 1e-12));
        assert!((circle.unwrap().1.length() - 17.0 * TAU).abs() < 1e-9);
    }
}

#[test]
fn beginning_and_ending_on_extensions_of_the_sides_is_no_fault() {
    let blocks = [[-15.0, 15.0], [15.0, 15.0], [15.0, -15.0], [-25.0, -15.0]].map(Block::Line).to_vec();
    for dialect in DIALECTS {
        for ahead in [false, true] {
            let c = contour([-20.0, -31.0], [-15.0, -25.0], blocks.clone(), [-31.0, -31.0], true, 5.0);
            let all = inner(&taken(&Form { ahead, ..Form::plain(dialect) }, &c));
            // Each of both extensions is cut by the tool on the other side; nothing else is.
            assert!(all.contains(&OvercutKind::Overlap), "{dialect:?} {all:?}");
            assert!(all.iter().all(|k| *k == OvercutKind::Overlap), "{dialect:?} {all:?}");
        }
    }
}

#[test]
fn closing_in_the_corner_that_it_began_beside_is_no_fault() {
    // As it is written by hand: on the extension of the first side, around, and off where the last side meets
    // it.
    let blocks = [[-15.0, 15.0], [15.0, 15.0], [15.0, -15.0], [-15.0, -15.0]].map(Block::Line).to_vec();
    for dialect in DIALECTS {
        for ahead in [false, true] {
            let c = contour([-20.0, -31.0], [-15.0, -25.0], blocks.clone(), [-31.0, -31.0], true, 5.0);
            let read = taken(&Form { ahead, ..Form::plain(dialect) }, &c);
            assert!(kinds(&read).iter().all(|k| *k == OvercutKind::Overlap), "{dialect:?} {read:?}");
        }
    }
}

#[test]
fn a_spiral_that_opens_a_pocket_is_no_fault() {
    // Half circles, each 1 mm farther out: the tool of 4 mm cuts what the passes before left, as it should.
    let (mut x, mut blocks) = (5.0f64, Vec::new());
    for k in 0..12 {
        let end = -x.signum() * (x.abs() + if k % 2 == 0 { 0.0 } else { 1.0 });
        blocks.push(Block::Arc([end, 0.0], [0.5 * (x + end), 0.0], true));
        x = end;
    }
    for dialect in DIALECTS {
        let c = contour([5.0, -10.0], [5.0, 0.0], blocks.clone(), [0.0, 0.0], true, 4.0);
        let all = inner(&taken(&Form::plain(dialect), &c));
        assert!(all.contains(&OvercutKind::Overlap) && !all.contains(&OvercutKind::Narrow), "{dialect:?} {all:?}");
    }
}

#[test]
fn a_pocket_begun_in_its_corner_cuts_its_first_side() {
    let blocks = [[30.0, 0.0], [30.0, 30.0], [0.0, 30.0], [0.0, 0.0]].map(Block::Line).to_vec();
    for dialect in DIALECTS {
        let form = Form::plain(dialect);
        let c = contour([15.0, 15.0], [0.0, 0.0], blocks.clone(), [15.0, 15.0], true, 4.0);
        let read = taken(&form, &c);
        // At its end the last side is next to its own end: on the first side, a whole radius deep.
        let narrow = read.overcuts.iter().find(|(_, overcut)| overcut.kind == OvercutKind::Narrow).unwrap();
        assert!((narrow.1.depth - 4.0).abs() < 1e-9, "{dialect:?} {narrow:?}");
    }
}

#[test]
fn an_entry_along_the_contour_cuts_its_start() {
    // From 10 mm before the start, on the line of the contour, the tool of 5 mm comes to its place next to
    // the start: nearest to the start where the way is square to it, at 10 sin(atan(5 / 10)).
    let depth = 5.0 - 10.0 * 0.5f64.atan().sin();
    let blocks = vec![Block::Line([40.0, 0.0])];
    for dialect in DIALECTS.into_iter().filter(|d| *d != Dialect::LinuxCnc) {
        let c = contour([-10.0, 0.0], [0.0, 0.0], blocks.clone(), [50.0, 0.0], true, 5.0);
        let read = taken(&Form::plain(dialect), &c);
        let of = |kind| read.overcuts.iter().find(|(_, overcut)| overcut.kind == kind).unwrap().1.depth;
        assert!((of(OvercutKind::Entry) - depth).abs() < 1e-9, "{read:?}");
        assert!((of(OvercutKind::Exit) - depth).abs() < 1e-9, "{read:?}");
        let c = contour([-10.0, 20.0], [0.0, 0.0], blocks.clone(), [50.0, 20.0], true, 5.0);
        assert!(kinds(&taken(&Form::plain(dialect), &c)).is_empty());
    }
}

#[test]
fn heights_and_rapid_motions_are_distinguished() {
    let form = Form::plain(Dialect::Siemens840d);
    // Along a wall, and back along a second one that is 6 mm from the first, by way of `side` at X30: a slot
    // open on both ends.
    let slot = |side: &str, back: &str| {
        format!(
            "G17 G90 T1 M6 D1 F1000\nG0 X-20 Y3 Z-5\nG41 G1 X-10 Y0\nX30\nX60\nX90\n{side}\nX60 {back}\nX30\nX-10\nG40 X-20 Y3\nM30\n"
        )
    };
    let of = |text: String, radius: f64| form.read(&text, Some(radius)).map(|read| inner(&read));
    // After the slot the tool has room to turn: three sides of a square of 20 mm.
    let turn = "Y-10\nX110\nY16\nX90\nY6";
    assert!(of(slot(turn, ""), 2.0).unwrap().is_empty());
    assert!(of(slot(turn, ""), 4.0).unwrap().contains(&OvercutKind::Narrow));
    // At another height the second wall may be another one.
    let above = of(slot(turn, "Z5"), 4.0).unwrap();
    assert!(above.contains(&OvercutKind::Above), "{above:?}");
    // Way back at rapid rate, high over the first wall: nothing is cut, and nothing is there that could
    // be.
    let rapid = slot("Y-10\nX110\nY16\nX90\nG0 Y6", "").replace("G40", "G40 G1");
    let rapid = form.read(&rapid, Some(4.0)).unwrap();
    assert!(!inner(&rapid).contains(&OvercutKind::Narrow), "{rapid:?}");
}

#[test]
fn a_helix_and_blocks_between_hold_their_distance() {
    for dialect in [Dialect::Siemens840d, Dialect::Fanuc, Dialect::LinuxCnc, Dialect::Heidenhain] {
        let form = Form { between: true, ..Form::plain(dialect) };
        let blocks = vec![
            Block::Arc([-20.0, 0.0], [0.0, 0.0], true),
            Block::Arc([20.0, 0.0], [0.0, 0.0], true),
            Block::Arc([-20.0, 0.0], [0.0, 0.0], true),
            Block::Arc([20.0, 0.0], [0.0, 0.0], true),
        ];
        let c = contour([10.0, 0.0], [20.0, 0.0], blocks, [10.0, 0.0], true, 6.0);
        let read = taken(&form, &c);
        let arcs: f64 = read.pieces.iter().filter(|(_, s)| matches!(s, Shape::Arc(..))).map(|(_, s)| s.length()).sum();
        // LinuxCNC comes onto the circle at an inside corner, which takes a part of the first half.
        let all = 4.0 * PI * 14.0;
        assert!(arcs <= all + 1e-9 && arcs > all - 14.0 * FRAC_PI_2, "{dialect:?} {arcs} {all}");
        assert_eq!(walls(&form, &form.text(&c)).len(), 4);
    }
}
