//! The controls that come with the program.

macro_rules! controls {
    ($($name:literal),* $(,)?) => {
        /// Name and text of each, in alphabetical order.
        pub(super) const CONTROLS: &[(&str, &str)] = &[
            $(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../controls/", $name, ".toml")))),*
        ];
    };
}

controls! {
    "brother-c00",
    "dmg-tnc-640",
    "fagor-8055",
    "fanuc-0i",
    "fanuc-30i",
    "grbl-1.1",
    "haas-ngc",
    "heidenhain-itnc-530",
    "heidenhain-tnc-640",
    "hurco-isnc",
    "linuxcnc-2.9",
    "linuxcnc-xyzbc-trt",
    "mach3",
    "mazak-eia",
    "millplus",
    "mitsubishi-m800",
    "okuma-osp",
    "siemens-840d-sl",
}

/// Names of the controls that come with the program.
pub fn builtin_controls() -> impl Iterator<Item = &'static str> {
    CONTROLS.iter().map(|(name, _)| *name)
}

/// The file of a control that comes with the program.
pub(super) fn text_of(name: &str) -> Option<&'static str> {
    CONTROLS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}
