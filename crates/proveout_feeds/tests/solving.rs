//! The largest feed under limits.

use proveout_feeds::{Binds, BlockDemand, Compliance, FeedMode, ForceModel, ToolLimits, feed_of_block};

use crate::{cut, flat, material};

const RPM: f64 = 3000.0;

#[test]
fn at_the_largest_scale_the_limit_is_met_and_no_other_is_passed() {
    let tool = flat("flutes = 2\nedges = { helix_deg = 30, radial_run_out_mm = [0.005, 0.0] }\n");
    let m = material("chip-thickness", 1600.0, 0.22, "radial_ratio = 0.35\nedge_force_n_mm = 12\n");
    let model = ForceModel::new(&tool, m, 0.85, Compliance::of_tool(&tool, 600e3, 0.8)).unwrap();
    let none = ToolLimits::default();
    let cases = [
        (ToolLimits { max_chip_mm: Some(0.08), ..none.clone() }, Binds::Chip),
        (ToolLimits { max_force_n: Some(400.0), ..none.clone() }, Binds::Force),
        (ToolLimits { max_torque_nm: Some(1.5), ..none.clone() }, Binds::Torque),
        (ToolLimits { max_power_kw: Some(0.3), ..none.clone() }, Binds::Power),
        (ToolLimits { max_deflection_um: Some(25.0), ..none.clone() }, Binds::Deflection),
    ];
    // A counted sequence of cuts (Weyl): depth, range and feed all over.
    let turn = |k: u32, a: f64| (f64::from(k) * a).fract();
    for k in 1..200 {
        let first = 170.0 * turn(k, 0.618_034);
        let range = [first, first + (180.0 - first) * turn(k, 0.414_214)];
        let cut =
            model.loads(&[cut(0.2 + 3.0 * turn(k, 0.732_051), range, 1.0 + 30.0 * turn(k, 0.236_068))], RPM).unwrap();
        for (limits, binds) in &cases {
            match cut.largest_scale(limits) {
                Ok(Some((scale, which))) => {
                    assert_eq!(which, *binds);
                    let (at, _) = cut.over(scale, limits).unwrap();
                    assert!((at - 1.0).abs() < 1e-6 && at <= 1.0, "{at}");
                    assert!(cut.over(1.02 * scale, limits).unwrap().0 > 1.0);
                }
                Ok(None) => assert!(cut.over(1e6, limits).is_none_or(|(at, _)| at <= 1.0)),
                Err(which) => {
                    assert_eq!(which, *binds);
                    assert!(cut.over(1e-6, limits).unwrap().0 > 1.0);
                }
            }
        }
        let all = cases.iter().fold(none.clone(), |a, (b, _)| ToolLimits {
            max_chip_mm: a.max_chip_mm.or(b.max_chip_mm),
            max_force_n: a.max_force_n.or(b.max_force_n),
            max_torque_nm: a.max_torque_nm.or(b.max_torque_nm),
            max_power_kw: a.max_power_kw.or(b.max_power_kw),
            max_deflection_um: a.max_deflection_um.or(b.max_deflection_um),
            ..a
        });
        if let Ok(Some((scale, _))) = cut.largest_scale(&all) {
            let least = cases.iter().filter_map(|(l, _)| cut.largest_scale(l).ok().flatten()).map(|(s, _)| s);
            assert!((least.fold(f64::INFINITY, f64::min) / scale - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn an_edge_force_above_the_limit_leaves_no_feed() {
    let tool = flat("flutes = 2\n");
    let m = material("chip-thickness", 1600.0, 0.2, "radial_ratio = 0.3\nedge_force_n_mm = 50\n");
    let model = ForceModel::new(&tool, m, 1.0, None).unwrap();
    let cut = model.loads(&[cut(4.0, [0.0, 180.0], 10.0)], RPM).unwrap();
    let limits = ToolLimits { max_force_n: Some(100.0), ..ToolLimits::default() };
    assert_eq!(cut.largest_scale(&limits), Err(Binds::Force));
    assert_eq!(cut.largest_scale(&ToolLimits::default()), Ok(None));
}

#[test]
fn the_feed_of_a_block_is_that_of_its_limits() {
    let limits = ToolLimits { max_feed_mm_min: Some(3000.0), ..ToolLimits::default() };
    let block =
        BlockDemand { programmed: 20.0, engaged: true, limit: Some((30.0, Binds::Force)), chip_per_feed: 0.004 };
    let feed = |demand: &BlockDemand, limits: &ToolLimits, mode: FeedMode| feed_of_block(demand, limits, mode, 0.08);
    assert_eq!(feed(&block, &limits, FeedMode::Force), Ok((30.0, Binds::Force)));
    assert_eq!(feed(&block, &limits, FeedMode::Analyse), Ok((20.0, Binds::Programmed)));
    assert_eq!(feed(&block, &limits, FeedMode::Air), Ok((20.0, Binds::Programmed)));
    let far = BlockDemand { limit: Some((300.0, Binds::Force)), ..block };
    assert_eq!(feed(&far, &limits, FeedMode::Force), Ok((50.0, Binds::MaxFeed)));
    // Without a highest feed nothing is raised; what passes a limit is lowered all the same.
    assert_eq!(feed(&far, &ToolLimits::default(), FeedMode::Force), Ok((20.0, Binds::Programmed)));
    let slow = BlockDemand { limit: Some((12.0, Binds::Chip)), ..block };
    assert_eq!(feed(&slow, &ToolLimits::default(), FeedMode::Chip), Ok((12.0, Binds::Chip)));
    // The dead band keeps what is within the limits, never what is above one.
    let near = BlockDemand { limit: Some((21.0, Binds::Force)), ..block };
    assert_eq!(feed(&near, &limits, FeedMode::Force), Ok((20.0, Binds::DeadBand)));
    let over = BlockDemand { limit: Some((19.5, Binds::Force)), ..block };
    assert_eq!(feed(&over, &limits, FeedMode::Force), Ok((19.5, Binds::Force)));
    let kept = ToolLimits { keep_surface: true, ..limits.clone() };
    assert_eq!(feed(&block, &kept, FeedMode::Force), Ok((20.0, Binds::Surface)));
    let air = BlockDemand { engaged: false, limit: None, ..block };
    assert_eq!(feed(&air, &kept, FeedMode::Air), Ok((50.0, Binds::MaxFeed)));
    let thick = ToolLimits { min_chip_mm: Some(0.06), ..limits };
    assert_eq!(feed(&slow, &thick, FeedMode::Force), Err(Binds::Chip));
}
