use super::super::free_taut_string;
pub(super) use super::random_schedules::Random;
use super::random_schedules::random_schedules;
use super::*;

fn one(least: Vec<f64>, gates: Vec<[f64; 2]>, limits: SwingLimits) -> Schedules {
    Schedules { least, joints: vec![JointGates { name: "A".into(), limits, gates }] }
}

fn only_velocity(velocity: f64) -> SwingLimits {
    SwingLimits { velocity, acceleration: f64::INFINITY, jerk: f64::INFINITY }
}

/// Least of `sum max(least, |dq|/V)` over a grid of positions, and by how much the grid may be above the
/// least of all.
fn grid_velocity(schedules: &Schedules, points: usize) -> (f64, f64) {
    let joint = &schedules.joints[0];
    let cells = |[low, high]: [f64; 2]| -> Vec<f64> {
        (0..points).map(|k| low + (high - low) * k as f64 / (points - 1) as f64).collect()
    };
    let mut front: Vec<(f64, f64)> = cells(joint.gates[0]).into_iter().map(|q| (q, 0.0)).collect();
    let mut error = 0.0;
    for (gate, least) in joint.gates[1..].iter().zip(&schedules.least) {
        front = cells(*gate)
            .into_iter()
            .map(|q| {
                let cost = |(p, t): &(f64, f64)| t + least.max((q - p).abs() / joint.limits.velocity);
                (q, front.iter().map(cost).fold(f64::INFINITY, f64::min))
            })
            .collect();
        // The nearest grid point is off by half a step; it changes the way before and the way after
        // it.
        error += (gate[1] - gate[0]) / (points - 1) as f64 / joint.limits.velocity;
    }
    error += 0.5 * (joint.gates[0][1] - joint.gates[0][0]) / (points - 1) as f64 / joint.limits.velocity;
    (front.iter().map(|f| f.1).fold(f64::INFINITY, f64::min), error)
}

#[test]
fn feed_and_velocity_are_the_optimum_of_a_search_over_all_positions() {
    let mut random = Random(3);
    let mut forced = 0;
    for _ in 0..400 {
        let n = 2 + (8.0 * random.next()) as usize;
        let least = (0..n).map(|_| 10_f64.powf(random.between(-1.5, 0.0))).collect();
        let gates = (0..=n)
            .map(|_| {
                let (a, b) = (random.between(-2.0, 2.0), random.between(-2.0, 2.0));
                [a.min(b), a.max(b)]
            })
            .collect();
        let schedules = one(least, gates, only_velocity(10_f64.powf(random.between(-1.0, 1.0))));
        let certificate = schedules.certificate().expect("sound");
        let (grid, error) = grid_velocity(&schedules, 401);
        assert!(certificate.bound <= grid + 1e-12 && grid - certificate.bound <= error, "{schedules:?}");
        forced += usize::from(certificate.bound > certificate.feed * (1.0 + 1e-9));
    }
    assert!(forced > 100, "{forced}");
}

#[test]
fn windows_follow_each_other_and_prove_their_sum() {
    let mut random = Random(29);
    let mut kinds = [0; 3];
    for _ in 0..1000 {
        let schedules = random_schedules(&mut random);
        let certificate = schedules.certificate().expect("sound");
        let mut at = 0;
        for (proof, time) in &certificate.windows {
            let [from, to] = proof.span();
            assert!(from == at && to > from, "{proof:?} behind gate {at}");
            assert_eq!(*time, schedules.time(proof));
            kinds[match proof {
                Proof::Feed { .. } => 0,
                Proof::Travel { .. } => 1,
                Proof::Swings { .. } => 2,
            }] += 1;
            at = to;
        }
        assert_eq!(at, schedules.least.len());
        let parts = certificate.velocity.iter().fold(certificate.feed, |a, b| a.max(*b));
        assert!(certificate.bound >= parts * (1.0 - 1e-12));
    }
    assert!(kinds.iter().all(|k| *k > 100), "{kinds:?}");
}

/// A motion is made first and a channel round it, so that the motion is one of the schedules: its time is
/// never below the bound.
#[test]
fn no_schedule_is_below_the_bound() {
    let mut random = Random(41);
    let (mut nearest, mut swung) = (f64::INFINITY, 0);
    for _ in 0..2000 {
        let waves: Vec<[f64; 3]> = (0..1 + (4.0 * random.next()) as usize)
            .map(|_| [random.between(0.1, 1.0), random.between(0.3, 12.0), random.between(0.0, 6.3)])
            .collect();
        let at = |t: f64, order: i32| -> f64 {
            let quarter = f64::from(order) * std::f64::consts::FRAC_PI_2;
            waves.iter().map(|[a, w, p]| a * w.powi(order) * (w * t + p + quarter).sin()).sum()
        };
        let time = random.between(0.5, 6.0);
        let largest =
            |order| (0..=600).map(|i| at(time * f64::from(i) / 600.0, order).abs()).fold(1e-9, f64::max) * 1.02;
        let mut limits = SwingLimits { velocity: largest(1), acceleration: largest(2), jerk: largest(3) };
        if random.next() < 0.3 {
            limits.jerk = f64::INFINITY;
        }
        let n = 2 + (120.0 * random.next()) as usize;
        let mut places: Vec<f64> = (0..=n).map(|_| time * random.next()).collect();
        places.sort_by(f64::total_cmp);
        (places[0], places[n]) = (0.0, time);
        let width = 10_f64.powf(random.between(-4.0, 0.3));
        let gates = places.iter().map(|t| {
            let q = at(*t, 0);
            [q - width * random.next(), q + width * random.next()]
        });
        let gates: Vec<[f64; 2]> = gates.collect();
        let slower = random.between(0.0, 1.0);
        let least = places.windows(2).map(|p| (slower * (p[1] - p[0])).max(1e-12)).collect();
        let certificate = one(least, gates, limits).certificate().expect("sound");
        assert!(certificate.bound <= time + 1e-9, "{} above {time}", certificate.bound);
        nearest = nearest.min(time / certificate.bound);
        swung += usize::from(certificate.windows.iter().any(|(p, _)| matches!(p, Proof::Swings { .. })));
    }
    assert!(nearest < 1.05 && swung > 200, "{nearest} {swung}");
}

#[test]
fn wider_gates_higher_limits_and_faster_feeds_never_raise_it() {
    let mut random = Random(53);
    for _ in 0..2000 {
        let narrow = random_schedules(&mut random);
        let mut wide = narrow.clone();
        let kind = (4.0 * random.next()) as usize;
        for joint in &mut wide.joints {
            for gate in &mut joint.gates {
                if kind == 0 || (kind == 3 && random.next() < 0.2) {
                    let more = 10_f64.powf(random.between(-4.0, 0.5));
                    *gate = [gate[0] - more * random.next(), gate[1] + more * random.next()];
                }
            }
            let mut raised = |v: &mut f64| *v *= 1.0 + random.next();
            if kind == 1 {
                raised(&mut joint.limits.velocity);
                raised(&mut joint.limits.acceleration);
                raised(&mut joint.limits.jerk);
            }
        }
        if kind == 2 {
            wide.least.iter_mut().for_each(|t| *t *= random.between(0.3, 1.0));
        }
        let [before, after] = [&narrow, &wide].map(|s| s.certificate().expect("sound").bound);
        assert!(after <= before * (1.0 + 1e-9), "{kind}: {before} to {after}, {narrow:?}");
    }
}

#[test]
fn a_sine_in_its_own_channel_is_bound_by_its_swings() {
    // The channel of half width r about an amplitude R lets a motion turn back at R - r.
    let (amplitude, room, periods) = (30.0, 10.0, 4.0_f64);
    let n = 800;
    let gates = (0..=n)
        .map(|i| {
            let middle = amplitude * (periods * std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin();
            [middle - room, middle + room]
        })
        .collect();
    let least = vec![4.0 / f64::from(n); n as usize];
    let limits = SwingLimits { velocity: 60.0, acceleration: 150.0, jerk: 1500.0 };
    let certificate = one(least, gates, limits).certificate().expect("sound");
    assert!((certificate.feed - 4.0).abs() < 1e-9);
    // Seven whole swings of 2 (R - r), and what leads to the first and from the last turn.
    let seven = 7.0 * limits.swing_time(2.0 * (amplitude - room));
    assert!(certificate.bound >= seven, "{} {seven}", certificate.bound);
    // The best travel leaves and comes where the slope of the limits is V: 30 w cos(p) = 60, seven times.
    let w = periods * std::f64::consts::TAU / 4.0;
    let p = (limits.velocity / (amplitude * w)).acos();
    let saved = (2.0 * amplitude * p.sin() - 2.0 * room) / limits.velocity - 2.0 * p / w;
    assert!((certificate.velocity[0] - (4.0 + 7.0 * saved)).abs() < 1e-3, "{}", certificate.velocity[0]);
    // Counted as if the joint stood still at the begin and at the end, it would be 8.54.
    assert!(certificate.bound < 8.54, "{}", certificate.bound);
}

/// The most that feed, swings and feed prove in a window, over all rows of gates: by a search over pairs of
/// gates.
fn best_swings(schedules: &Schedules, joint: usize) -> f64 {
    let JointGates { gates, limits, .. } = &schedules.joints[joint];
    let n = gates.len();
    let mut times = vec![0.0];
    for t in &schedules.least {
        times.push(times[times.len() - 1] + t);
    }
    // Ended at gate i after a way up (down) to it, the gate a turn.
    let mut turned = vec![[f64::NEG_INFINITY; 2]; n];
    let mut most = f64::NEG_INFINITY;
    for i in 0..n {
        for k in 0..i {
            for up in [false, true] {
                let way = if up { gates[i][0] - gates[k][1] } else { gates[k][0] - gates[i][1] };
                if way > 0.0 {
                    let first = times[k] + limits.half_swing_time(way);
                    let later = turned[k][usize::from(!up)] + limits.swing_time(way);
                    let end = turned[k][usize::from(!up)] + limits.half_swing_time(way) + times[n - 1] - times[i];
                    turned[i][usize::from(up)] = turned[i][usize::from(up)].max(first).max(later);
                    most = most.max(end);
                }
            }
        }
    }
    most
}

#[test]
fn the_turns_of_the_string_prove_most() {
    let mut random = Random(67);
    for _ in 0..2000 {
        let schedules = random_schedules(&mut random);
        let window = [0, schedules.least.len()];
        let mut times = vec![0.0];
        for t in &schedules.least {
            times.push(times[times.len() - 1] + t);
        }
        let search = ScheduleSearch { schedules: &schedules, times, seams: &[] };
        for joint in 0..schedules.joints.len() {
            let string = search.string(joint, window);
            let own = search.swings(joint, window, &string).map_or(f64::NEG_INFINITY, |p| search.total(&p));
            let best = best_swings(&schedules, joint);
            assert!((own - best).abs() < 1e-9 * best.abs() || own == best, "{own} {best} {schedules:?}");
        }
    }
}

#[test]
fn what_is_no_channel_is_named() {
    let fine = || one(vec![1.0; 2], vec![[0.0, 1.0]; 3], only_velocity(1.0));
    assert!(fine().certificate().is_ok());
    let wrong = |change: &dyn Fn(&mut Schedules)| {
        let mut schedules = fine();
        change(&mut schedules);
        schedules.certificate().expect_err("wrong")
    };
    assert_eq!(wrong(&|s| s.least[1] = 0.0), SchedulesError::Time(1));
    assert_eq!(wrong(&|s| s.joints[0].gates[2] = [1.0, 0.0]), SchedulesError::Gate(0, 2));
    assert_eq!(wrong(&|s| s.joints[0].gates[1][0] = f64::NAN), SchedulesError::Gate(0, 1));
    assert_eq!(wrong(&|s| s.joints[0].gates.truncate(2)), SchedulesError::Gate(0, 2));
    assert_eq!(wrong(&|s| s.joints[0].limits.jerk = 0.0), SchedulesError::Limit(0));
    assert_eq!(wrong(&|s| s.joints[0].limits.velocity = f64::INFINITY), SchedulesError::Limit(0));
}

#[test]
fn an_empty_stretch_and_free_joints_are_bound_by_the_feed() {
    let nothing = Schedules::default().certificate().expect("sound");
    assert_eq!(nothing.bound, 0.0);
    let open = one(vec![0.5; 4], vec![[f64::NEG_INFINITY, f64::INFINITY]; 5], only_velocity(1.0));
    assert_eq!(open.certificate().expect("sound").bound, 2.0);
}

/// The time of feed and velocity along the taut string with free ends, a primal, and the best row of windows,
/// its dual, are the same: two algorithms that share nothing. A thousand channels; `PROVEOUT_CHANNELS` for
/// more.
#[test]
fn the_taut_string_takes_just_what_the_best_windows_prove() {
    let count = std::env::var("PROVEOUT_CHANNELS").ok().and_then(|n| n.parse().ok()).unwrap_or(1000);
    let mut random = Random(83);
    let mut forced = 0;
    for _ in 0..count {
        let schedules = random_schedules(&mut random);
        let JointGates { gates, limits, .. } = &schedules.joints[0];
        let mut time = 0.0;
        let mut row = vec![TautGate { s: 0.0, low: gates[0][0].max(-1e3), high: gates[0][1].min(1e3) }];
        for ([low, high], t) in gates[1..].iter().zip(&schedules.least) {
            time += t;
            row.push(TautGate { s: time, low: low.max(-1e3), high: high.min(1e3) });
        }
        let string = free_taut_string(&row).expect("gates that are open");
        let at = |s: f64| {
            let k = string.partition_point(|p| p[0] < s).clamp(1, string.len() - 1);
            let (a, b) = (string[k - 1], string[k]);
            if b[0] > a[0] { a[1] + (b[1] - a[1]) * (s - a[0]) / (b[0] - a[0]) } else { b[1] }
        };
        let primal: f64 = row
            .windows(2)
            .zip(&schedules.least)
            .map(|(p, least)| least.max((at(p[1].s) - at(p[0].s)).abs() / limits.velocity))
            .sum();
        let dual = schedules.certificate().expect("sound").velocity[0];
        assert!((primal - dual).abs() < 1e-7 * primal, "{primal} {dual} {schedules:?}");
        forced += usize::from(dual > 1.001 * schedules.least.iter().sum::<f64>());
    }
    assert!(4 * forced > count, "{forced} of {count}");
}

/// With losses of windows at their ends: times add up to the reported bound, the bound falls with
/// the losses, and wider gates or higher limits never raise it.
#[test]
fn windows_that_lose_at_their_ends_keep_the_laws() {
    let mut random = Random(97);
    let (mut lowered, mut fewer) = (0, 0);
    for _ in 0..1000 {
        let narrow = random_schedules(&mut random);
        let share = 10_f64.powf(random.between(-3.0, -0.3));
        let seams: Vec<f64> = (0..=narrow.least.len())
            .map(|g| {
                let beside = narrow.least[g.min(narrow.least.len() - 1)].min(narrow.least[g.saturating_sub(1)]);
                share * beside * random.next()
            })
            .collect();
        let own = narrow.certificate_within(&seams).expect("sound");
        let without = narrow.certificate().expect("sound");
        assert!(own.bound <= without.bound * (1.0 + 1e-12));
        let own_sum: f64 = own
            .windows
            .iter()
            .map(|(proof, _)| match proof {
                Proof::Feed { gates: [a, b] } => {
                    (narrow.least[*a..*b].iter().sum::<f64>() - seams[*a] - seams[*b]).max(0.0)
                }
                _ => narrow.time(proof),
            })
            .sum();
        assert!((own.bound - own_sum).abs() < 1e-9 * own_sum.max(1.0));
        lowered += usize::from(own.bound < without.bound * (1.0 - 1e-6));
        fewer += usize::from(own.windows.len() < without.windows.len());
        let mut wide = narrow.clone();
        for joint in &mut wide.joints {
            for gate in &mut joint.gates {
                *gate = [gate[0] - 0.3 * random.next(), gate[1] + 0.3 * random.next()];
            }
            joint.limits = joint.limits.passed_by(random.next());
        }
        let after = wide.certificate_within(&seams).expect("sound").bound;
        assert!(after <= own.bound * (1.0 + 1e-9), "{} to {after}", own.bound);
        let mut wrong = seams.clone();
        wrong[1] = -1e-9;
        assert_eq!(narrow.certificate_within(&wrong), Err(SchedulesError::Seam(1)));
        assert_eq!(narrow.certificate_within(&seams[1..]), Err(SchedulesError::Seam(narrow.least.len())));
    }
    // Most rows have some feed, and some of them fewer windows for their losses.
    assert!(lowered > 500 && fewer > 10, "{lowered} {fewer}");
}
