//! Adjacent lines at the side step that the scallop allows at every place (Lin and Koren 1996):
//! each line is the previous one, moved across its feed by as much as the cutter and the curvatures
//! allow there, so that every ridge is as high as it may be.

use super::{
    Line, ParameterCurve, PathError, PathPoint, Strategy, Task,
    curve::{Spline, fitted},
    error::LEAST_SCALLOP_MM,
    families::{check_along, within},
    strategy::{beside, to_and_fro},
};

/// Lines of constant scallop along the blade, from one u to another.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantScallop {
    /// First and last u, parts of the domain. The first line is `u = from`, the last one `u = to`.
    pub range: [f64; 2],
    /// Along the blade, parts of the domain.
    pub along: [f64; 2],
    /// Height of the ridges, mm.
    pub scallop: f64,
}

/// Places of a line that are moved.
const NODES: usize = 161;
/// Lines beyond which the numbers are a mistake.
const MOST_LINES: usize = 100_000;
/// Shortest piece of a line that is kept, part of the way along the blade.
const SHORTEST: f64 = 0.01;
/// Places nearer than this to the one before are left out, part of the way along the line.
const SAME_PLACE: f64 = 1e-9;
/// Least way across the lines, part of the domain.
const LEAST_WAY: f64 = 1e-9;

impl ConstantScallop {
    /// u of the next line over v: each place moved by its allowed chord.
    fn next(&self, task: &Task<'_>, line: &Spline, v: [f64; 2], ahead: f64) -> Result<Spline, PathError> {
        let surface = task.surface;
        let curve = along(line, v)?;
        let whole = Line::new("line".into(), curve.clone());
        let period = surface.domain().u_closed.then(|| surface.domain().u[1] - surface.domain().u[0]);
        let mut nodes = Vec::with_capacity(NODES);
        for k in 0..NODES {
            let part = k as f64 / (NODES - 1) as f64;
            let (place, allowed) = task.allowed(&whole, within(v, part), part, self.scallop)?;
            let u_direction = surface.local(place.uv[0], place.uv[1]).first[0];
            let side = place.across * (ahead * place.across.dot(&u_direction).signum());
            let mut reach = allowed;
            let mut found = place.uv;
            for _ in 0..3 {
                let guess = place.point + side * reach - place.normal * (0.5 * place.form[2] * reach * reach);
                found = surface.nearest(&guess);
                if let Some(period) = period {
                    found[0] += period * ((place.uv[0] - found[0]) / period).round();
                }
                let there = PathPoint { point: surface.local(found[0], found[1]).point, ..place };
                let gone = beside(&place, &there);
                if gone <= 0.0 {
                    break;
                }
                reach *= allowed / gone;
            }
            nodes.push(found);
        }
        let at = |p: &[f64; 2]| (p[1] - v[0]) / (v[1] - v[0]);
        // A rim of the surface holds nearest points: those that were to lie beyond it are left to the nodes
        // before.
        nodes.dedup_by(|a, b| at(a) <= at(b) + SAME_PLACE);
        if nodes.len() < NODES / 2 {
            let what = "lines of constant scallop fold over each other: begin at another line".to_owned();
            return Err(PathError::NoLine { what, section: self.along[0] });
        }
        let folded = || PathError::NoLine { what: "lines of constant scallop fold".into(), section: self.along[0] };
        let moved = Spline::new(nodes.iter().map(|p| p[1]).collect(), nodes.iter().map(|p| p[0]).collect());
        let moved = moved.ok_or_else(folded)?;
        let v: Vec<f64> = (0..NODES).map(|k| within(v, k as f64 / (NODES - 1) as f64)).collect();
        let u = v.iter().map(|&v| moved.at(v)[0]).collect();
        Spline::new(v, u).ok_or_else(folded)
    }
}

fn along(line: &Spline, v: [f64; 2]) -> Result<ParameterCurve, PathError> {
    let t: Vec<f64> = (0..NODES).map(|k| within(v, k as f64 / (NODES - 1) as f64)).collect();
    let points: Vec<[f64; 2]> = t.iter().map(|&v| [line.at(v)[0], v]).collect();
    fitted(&t, &points, "a line of constant scallop", 0.0)
}

/// The pieces of a line in front of `end`.
fn pieces(line: &Spline, v: [f64; 2], end: f64, ahead: f64) -> Vec<[f64; 2]> {
    const FINE: usize = 4 * NODES;
    let at = |k: usize| within(v, k as f64 / FINE as f64);
    let before = |v: f64| (end - line.at(v)[0]) * ahead > 0.0;
    let crossing = |mut a: f64, mut b: f64| {
        let side = before(a);
        for _ in 0..50 {
            let middle = 0.5 * (a + b);
            if before(middle) == side { a = middle } else { b = middle }
        }
        0.5 * (a + b)
    };
    let mut found: Vec<[f64; 2]> = Vec::new();
    let mut open = before(at(0)).then(|| at(0));
    for k in 1..=FINE {
        match (open, before(at(k))) {
            (None, true) => open = Some(crossing(at(k - 1), at(k))),
            (Some(from), false) => {
                found.push([from, crossing(at(k - 1), at(k))]);
                open = None;
            }
            _ => {}
        }
    }
    found.extend(open.map(|from| [from, at(FINE)]));
    found.retain(|[a, b]| b - a >= SHORTEST * (v[1] - v[0]));
    found
}

impl Strategy for ConstantScallop {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.along)?;
        PathError::within("the scallop in mm", self.scallop, LEAST_SCALLOP_MM, 10.0)?;
        let domain = task.surface.domain();
        let most = if domain.u_closed { 2.0 } else { 1.0 };
        PathError::within("the first line, part of the domain", self.range[0], 0.0, most)?;
        PathError::within("the last line, part of the domain", self.range[1], 0.0, most)?;
        let [low, high] = [self.along[0].min(self.along[1]), self.along[0].max(self.along[1])];
        let v = [within(domain.v, low), within(domain.v, high)];
        let [from, to] = self.range.map(|r| within(domain.u, r));
        PathError::within("the way across, part of the domain", (self.range[1] - self.range[0]).abs(), LEAST_WAY, 1.0)?;
        let ahead = (to - from).signum();
        let no = || PathError::NoLine { what: "the first line has no length".into(), section: low };
        let mut line = Spline::new(vec![v[0], v[1]], vec![from, from]).ok_or_else(no)?;
        let mut lines = Vec::new();
        loop {
            let kept = pieces(&line, v, to, ahead);
            if kept.is_empty() {
                break;
            }
            for piece in kept {
                lines.push(Line::new(format!("row {}", lines.len() + 1), along(&line, piece)?));
            }
            line = self.next(task, &line, v, ahead)?;
            if lines.len() > MOST_LINES {
                return Err(PathError::TooLong);
            }
        }
        let last = ParameterCurve::straight([to, v[0]], [to, v[1]]).ok_or_else(no)?;
        lines.push(Line::new(format!("row {}", lines.len() + 1), last));
        if self.along[1] < self.along[0] {
            for line in &mut lines {
                line.curve = line.curve.reversed();
            }
        }
        to_and_fro(&mut lines);
        Ok(lines)
    }
}
