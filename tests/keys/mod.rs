//! Accepted means used: every key of the schemas of scene, machine and tools changes a verdict, a run, a
//! motion or what is made of them, or is refused. The list of keys comes from the schemas, so that none can
//! be forgotten.
//!
//! A case names a key, the setup in which it acts, and a change of its value. The setup is run as it is and
//! with the change; the two must not leave the same. Keys that only describe are listed with the reason why
//! nothing else is to be expected of them.

#![allow(clippy::print_stdout, reason = "a failed test lists every key at once")]

mod cases;
mod effect;
mod schema;
mod setups;
mod texts;

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use crate::keys::{
    cases::{CASES, Case, DESCRIBING},
    effect::Left,
    setups::Setup,
};

/// Does something with each of many, on as many threads as there are; results in their order.
fn each<T: Sync, R: Send>(all: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let threads = thread::available_parallelism().map_or(1, usize::from).min(4);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((k, one)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|k| Some((k, all.get(k)?)))
                {
                    let result = work(one);
                    done.lock().expect("no panic while it is held").push((k, result));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no panic while it was held");
    done.sort_by_key(|(k, _)| *k);
    done.into_iter().map(|(_, result)| result).collect()
}

#[test]
fn every_key_has_its_case_or_describes() {
    let keys = schema::keys();
    assert!(keys.len() > 280, "the schemas have {} keys", keys.len());
    let tried: BTreeSet<&str> = CASES.iter().map(|c| c.key).collect();
    let describing: BTreeSet<&str> = DESCRIBING.iter().map(|(key, _)| *key).collect();
    let missing: Vec<&String> =
        keys.iter().filter(|k| !tried.contains(k.as_str()) && !describing.contains(k.as_str())).collect();
    assert!(missing.is_empty(), "keys without a case: {missing:#?}");
    let stray: Vec<&&str> = tried.union(&describing).filter(|k| !keys.contains(**k)).collect();
    assert!(stray.is_empty(), "cases of keys that no schema has: {stray:#?}");
    let both: Vec<&&str> = tried.intersection(&describing).collect();
    assert!(both.is_empty(), "keys that act and describe: {both:#?}");
    assert!(DESCRIBING.iter().all(|(_, reason)| !reason.is_empty()));
}

/// Every sixth case; the night tries all of them.
#[test]
fn a_sixth_of_the_keys_change_what_is_left() {
    changes(&CASES.iter().step_by(6).collect::<Vec<_>>());
}

#[test]
#[ignore = "nightly, 169 s"]
fn every_key_changes_what_is_left() {
    changes(&CASES.iter().collect::<Vec<_>>());
}

fn changes(cases: &[&Case]) {
    let setups: BTreeSet<Setup> = cases.iter().map(|c| c.setup).collect();
    let setups: Vec<Setup> = setups.into_iter().collect();
    let lefts = each(&setups, |setup| effect::of(*setup, &setup.files()));
    let bases: BTreeMap<Setup, Left> = setups.into_iter().zip(lefts).collect();
    let broken: Vec<_> = bases.iter().filter_map(|(setup, left)| Some((setup, left.as_ref().err()?))).collect();
    assert!(broken.is_empty(), "cannot be run: {broken:#?}");
    let changed = each(cases, |case| effect::of(case.setup, &case.files()) != bases[&case.setup]);
    let without: Vec<String> = cases
        .iter()
        .zip(changed)
        .filter(|(_, changed)| !changed)
        .map(|(case, _)| format!("{} in {:?}: {:?}", case.key, case.setup, case.edits))
        .collect();
    assert!(without.is_empty(), "{} keys change nothing:\n{}", without.len(), without.join("\n"));
}

/// The measure itself: the same files leave the same, whatever the thread.
#[test]
fn the_same_files_leave_the_same() {
    for setup in [Setup::Mill, Setup::MillServo, Setup::Five, Setup::Remade] {
        assert_eq!(effect::of(setup, &setup.files()), effect::of(setup, &setup.files()), "{setup:?}");
    }
}
