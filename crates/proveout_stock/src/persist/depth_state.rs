//! The memory of the run under way in bytes: depths go on with it where a run was stopped.

use proveout_geom::{Point, Vector};

use crate::{
    field::depth::{Depths, RunLaps},
    field::opening::Opening,
    persist::codec::{ByteFault, Decoder, Encoder, below},
};

impl Depths {
    /// Everything but the length below which nothing is measured.
    pub(crate) fn write(&self, out: &mut Encoder) {
        out.number(self.since.map_or(0, |id| u64::from(id) + 1));
        out.number(self.taken);
        out.number(self.run.0.len() as u64);
        for (&(set, i, j), all) in &self.run.0 {
            [u64::from(set), u64::from(i), u64::from(j), all.len() as u64].into_iter().for_each(|n| out.number(n));
            for (s, open) in all {
                s.iter().for_each(|s| out.real(*s));
                out.number(u64::from(open[0]) | u64::from(open[1]) << 1);
            }
        }
        out.number(self.opening.samples().len() as u64);
        for (p, n) in self.opening.samples() {
            [p.x, p.y, p.z, n.x, n.y, n.z].into_iter().for_each(|x| out.real(x));
        }
    }

    /// Takes over what [`Self::write`] wrote.
    pub(crate) fn read(&mut self, input: &mut Decoder<'_>) -> Result<(), ByteFault> {
        let since = below(input, u64::from(u32::MAX) + 2, "an invalid id")?;
        self.since = since.checked_sub(1).map(|id| id as u32);
        self.taken = input.number()?;
        self.run = RunLaps::default();
        for _ in 0..input.number()? {
            let set = below(input, 3, "an invalid set of rays")? as u8;
            let mut index = || Ok::<u32, ByteFault>(below(input, u64::from(u32::MAX) + 1, "an invalid ray")? as u32);
            let ray = (set, index()?, index()?);
            let count = below(input, input.left() as u64 + 1, "more intervals than there are bytes")?;
            let mut all = Vec::with_capacity(count as usize);
            for _ in 0..count {
                let s = [input.real()?, input.real()?];
                let open = below(input, 4, "an invalid flag")?;
                all.push((s, [open & 1 == 1, open & 2 == 2]));
            }
            self.run.0.insert(ray, all);
        }
        let count = below(input, input.left() as u64 + 1, "more samples than there are bytes")?;
        let mut samples = Vec::new();
        for _ in 0..count {
            let mut three = || Ok::<[f64; 3], ByteFault>([input.real()?, input.real()?, input.real()?]);
            samples.push((Point::from(three()?), Vector::from(three()?)));
        }
        self.opening = Opening::restored(samples);
        Ok(())
    }
}
