//! cargo fuzz run heidenhain_iso fuzz/corpus ../tests/fuzz_seeds/heidenhain-iso
#![no_main]

#[path = "../../tests/common/mutate.rs"]
#[allow(dead_code, unreachable_pub)]
mod mutate;

use libfuzzer_sys::fuzz_target;
use proveout_nc::Dialect;

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    mutate::run(&text, Dialect::HeidenhainIso);
});
