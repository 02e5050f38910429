//! Time law of a stretch of path: phases of constant jerk.

use crate::scurve::{Rates, ramp_distance, ramp_shape};

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
    fn at(&self, dt: f64) -> PathState {
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
            if (next - t).abs() <= 1e-15 * high.max(1e-9) {
                return next;
            }
            t = next;
        }
        t
    }
}

/// Phases of constant jerk without gap; `s` and `time` never fall.
#[derive(Clone, Debug, Default)]
pub(crate) struct Law {
    pub(crate) phases: Vec<Phase>,
    /// Length of the law, s.
    pub(crate) duration: f64,
}

impl Law {
    fn push(&mut self, s: f64, v: f64, a: f64, j: f64, duration: f64) {
        if duration > 0.0 {
            self.phases.push(Phase { time: self.duration, duration, start: PathState { s, v, a, j } });
            self.duration += duration;
        }
    }

    /// Appends ramp, cruise and ramp over `[s0, s1]`: from speed `v0` to `peak` and down to `v1`, with zero acceleration
    /// at both ends. `peak` is that of [`crate::scurve::peak_speed`]. A pair of ramps that is longer than the path (by
    /// rounding) is compressed in time so that it ends exactly at `s1`.
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

    /// Highest speed between each pair of neighboring borders; acceleration changes its sign only between phases.
    pub(crate) fn peaks(&self, borders: &[f64]) -> Vec<f64> {
        let mut peaks = vec![0.0_f64; borders.len().saturating_sub(1)];
        let (mut phase, mut before) = (0, 0);
        let mut v_before = self.phases.first().map_or(0.0, |p| p.start.v);
        for (k, peak) in peaks.iter_mut().enumerate() {
            let t = self.time_at(borders[k + 1], &mut phase);
            let v = self.at(t, &mut phase).v;
            *peak = v_before.max(v);
            for p in &self.phases[before.min(phase)..=phase.min(self.phases.len().saturating_sub(1))] {
                if p.start.s >= borders[k] && p.start.s <= borders[k + 1] {
                    *peak = peak.max(p.start.v);
                }
            }
            (v_before, before) = (v, phase);
        }
        peaks
    }

    /// State at rest at the end.
    pub(crate) fn end(&self) -> PathState {
        let s = self.phases.last().map_or(0.0, |p| p.at(p.duration).s);
        PathState { s, v: 0.0, a: 0.0, j: 0.0 }
    }

    /// Index of the phase at a time, searched forward from `hint`.
    pub(crate) fn phase_at(&self, time: f64, hint: usize) -> usize {
        let mut i = hint.min(self.phases.len().saturating_sub(1));
        while i > 0 && self.phases[i].time > time {
            i -= 1;
        }
        while i + 1 < self.phases.len() && self.phases[i + 1].time <= time {
            i += 1;
        }
        i
    }

    /// State at a time; the cursor `hint` makes a forward walk linear.
    pub(crate) fn at(&self, time: f64, hint: &mut usize) -> PathState {
        *hint = self.phase_at(time, *hint);
        match self.phases.get(*hint) {
            Some(phase) => phase.at((time - phase.time).clamp(0.0, phase.duration)),
            None => PathState::default(),
        }
    }

    /// Time at which `s` is reached; the cursor `hint` makes a forward walk linear.
    pub(crate) fn time_at(&self, s: f64, hint: &mut usize) -> f64 {
        if self.phases.is_empty() {
            return 0.0;
        }
        // Near a standstill time is a cube root of the way: rounding of s must not become a visible error of time.
        if s >= self.end().s - 1e-13 * s.abs().max(1.0) {
            return self.duration;
        }
        let mut i = (*hint).min(self.phases.len() - 1);
        while i > 0 && self.phases[i].start.s > s {
            i -= 1;
        }
        while i + 1 < self.phases.len() && self.phases[i + 1].start.s <= s {
            i += 1;
        }
        *hint = i;
        self.phases[i].time + self.phases[i].time_at(s)
    }
}
