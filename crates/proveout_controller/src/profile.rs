//! Time law of a stretch of path: phases of constant jerk, run with a tempo.

use crate::{
    jerk_ramp::{Rates, ramp_distance, ramp_shape},
    tempo::Tempo,
};

/// Step of time at which the search for a place ends, part of the phase.
const FOUND: f64 = 1e-15;
/// Duration that a phase counts for at least in this, s.
const SHORT_PHASE_S: f64 = 1e-9;
/// A time this near to a border of two phases is on it, part of the law and of a second at least.
const AT_BORDER: f64 = 1e-9;
/// A place this near to the end is the end, part of the way and of one at least.
const AT_END: f64 = 1e-13;

/// State along the path parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PathState {
    pub(crate) s: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
    pub(crate) j: f64,
}

/// One phase of constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Phase {
    /// Begin, s, from the start of the law.
    pub(crate) time: f64,
    /// Length, s.
    pub(crate) duration: f64,
    /// State at the begin.
    pub(crate) start: PathState,
}

impl Phase {
    pub(crate) fn at(&self, dt: f64) -> PathState {
        let p = self.start;
        PathState {
            s: p.s + dt * (p.v + dt * (0.5 * p.a + dt * p.j / 6.0)),
            v: (p.v + dt * (p.a + 0.5 * dt * p.j)).max(0.0),
            a: p.a + dt * p.j,
            j: p.j,
        }
    }

    /// Time within the phase at which `s` is reached; speed is never below zero, so that s grows.
    fn time_at(&self, s: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.duration);
        if s <= self.start.s {
            return 0.0;
        }
        if s >= self.at(high).s {
            return high;
        }
        let p = self.start;
        let mut t = if p.a == 0.0 && p.j == 0.0 && p.v > 0.0 { (s - p.s) / p.v } else { 0.5 * high };
        for _ in 0..60 {
            let now = self.at(t);
            let f = now.s - s;
            if f > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let mut next = if now.v > 0.0 { t - f / now.v } else { 0.5 * (low + high) };
            if !(next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            if (next - t).abs() <= FOUND * high.max(SHORT_PHASE_S) {
                return next;
            }
            t = next;
        }
        t
    }
}

/// Position of a forward walk through a law; makes the walk linear in cost.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cursor {
    tempo: usize,
    phase: usize,
}

/// Phases of constant jerk without gap, run with a tempo (`tempo.rs`).
///
/// ```text
///   time of the run t --tempos--> time of the phases p --phases--> path parameter s
/// ```
///
/// None of them ever falls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Law {
    pub(crate) phases: Vec<Phase>,
    /// Length of the phases in their own time, s.
    pub(crate) planned: f64,
    /// Stretches of the phases' time without gap; none: the phases run as they are.
    pub(crate) tempos: Vec<Tempo>,
    /// Length of the law, s.
    pub(crate) duration: f64,
}

impl Law {
    fn push(&mut self, s: f64, v: f64, a: f64, j: f64, duration: f64) {
        if duration > 0.0 {
            self.phases.push(Phase { time: self.planned, duration, start: PathState { s, v, a, j } });
            self.planned += duration;
            self.duration = self.planned;
        }
    }

    /// Appends ramp, cruise and ramp over `[s0, s1]`: from speed `v0` to `peak` and down to `v1`, with zero
    /// acceleration at both ends. `peak` is that of [`crate::jerk_ramp::peak_speed`]. A pair of ramps that is
    /// longer than the path (by rounding) is compressed in time so that it ends exactly at `s1`.
    pub(crate) fn push_move(&mut self, [s0, s1]: [f64; 2], [v0, peak, v1]: [f64; 3], up: Rates, down: Rates) {
        let distance = s1 - s0;
        let (d_up, d_down) = (ramp_distance(v0, peak, up), ramp_distance(v1, peak, down));
        let need = d_up + d_down;
        let squeeze = if need > distance { distance / need } else { 1.0 };
        self.push_ramp(s0, v0, peak, up, squeeze);
        let (begin, end) = (s0 + d_up * squeeze, s1 - d_down * squeeze);
        if end > begin && peak > 0.0 {
            self.push(begin, peak, 0.0, 0.0, (end - begin) / peak);
        }
        self.push_ramp(end, peak, v1, down, squeeze);
    }

    fn push_ramp(&mut self, s: f64, v0: f64, v1: f64, rates: Rates, squeeze: f64) {
        let shape = ramp_shape((v1 - v0).abs(), rates);
        let sign = if v1 >= v0 { 1.0 } else { -1.0 };
        let (tj, th) = (shape.jerk_time * squeeze, shape.hold_time * squeeze);
        let a = sign * shape.acceleration / squeeze;
        let j = if tj > 0.0 { a / tj } else { 0.0 };
        self.push(s, v0, 0.0, j, tj);
        let (s_a, v_a) = (s + tj * (v0 + tj * tj * j / 6.0), v0 + 0.5 * a * tj);
        self.push(s_a, v_a, a, 0.0, th);
        let (s_b, v_b) = (s_a + th * (v_a + 0.5 * a * th), v_a + a * th);
        self.push(s_b, v_b, a, -j, tj);
    }

    /// Uniform motion at speed one from `s0`.
    pub(crate) fn uniform(s0: f64, duration: f64) -> Self {
        let mut law = Self::default();
        law.push(s0, 1.0, 0.0, 0.0, duration);
        law
    }

    /// Runs the phases with these tempos, which follow each other over all of their time.
    pub(crate) fn set_tempos(&mut self, tempos: Vec<Tempo>) {
        self.duration = tempos.last().map_or(self.planned, |t| t.time + t.duration);
        self.tempos = tempos;
    }

    /// Runs all of the law slower by a factor.
    pub(crate) fn slow_down(&mut self, factor: f64) {
        if self.tempos.is_empty() {
            self.tempos.push(Tempo::even(0.0, self.planned, 0.0));
        }
        for tempo in &mut self.tempos {
            tempo.square = tempo.square.map(|b| b / (factor * factor));
            tempo.time *= factor;
            tempo.duration *= factor;
        }
        self.duration *= factor;
    }

    /// The phases of `whole`, of which these are the first ones, run as these and then as they are.
    pub(crate) fn followed_by(self, mut whole: Self) -> Self {
        if let Some(last) = self.tempos.last() {
            let p = last.begin + last.length;
            let even = Tempo::even(p, whole.planned - p, self.duration);
            let mut tempos = self.tempos;
            if even.length > 0.0 {
                tempos.push(even);
            }
            whole.set_tempos(tempos);
        }
        whole
    }

    /// Keeps the part before the time `p` of the phases (a border of two of them) and returns the
    /// part after it, as a law of its own.
    pub(crate) fn cut(&mut self, p: f64) -> Self {
        let near = AT_BORDER * self.planned.max(1.0);
        let mut behind = Self::default();
        if p >= self.planned - near {
            return behind;
        }
        let first = self.phases.partition_point(|phase| phase.time < p - near);
        behind.phases = self.phases.split_off(first);
        let (end, whole) = (self.planned, self.duration);
        self.planned = self.phases.last().map_or(0.0, |phase| phase.time + phase.duration);
        let at = self.planned;
        behind.planned = end - at;
        let mut before: Vec<Tempo> = Vec::new();
        for tempo in self.tempos.drain(..) {
            if tempo.begin + tempo.length <= at {
                before.push(tempo);
            } else if tempo.begin >= at {
                behind.tempos.push(tempo);
            } else {
                let [left, right] = tempo.cut(at);
                before.push(left);
                behind.tempos.push(right);
            }
        }
        self.duration = before.last().map_or(at, |t| t.time + t.duration);
        behind.duration = whole - self.duration;
        for tempo in &mut behind.tempos {
            tempo.begin -= at;
            tempo.time -= self.duration;
        }
        for phase in &mut behind.phases {
            phase.time -= at;
        }
        self.tempos = before;
        behind
    }

    /// State at rest at the end.
    pub(crate) fn end(&self) -> PathState {
        let s = self.phases.last().map_or(0.0, |p| p.at(p.duration).s);
        PathState { s, v: 0.0, a: 0.0, j: 0.0 }
    }

    /// State at a time.
    pub(crate) fn at(&self, time: f64, cursor: &mut Cursor) -> PathState {
        let Some(tempo) = stand(&self.tempos, &mut cursor.tempo, |t| t.time <= time) else {
            return self.planned_at(time, cursor);
        };
        let [p, p1, p2, p3] = tempo.at((time - tempo.time).clamp(0.0, tempo.duration));
        let x = self.planned_at(p, cursor);
        PathState {
            s: x.s,
            v: x.v * p1,
            a: x.v * p2 + x.a * p1 * p1,
            j: x.v * p3 + 3.0 * x.a * p1 * p2 + x.j * p1 * p1 * p1,
        }
    }

    /// Time of the phases at a time of the run.
    pub(crate) fn planned_time(&self, time: f64, cursor: &mut Cursor) -> f64 {
        match stand(&self.tempos, &mut cursor.tempo, |t| t.time <= time) {
            Some(tempo) => tempo.at((time - tempo.time).clamp(0.0, tempo.duration))[0],
            None => time,
        }
    }

    /// State of the phases at their own time.
    pub(crate) fn planned_at(&self, p: f64, cursor: &mut Cursor) -> PathState {
        match stand(&self.phases, &mut cursor.phase, |phase| phase.time <= p) {
            Some(phase) => phase.at((p - phase.time).clamp(0.0, phase.duration)),
            None => PathState::default(),
        }
    }

    /// Time at which `s` is reached.
    pub(crate) fn time_at(&self, s: f64, cursor: &mut Cursor) -> f64 {
        let p = self.planned_time_at(s, cursor);
        if p >= self.planned {
            return self.duration;
        }
        match stand(&self.tempos, &mut cursor.tempo, |t| t.begin <= p) {
            Some(tempo) => tempo.time + tempo.passed(p - tempo.begin),
            None => p,
        }
    }

    /// Time of the phases at which `s` is reached.
    pub(crate) fn planned_time_at(&self, s: f64, cursor: &mut Cursor) -> f64 {
        if self.phases.is_empty() {
            return 0.0;
        }
        // Near a standstill time is a cube root of the way: rounding of s must not become a visible error of
        // time.
        if s >= self.end().s - AT_END * s.abs().max(1.0) {
            return self.planned;
        }
        match stand(&self.phases, &mut cursor.phase, |phase| phase.start.s <= s) {
            Some(phase) => phase.time + phase.time_at(s),
            None => 0.0,
        }
    }
}

/// The last entry that has begun, or the first, searched from the cursor on.
fn stand<'a, T>(list: &'a [T], cursor: &mut usize, begun: impl Fn(&T) -> bool) -> Option<&'a T> {
    let last = list.len().checked_sub(1)?;
    let mut i = (*cursor).min(last);
    while i > 0 && !begun(&list[i]) {
        i -= 1;
    }
    while i < last && begun(&list[i + 1]) {
        i += 1;
    }
    *cursor = i;
    Some(&list[i])
}
