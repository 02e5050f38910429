//! The bound over cells of two rotary joints, edge by edge.
//!
//! 1. At each station every cell of the grid that reaches into the cap has a potential: the middle is nearer
//!    to the axis than the radius and what the tool axis is off in the cell. Each cell is looked at; turns
//!    are counted with matrices, the product has the formula of Rodrigues.
//! 2. No potential is above the one of any cell of the station before, and the time from there: the feed
//!    between both stations, or the smallest way of a joint between both cells at its velocity.
//! 3. Both programs are in cells that have one. The bound is the least of the last station.

use serde_json::Value;

use super::{TaskError, list, number, numbers, wrong};

/// By how much angles may differ, radian, and times, s.
const ROUNDED: f64 = 1e-9;
const ROUNDED_S: f64 = 1e-9;

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Angle between unit vectors, by the chord and its complement.
fn angle(a: V, b: V) -> f64 {
    let apart: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let along: f64 = (0..3).map(|k| (a[k] + b[k]).powi(2)).sum::<f64>().sqrt();
    2.0 * apart.atan2(along)
}

/// Turn about a unit vector, as a matrix.
fn turn(about: V, by: f64) -> [V; 3] {
    let (s, c) = by.sin_cos();
    let [x, y, z] = about;
    let d = 1.0 - c;
    [
        [d * x * x + c, d * x * y - s * z, d * x * z + s * y],
        [d * x * y + s * z, d * y * y + c, d * y * z - s * x],
        [d * x * z - s * y, d * y * z + s * x, d * z * z + c],
    ]
}

fn times(m: [V; 3], v: V) -> V {
    m.map(|row| dot(row, v))
}

fn vector(value: &Value) -> Result<V, TaskError> {
    let v = [0, 1, 2].map(|k| value[k].as_f64());
    let [Some(x), Some(y), Some(z)] = v else { return Err(wrong("a direction is not a vector")) };
    if (dot([x, y, z], [x, y, z]) - 1.0).abs() > 1e-6 {
        return Err(wrong("a direction is not a unit vector"));
    }
    Ok([x, y, z])
}

struct JointCells {
    direction: V,
    velocity: f64,
    cells: usize,
    size: f64,
    from: f64,
    programs: [Vec<f64>; 2],
}

fn joint(value: &Value, passed: f64) -> Result<JointCells, TaskError> {
    let cells = value["cells"].as_u64().and_then(|n| usize::try_from(n).ok()).filter(|n| *n > 0);
    let joint = JointCells {
        direction: vector(&value["direction"])?,
        velocity: number(value, "velocity_deg_s")?.to_radians() * (1.0 + passed),
        cells: cells.ok_or_else(|| wrong("a joint has no cells"))?,
        size: number(value, "size_deg")?.to_radians(),
        from: number(value, "from_deg")?.to_radians(),
        programs: [numbers(value, "new_deg")?, numbers(value, "original_deg")?],
    };
    if joint.velocity > 0.0 && joint.size > 0.0 {
        Ok(joint)
    } else {
        Err(wrong("a joint of the cells has no velocity or no cell size"))
    }
}

/// Checks the potentials; gives the bound that they prove.
pub(super) fn check(
    value: &Value,
    passed: f64,
    feed: impl Fn(usize, usize) -> f64,
    blocks: usize,
) -> Result<f64, TaskError> {
    let (inner, outer) = (joint(&value["inner"], passed)?, joint(&value["outer"], passed)?);
    if (outer.size * outer.cells as f64 - std::f64::consts::TAU).abs() > 1e-6 {
        return Err(wrong("the cells of the outer joint are not a turn"));
    }
    let (zero, radius) = (vector(&value["zero"])?, number(value, "radius_deg")?.to_radians());
    let whole = |v: &Value| v.as_u64().and_then(|n| usize::try_from(n).ok());
    let stations: Option<Vec<usize>> = list(value, "stations")?.iter().map(whole).collect();
    let stations = stations.ok_or_else(|| wrong("a station is not a gate"))?;
    if stations.len() < 2
        || stations[0] != 0
        || stations[stations.len() - 1] != blocks
        || stations.windows(2).any(|p| p[0] >= p[1])
    {
        return Err(wrong("the stations do not increase from the first gate to the last"));
    }
    let (axes, cells, potentials) = (list(value, "axes")?, list(value, "cells")?, list(value, "potentials_s")?);
    let whole_lists = [
        axes.len(),
        cells.len(),
        potentials.len(),
        inner.programs[0].len(),
        inner.programs[1].len(),
        outer.programs[0].len(),
        outer.programs[1].len(),
    ];
    if whole_lists.iter().any(|n| *n != stations.len()) {
        return Err(wrong("cells need one list per station"));
    }
    let mut last: Vec<([usize; 2], f64)> = Vec::new();
    for s in 0..stations.len() {
        let ids: Option<Vec<usize>> = cells[s].as_array().and_then(|all| all.iter().map(whole).collect());
        let times_s: Option<Vec<f64>> =
            potentials[s].as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
        let (Some(ids), Some(times_s)) = (ids, times_s) else { return Err(wrong(format!("station {s} has no cells"))) };
        if ids.len() != times_s.len()
            || ids.is_empty()
            || ids.windows(2).any(|p| p[0] >= p[1])
            || ids[ids.len() - 1] >= inner.cells * outer.cells
        {
            return Err(wrong(format!("the cells of station {s} do not increase, or lack one time each")));
        }
        let now: Vec<([usize; 2], f64)> =
            ids.iter().zip(times_s).map(|(id, t)| ([id / outer.cells, id % outer.cells], t)).collect();
        let axis = vector(&axes[s])?;
        let mut next = 0;
        for j in 0..inner.cells {
            let carried = times(turn(inner.direction, inner.from + (j as f64 + 0.5) * inner.size), zero);
            let lean = angle(carried, outer.direction);
            let off = 0.5 * (inner.size + outer.size * lean.sin());
            for k in 0..outer.cells {
                let id = j * outer.cells + k;
                let listed = ids.get(next) == Some(&id);
                next += usize::from(listed);
                let middle = times(turn(outer.direction, outer.from + (k as f64 + 0.5) * outer.size), carried);
                if !listed && angle(middle, axis) < radius + off - ROUNDED {
                    return Err(wrong(format!("cell {id} of station {s} reaches into the cap, but is missing")));
                }
            }
        }
        for (which, program) in ["new", "original"].into_iter().enumerate() {
            let place = [
                ((inner.programs[which][s].to_radians() - inner.from) / inner.size).floor(),
                ((outer.programs[which][s].to_radians() - outer.from) / outer.size)
                    .floor()
                    .rem_euclid(outer.cells as f64),
            ];
            // A place on the border of two cells is in both.
            let near = |cell: &[usize; 2]| {
                let round = (cell[1] as f64 - place[1]).abs();
                (cell[0] as f64 - place[0]).abs() <= 1.0 && round.min(outer.cells as f64 - round) <= 1.0
            };
            if !now.iter().any(|(cell, _)| near(cell)) {
                return Err(wrong(format!("the {program} program is in no cell of station {s}")));
            }
        }
        let feed = if s > 0 { feed(stations[s - 1], stations[s]) } else { 0.0 };
        for (cell, time) in &now {
            if s == 0 {
                if *time > 0.0 {
                    return Err(wrong("a potential of the first station is above zero"));
                }
                continue;
            }
            for (from, before) in &last {
                let inner_way = (from[0].abs_diff(cell[0]) as f64 - 1.0).max(0.0) * inner.size;
                let round = from[1].abs_diff(cell[1]);
                let outer_way = (round.min(outer.cells - round) as f64 - 1.0).max(0.0) * outer.size;
                let least = feed.max(inner_way / inner.velocity).max(outer_way / outer.velocity);
                if *time > before + least + ROUNDED_S {
                    return Err(wrong(format!(
                        "the potential of a cell of station {s} exceeds that of an earlier cell plus the travel from it"
                    )));
                }
            }
        }
        last = now;
    }
    let bound = last.iter().map(|(_, t)| *t).fold(f64::INFINITY, f64::min);
    if number(value, "bound_s")? > bound + ROUNDED_S {
        return Err(wrong("the bound of the cells is above the least potential of the last station"));
    }
    Ok(bound)
}
