//! Helpers that take too long, take too much, fail or are not there.

use std::time::{Duration, Instant};

use proveout_step::{Helper, StepFiles};

use crate::fake::{ASKED_UM, Fake};

fn refusal(helper: Helper, fake: &Fake) -> String {
    let shop = fake.install();
    let helper = Helper { program: shop.helper.clone(), ..helper };
    let e = StepFiles::with_helper(helper).read(&shop.step, ASKED_UM).expect_err("refused");
    format!("{e}; {}", e.help())
}

fn with_script(script: &str) -> Fake {
    Fake { script: script.into(), ..Fake::new(16) }
}

#[test]
fn a_helper_that_does_not_end_is_ended() {
    let begin = Instant::now();
    let helper = Helper { time: Duration::from_millis(300), ..Helper::new("any".into()) };
    let refused = refusal(helper, &with_script("exec sleep 60"));
    assert!(refused.contains("took longer than 0.3 s and was ended"), "{refused}");
    assert!(refused.contains("`chord_um`"), "{refused}");
    // Far below the sleep, far above what a busy machine needs.
    assert!(begin.elapsed() < Duration::from_secs(30));
}

#[test]
fn output_without_end_is_ended() {
    let helper = Helper { output_mib: 2, time: Duration::from_secs(60), ..Helper::new("any".into()) };
    let refused = refusal(helper, &with_script("exec cat /dev/zero > \"$8/mesh.bin\""));
    assert!(refused.contains("wrote more than 2 MiB and was ended"), "{refused}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_without_end_is_ended() {
    let helper = Helper { memory_mib: 64, time: Duration::from_secs(60), ..Helper::new("any".into()) };
    // `tail` keeps a line that does not end.
    let refused = refusal(helper, &with_script("exec tail -n 1 /dev/zero"));
    assert!(refused.contains("took more than 64 MiB of memory and was ended"), "{refused}");
}

#[test]
fn a_refusal_is_handed_on_and_floods_of_words_do_not_block() {
    let refused = refusal(Helper::new("any".into()), &with_script("echo 'it has 2 open shells' >&2\nexit 2"));
    assert!(refused.contains("helper: it has 2 open shells; export it again"), "{refused}");
    // Two megabytes fill any pipe.
    let flood = "yes words | head -c 2000000 >&2\necho >&2\necho 'the last one' >&2\nexit 2";
    let refused = refusal(Helper::new("any".into()), &with_script(flood));
    assert!(refused.contains("helper: the last one"), "{refused}");
    let refused = refusal(Helper::new("any".into()), &with_script("exit 2"));
    assert!(refused.contains("refuses the file and gives no reason"), "{refused}");
}

#[test]
fn a_helper_that_fails_or_is_missing_is_named() {
    let refused = refusal(Helper::new("any".into()), &with_script("echo 'Segmentation' >&2\nkill -s SEGV $$"));
    assert!(refused.contains("it failed (signal: 11") && refused.contains("Segmentation"), "{refused}");
    let refused = refusal(Helper::new("any".into()), &with_script("exit 7"));
    assert!(refused.contains("exit status: 7") && refused.contains("gives no reason"), "{refused}");
    let shop = Fake::new(16).install();
    let missing = Helper::new(shop.folder.path().join("none"));
    let e = StepFiles::with_helper(missing).read(&shop.step, ASKED_UM).expect_err("refused");
    assert!(e.to_string().contains("it cannot be started"), "{e}");
    assert!(e.help().contains("pip install \"proveout[step]\""), "{}", e.help());
}

#[test]
fn a_file_that_is_missing_or_no_step_file_is_refused_before_the_helper_runs() {
    let mut fake = Fake::new(16);
    fake.text = "solid cube".into();
    let shop = fake.install();
    assert!(shop.read().expect_err("no STEP").to_string().contains("it is no STEP file"));
    let missing = shop.files().read(&shop.folder.path().join("none.step"), ASKED_UM).expect_err("missing");
    assert!(missing.to_string().contains("cannot open"), "{missing}");
    assert!(shop.calls().is_empty());
}
