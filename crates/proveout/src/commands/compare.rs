use std::{collections::BTreeSet, time::Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use proveout_sim::{
    Observer, Prepared,
    compare::{CompareChoice, Compared, Comparison},
    verdict::{Gate, State},
};

use crate::{
    args::CompareArgs,
    commands::run::{check_viewer, dynamics, pool, recorder, told_kept, word},
    failure::Failure,
    front::{self, CompareOrder},
    progress::{ParallelBars, Progress},
};

/// Compares the programs of a scene; the verdict over all of them and all criteria.
pub(crate) fn compare(args: &CompareArgs) -> Result<State, Failure> {
    let begin = Instant::now();
    let (threads, pool) = pool(args.resolution_mm, args.threads)?;
    check_viewer(args.rerun)?;
    let choice = CompareChoice {
        baseline: args.baseline.clone(),
        resolution_mm: args.resolution_mm,
        dynamics: args.dynamics.map(dynamics),
        ..CompareChoice::default()
    };
    let bar = motion_bar();
    let plain = bar.is_hidden();
    let told = |done: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
        if plain && done == total {
            tell!("{total} motions simulated on variations of the twin");
        }
    };
    let rerun = recorder(args.rerun);
    let order =
        CompareOrder { scene: &args.scene, choice: &choice, place: args.output.as_deref(), threads, rerun: &rerun };
    let beside = ParallelBars::new();
    let mut watchers = |prepared: &Prepared| -> Vec<Box<dyn Observer>> {
        bar.finish_and_clear();
        vec![Box::new(Progress::beside(&beside, &prepared.program_name, &prepared.running_file()))]
    };
    let (compared, committed) = pool.install(|| front::compare(&order, &told, &mut watchers))?;
    bar.finish_and_clear();
    let place = told_kept(committed);
    print_summary(&compared, &place, begin.elapsed().as_secs_f64());
    Ok(accepted(&compared.comparison, &args.accept_unchecked))
}

/// The verdict of a comparison. Unchecked gates of its programs that the call accepts count as passed, and
/// are reported. A value or a criterion of the scene that is open stays open.
fn accepted(comparison: &Comparison, gates: &[Gate]) -> State {
    let open = |s: State| s == State::Unchecked;
    let programs = comparison.programs.values();
    let unchecked: BTreeSet<&str> =
        programs.flat_map(|p| p.gates.iter().filter(|g| open(g.state)).map(|g| g.gate.name())).collect();
    let of_scene = comparison.published.iter().any(|p| p.band.is_some() && open(p.state))
        || comparison.expectations.iter().any(|e| open(e.state) && (e.at_least.is_some() || e.at_most.is_some()));
    let all = unchecked.iter().all(|name| gates.iter().any(|g| g.name() == *name));
    if comparison.verdict != State::Unchecked || unchecked.is_empty() || of_scene || !all {
        return comparison.verdict;
    }
    say!("\n  unchecked, accepted by --accept-unchecked: {}", Vec::from_iter(unchecked).join(", "));
    State::Pass
}

fn motion_bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} motions on variations of the twin  {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    bar
}

fn print_summary(compared: &Compared, place: &std::path::Path, wall: f64) {
    let c = &compared.comparison;
    say!("\n{}: {}  (baseline {})\n", word(c.verdict).to_uppercase(), c.scene, c.baseline);
    if let Some(limits) = c.limits_in_words() {
        say!("  limits that the scene sets: {limits}\n");
    }
    say!("  {:<16} {:<10} {:>10} {:>10} {:>10}", "program", "verdict", "total, s", "feed, s", "stretch, s");
    let number = |v: Option<f64>, digits: usize| {
        // What rounds to zero has no sign.
        let zero = 0.5 * 0.1_f64.powi(digits as i32);
        v.map_or_else(|| "-".to_owned(), |v| format!("{:.digits$}", if v.abs() < zero { 0.0 } else { v }))
    };
    for (name, p) in c.order.iter().filter_map(|n| c.programs.get_key_value(n)) {
        let stretch = number(p.stretch.as_ref().map(|s| s.time_s), 3);
        say!("  {name:<16} {:<10} {:>10.3} {:>10.3} {stretch:>10}", word(p.verdict), p.time.total_s, p.time.cutting_s);
    }
    if let Some(same) = c.same_texts_in_words() {
        say!("\n  programs with identical text: {same}");
    }
    say!("\n  time of the cutting stretch saved, percent");
    for (name, g) in c.order.iter().filter_map(|n| c.gains.get_key_value(n)) {
        let t = &g.stretch_time;
        say!(
            "  {name:<16} {:>8} +- {:<6} ({} to {} in {} variations; sign {})",
            number(t.percent, 2),
            number(t.error_percent, 2),
            number(t.smallest_percent, 2),
            number(t.largest_percent, 2),
            c.variations.iter().filter(|v| v.unchecked.is_none() && v.acts).count(),
            if t.sign_holds { "holds" } else { "changes" }
        );
        if let Some(percent) = c.at_own_limits(name) {
            say!("  {:<16} {:>8} with the machine's own limits", "", number(Some(percent), 2));
        }
    }
    if !c.published.is_empty() {
        say!("\n  published values");
        for p in &c.published {
            let band =
                p.band.map_or_else(String::new, |[low, high]| format!("; band {low} to {high}: {}", word(p.state)));
            say!(
                "    {:<44} {}{} here {} {}  {}{band}",
                p.name,
                p.kind.label(),
                p.published,
                number(p.value, 1),
                p.unit,
                p.agreement.words()
            );
        }
    }
    for e in &c.expectations {
        let value = e.value.map_or_else(String::new, |v| format!("{v:.4} {}", e.unit));
        say!("  {:<9} {}  {value} {}", word(e.state), e.name, if e.state == State::Pass { "" } else { &e.reason });
    }
    say!("\n  computed in {wall:.1} s");
    say!("  results: {}", place.display());
    say!("           {} in a browser", place.join("compare.html").display());
}
