//! Which values every job of a sweep has.

use super::file::{DesignFile, VaryFile};
use crate::{latin_hypercube::latin_hypercube, prepare::set_value::SetValue, scene::ChoiceValueFile};

/// The values of all jobs, made when they are asked for: a million jobs take no memory but that of a Latin
/// hypercube's order.
#[derive(Clone, Debug)]
pub struct Design {
    method: DesignFile,
    keys: Vec<String>,
    axes: Vec<Axis>,
    /// Of a Latin hypercube: for each key the place of every draw in its range, 0 to below 1.
    places: Vec<Vec<f64>>,
    jobs: usize,
}

/// What one key can be.
#[derive(Clone, Debug)]
enum Axis {
    Values(Vec<ChoiceValueFile>),
    /// Anything between, in a Latin hypercube.
    Range([f64; 2]),
}

impl Axis {
    fn of(vary: &VaryFile, method: DesignFile) -> Self {
        match (&vary.values, vary.range, method) {
            (None, Some(ends), DesignFile::LatinHypercube) => Self::Range(ends),
            (None, Some([low, high]), _) => {
                let last = vary.steps.unwrap_or(2).max(2) - 1;
                let at = |i: usize| if i == last { high } else { low + (high - low) * i as f64 / last as f64 };
                Self::Values((0..=last).map(|i| ChoiceValueFile::Number(at(i))).collect())
            }
            (values, ..) => Self::Values(values.clone().unwrap_or_default()),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Values(all) => all.len(),
            Self::Range(_) => 0,
        }
    }

    /// The value at a place from 0 to below 1.
    fn at(&self, place: f64) -> ChoiceValueFile {
        match self {
            Self::Values(all) => all[((place * all.len() as f64) as usize).min(all.len() - 1)].clone(),
            Self::Range([low, high]) => ChoiceValueFile::Number(low + (high - low) * place),
        }
    }

    /// The value of a number, from 0.
    fn nth(&self, number: usize) -> ChoiceValueFile {
        match self {
            Self::Values(all) => all[number].clone(),
            Self::Range([low, _]) => ChoiceValueFile::Number(*low),
        }
    }
}

impl Design {
    /// # Errors
    /// The key, by its number, that does not fit the others, with why.
    pub(super) fn new(method: DesignFile, vary: &[VaryFile], draws: usize, seed: u64) -> Result<Self, (usize, String)> {
        let axes: Vec<Axis> = vary.iter().map(|v| Axis::of(v, method)).collect();
        let (jobs, places) = match method {
            DesignFile::Grid => {
                let all = axes.iter().try_fold(1_usize, |n, v| n.checked_mul(v.len()));
                (all.unwrap_or(usize::MAX), Vec::new())
            }
            DesignFile::List => {
                let first = axes.first().map_or(0, Axis::len);
                if let Some(k) = axes.iter().position(|a| a.len() != first) {
                    return Err((k, format!("{} values, and the first key has {first}", axes[k].len())));
                }
                (first, Vec::new())
            }
            DesignFile::LatinHypercube => (draws, latin_hypercube(vary.len(), draws, seed)),
        };
        let keys = vary.iter().map(|v| v.key.clone()).collect();
        Ok(Self { method, keys, axes, places, jobs })
    }

    /// Number of jobs.
    pub fn len(&self) -> usize {
        self.jobs
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.jobs == 0
    }

    /// What varies.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// The values of a job.
    pub fn job(&self, number: usize) -> Vec<SetValue> {
        let mut left = number;
        let mut places = vec![0; self.keys.len()];
        for (k, place) in places.iter_mut().enumerate().rev() {
            match self.method {
                DesignFile::Grid => (*place, left) = (left % self.axes[k].len(), left / self.axes[k].len()),
                DesignFile::List | DesignFile::LatinHypercube => *place = number,
            }
        }
        let value = |k: usize| match self.method {
            DesignFile::LatinHypercube => self.axes[k].at(self.places[k][number]),
            DesignFile::Grid | DesignFile::List => self.axes[k].nth(places[k]),
        };
        (0..self.keys.len()).map(|k| SetValue { key: self.keys[k].clone(), value: value(k) }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vary(text: &str) -> VaryFile {
        toml::from_str(text).expect("one")
    }

    fn shown(design: &Design) -> Vec<String> {
        let words = |n| design.job(n).iter().map(|s| s.value.exact()).collect::<Vec<_>>().join(" ");
        (0..design.len()).map(words).collect()
    }

    #[test]
    fn a_grid_has_all_combinations_and_a_list_has_rows() {
        let keys = [vary("key = \"a.x\"\nvalues = [1, 2]"), vary("key = \"b.y\"\nrange = [0, 1]\nsteps = 3")];
        let grid = Design::new(DesignFile::Grid, &keys, 0, 0).expect("a grid");
        assert_eq!(shown(&grid), ["1 0", "1 0.5", "1 1", "2 0", "2 0.5", "2 1"]);
        let error = Design::new(DesignFile::List, &keys, 0, 0).expect_err("2 and 3 values");
        assert_eq!(error.0, 1);
        let keys = [vary("key = \"a.x\"\nvalues = [1, 2]"), vary("key = \"b.y\"\nvalues = [\"p\", \"q\"]")];
        assert_eq!(shown(&Design::new(DesignFile::List, &keys, 0, 0).expect("a list")), ["1 p", "2 q"]);
        let many = vec![vary("key = \"a.x\"\nrange = [0, 1]\nsteps = 1000"); 8];
        assert_eq!(Design::new(DesignFile::Grid, &many, 0, 0).expect("counted").len(), usize::MAX);
    }

    #[test]
    fn each_part_of_each_range_is_drawn_once() {
        let keys = [
            vary("key = \"a.x\"\nrange = [10, 20]"),
            vary("key = \"b.y\"\nvalues = [1, 2]"),
            vary("key = \"c.z\"\nrange = [0, 1]"),
        ];
        let design = Design::new(DesignFile::LatinHypercube, &keys, 40, 7).expect("draws");
        let number = |n: usize, k: usize| match design.job(n)[k].value {
            ChoiceValueFile::Number(v) => v,
            ChoiceValueFile::Whole(v) => v as f64,
            _ => f64::NAN,
        };
        let parts = |k: usize, of: &dyn Fn(f64) -> usize| {
            let mut parts: Vec<usize> = (0..40).map(|n| of(number(n, k))).collect();
            parts.sort_unstable();
            parts
        };
        assert_eq!(parts(0, &|v| ((v - 10.0) * 4.0) as usize), (0..40).collect::<Vec<_>>());
        assert_eq!(parts(2, &|v| (v * 40.0) as usize), (0..40).collect::<Vec<_>>());
        assert_eq!(parts(1, &|v| v as usize).iter().filter(|v| **v == 1).count(), 20);
        assert_eq!(shown(&design), shown(&Design::new(DesignFile::LatinHypercube, &keys, 40, 7).expect("the same")));
        assert_ne!(shown(&design), shown(&Design::new(DesignFile::LatinHypercube, &keys, 40, 8).expect("others")));
    }
}
