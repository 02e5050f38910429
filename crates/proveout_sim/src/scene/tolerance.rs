//! `[tolerances]` of a scene: bounds of the gates, and regions with bounds of their own for the texture of
//! the surface.

use proveout_geom::{Aabb, Point};
use proveout_input::{Step::Item, Step::Key};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::scene::place::offset_of;

/// Largest tolerance of a height, micrometers: a meter.
const HIGHEST_UM: f64 = 1e6;

/// Bounds of the gates.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Gouges deeper than this fail.
    pub gouge_mm: f64,
    /// Material left above this fails.
    pub excess_mm: f64,
    /// Bodies that come nearer than this are reported.
    pub near_miss_mm: f64,
    /// Overlap of a body with material below this counts as touching, not as cutting.
    pub contact_mm: f64,
    /// The 95th percentile of the scallop between the passes may be so high above the design, micrometer; not
    /// judged when left out.
    pub scallop_um: Option<f64>,
    /// Largest Ra of the patches and profiles of `[surface]`, across and along the lay, µm; not judged when
    /// left out.
    pub ra_um: Option<f64>,
    /// Largest Rz of the same, µm; not judged when left out.
    pub rz_um: Option<f64>,
    /// Boxes with bounds of their own. A place in several takes that of the first one that gives the key;
    /// outside of all, the one above holds.
    #[schemars(with = "Vec<ToleranceRegionFile>")]
    pub region: Vec<Spanned<ToleranceRegionFile>>,
}

/// Bounds of the surface in a box. A key that is left out has the bound of the whole surface.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToleranceRegionFile {
    /// Name, for findings and figures.
    pub name: String,
    /// Smallest coordinates, workpiece frame.
    pub min_mm: [f64; 3],
    /// Largest coordinates.
    pub max_mm: [f64; 3],
    /// 95th percentile of the scallop in the box, micrometer.
    pub scallop_um: Option<f64>,
    /// Largest Ra of the places in the box, µm.
    pub ra_um: Option<f64>,
    /// Largest Rz of the same, µm.
    pub rz_um: Option<f64>,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            gouge_mm: 0.05,
            excess_mm: 0.05,
            near_miss_mm: 1.0,
            contact_mm: 0.01,
            scallop_um: None,
            ra_um: None,
            rz_um: None,
            region: Vec::new(),
        }
    }
}

/// A tolerance that may have a bound of its own in a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SurfaceKey {
    Scallop,
    Ra,
    Rz,
}

/// A bound, µm, and the number of the region that gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
    pub(crate) um: f64,
    pub(crate) region: Option<usize>,
}

impl SurfaceKey {
    pub(crate) const ALL: [Self; 3] = [Self::Scallop, Self::Ra, Self::Rz];

    /// Its key in the scene.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Scallop => "scallop_um",
            Self::Ra => "ra_um",
            Self::Rz => "rz_um",
        }
    }
}

impl ToleranceRegionFile {
    fn bound(&self, key: SurfaceKey) -> Option<f64> {
        match key {
            SurfaceKey::Scallop => self.scallop_um,
            SurfaceKey::Ra => self.ra_um,
            SurfaceKey::Rz => self.rz_um,
        }
    }

    fn contains(&self, at: &Point) -> bool {
        Aabb { min: self.min_mm.into(), max: self.max_mm.into() }.contains(at)
    }
}

impl Tolerances {
    /// The bound of the whole surface.
    pub(crate) fn of_surface(&self, key: SurfaceKey) -> Option<f64> {
        match key {
            SurfaceKey::Scallop => self.scallop_um,
            SurfaceKey::Ra => self.ra_um,
            SurfaceKey::Rz => self.rz_um,
        }
    }

    /// Whether a bound is given for any place.
    pub(crate) fn asks(&self, key: SurfaceKey) -> bool {
        self.of_surface(key).is_some() || self.region.iter().any(|r| r.get_ref().bound(key).is_some())
    }

    /// The bound at a place (workpiece frame).
    pub(crate) fn limit(&self, key: SurfaceKey, at: &Point) -> Option<Limit> {
        let regions = self.region.iter().map(Spanned::get_ref).enumerate();
        let own = regions.filter(|(_, r)| r.contains(at)).find_map(|(k, r)| Some((r.bound(key)?, k)));
        match own {
            Some((um, k)) => Some(Limit { um, region: Some(k) }),
            None => self.of_surface(key).map(|um| Limit { um, region: None }),
        }
    }

    /// All bounds of a key: that of the whole surface first.
    pub(crate) fn limits(&self, key: SurfaceKey) -> Vec<Limit> {
        let own = self.of_surface(key).map(|um| Limit { um, region: None });
        let regions = self.region.iter().enumerate();
        let regions = regions.filter_map(|(k, r)| Some(Limit { um: r.get_ref().bound(key)?, region: Some(k) }));
        own.into_iter().chain(regions).collect()
    }

    /// Name of a region.
    pub(crate) fn region_name(&self, limit: &Limit) -> Option<&str> {
        limit.region.and_then(|k| self.region.get(k)).map(|r| r.get_ref().name.as_str())
    }

    /// What is wrong with it: offset in the text of the scene, message and help. `has_part`: the scene has a
    /// design.
    pub(crate) fn fault(&self, text: &str, has_part: bool) -> Option<(usize, String, &'static str)> {
        let lengths = [
            ("gouge_mm", self.gouge_mm),
            ("excess_mm", self.excess_mm),
            ("near_miss_mm", self.near_miss_mm),
            ("contact_mm", self.contact_mm),
        ];
        if let Some((key, value)) = lengths.into_iter().find(|(_, v)| !(0.0..1e3).contains(v)) {
            let at = offset_of(text, &[Key("tolerances"), Key(key)]);
            return Some((at, format!("{key} = {value} is not a tolerance"), "write a length from 0 to 1000 mm"));
        }
        let at = |key: SurfaceKey| offset_of(text, &[Key("tolerances"), Key(key.word())]);
        let of_surface = SurfaceKey::ALL.map(|key| (key, self.of_surface(key), at(key)));
        let in_region =
            |i, key: SurfaceKey| offset_of(text, &[Key("tolerances"), Key("region"), Item(i), Key(key.word())]);
        let of_regions = self
            .region
            .iter()
            .enumerate()
            .flat_map(|(i, r)| SurfaceKey::ALL.map(|k| (k, r.get_ref().bound(k), in_region(i, k))));
        for (key, bound, at) in of_surface.into_iter().chain(of_regions) {
            let Some(um) = bound else { continue };
            let word = key.word();
            if !(um > 0.0 && um <= HIGHEST_UM) {
                let help = "write a height above 0 and up to 1,000,000 micrometers, or leave it out";
                return Some((at, format!("{word} = {um} is not a height"), help));
            }
            if key == SurfaceKey::Scallop && !has_part {
                return Some((at, format!("{word} needs a design"), "give the design part as [part]"));
            }
        }
        for (k, region) in self.region.iter().enumerate() {
            let (r, at) = (region.get_ref(), region.span().start);
            let place = |message: String, help| Some((at, message, help));
            if (0..3).any(|i| !(r.min_mm[i] < r.max_mm[i] && r.min_mm[i].is_finite() && r.max_mm[i].is_finite())) {
                let message = format!("region {:?} is empty", r.name);
                return place(message, "write min_mm below max_mm in X, Y and Z");
            }
            if SurfaceKey::ALL.iter().all(|key| r.bound(*key).is_none()) {
                let message = format!("region {:?} sets no bound", r.name);
                return place(message, "give scallop_um, ra_um or rz_um, or leave the region out");
            }
            if r.name.trim().is_empty() || self.region[..k].iter().any(|o| o.get_ref().name == r.name) {
                let message = format!("the name {:?} of a region is empty or taken", r.name);
                return place(message, "give each region a name of its own");
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tolerances(text: &str) -> Tolerances {
        toml::from_str(text).expect("tolerances")
    }

    #[test]
    fn the_first_region_with_the_key_rules_and_elsewhere_the_surface() {
        let t = tolerances(
            "scallop_um = 20\nra_um = 1.6\n\
             [[region]]\nname = \"root\"\nmin_mm = [0, 0, 0]\nmax_mm = [10, 10, 10]\nra_um = 0.8\n\
             [[region]]\nname = \"fillet\"\nmin_mm = [5, 0, 0]\nmax_mm = [20, 10, 10]\nra_um = 3.2\nrz_um = 16\n",
        );
        let at = |x: f64| Point::new(x, 5.0, 5.0);
        let limit = |key, x| t.limit(key, &at(x)).map(|l| (l.um, l.region));
        assert_eq!(limit(SurfaceKey::Ra, 7.0), Some((0.8, Some(0))));
        assert_eq!(limit(SurfaceKey::Ra, 15.0), Some((3.2, Some(1))));
        assert_eq!(limit(SurfaceKey::Ra, 25.0), Some((1.6, None)));
        // The first region that holds the place says nothing of Rz: the next one does.
        assert_eq!(limit(SurfaceKey::Rz, 7.0), Some((16.0, Some(1))));
        assert_eq!(limit(SurfaceKey::Rz, 2.0), None);
        assert_eq!(limit(SurfaceKey::Scallop, 7.0), Some((20.0, None)));
        assert!(t.asks(SurfaceKey::Rz));
        assert_eq!(t.limits(SurfaceKey::Rz).len(), 1);
    }

    #[test]
    fn regions_that_mean_nothing_are_refused_by_name() {
        let region = |more: &str| format!("[[region]]\nname = \"r\"\nmin_mm = [0, 0, 0]\nmax_mm = [1, 1, 1]\n{more}");
        for (text, words) in [
            (region(""), "sets no bound"),
            (region("ra_um = 0\n"), "is not a height"),
            (region("scallop_um = 5\n"), "needs a design"),
            (region("ra_um = 1\n").replace("max_mm = [1, 1, 1]", "max_mm = [1, 0, 1]"), "is empty"),
            (region("ra_um = 1\n").repeat(2), "taken"),
        ] {
            let message = tolerances(&text).fault(&text, false).map(|f| f.1).unwrap_or_default();
            assert!(message.contains(words), "{message:?} for {text}");
        }
    }
}
