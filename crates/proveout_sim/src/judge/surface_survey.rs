//! The cut part compared with its design, band by band: points to the observers, sums, areas and
//! what is not known to the judge.
//!
//! Memory: the points of a band, the areas (bounded), and four bytes a point, from which the mesh gets its
//! colors later.

use proveout_geom::{Aabb, Point, Vector};
use proveout_stock::{Patch, TriDexel};
use proveout_surface::{
    Area, AreaPart, Areas, Band, DeviationSettings, FinCrossing, FoundGap, GapEnd, GapSettings, Judged, Refine, Seed,
    Side, Solid, Starts, Survey, Tally, ThinFins, Unseen, Watcher, refined, unseen,
};
use rayon::prelude::*;

use crate::{
    checks::thread_strokes::{Strokes, is_thread},
    cut::kept_motion::Swept,
    judge::{
        design::{Design, MESH, design},
        excess_between_rays::{Between, Places, Told},
        scallop::RidgeMap,
    },
    observe::surface_map::{MapPoint, PatchShape, PointBand, SurfaceShape},
    prepare::{error::SimError, prepared::Prepared, raw_shape::RawShape},
    units::UM_PER_MM,
    verdict::verdict_file::Deviation,
};

/// A face with a closed form counts as measured when at least this part of its area has points. The
/// area that points represent is known to about one percent on curved faces.
const FULL_COVER: f64 = 0.97;

/// What the measurement says.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub(crate) deviation: Deviation,
    /// Connected areas beyond the tolerances, the worst first.
    pub(crate) gouges: Vec<Area>,
    pub(crate) excesses: Vec<Area>,
    /// Sheets above the design that are no thicker than the error of their faces, and how thick that is, mm.
    pub(crate) films: Vec<Area>,
    pub(crate) film_thickness: f64,
    /// What taps have cut outside of the core holes.
    pub(crate) threads: Vec<Area>,
    /// What was measured, in words.
    pub(crate) extent: String,
    /// Parts of the design that were not measured.
    pub(crate) left_out: Vec<String>,
    /// Parts of the design that lie between the rays, so that it is unknown whether they were cut
    /// away.
    pub(crate) unseen: Option<String>,
    /// Depth and height from which on a fault counts, mm.
    pub(crate) limits: [f64; 2],
    /// Gouges and excesses between the rays: what was decided, and what was not.
    pub(crate) between: [Told; 2],
}

/// What is left of a survey.
pub(crate) struct Surveyed {
    pub(crate) shape: SurfaceShape,
    pub(crate) measured: Option<Measured>,
    /// Deviation of each point of the stock, then of each patch, in the order of their points; not a number
    /// where it has none.
    pub(crate) deviations: Vec<Vec<f32>>,
}

/// What is known of the surface in addition to the stock.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    /// The motion that cut it.
    pub(crate) swept: Option<&'a Swept>,
    /// Heights of the ridges between its passes.
    pub(crate) ridges: Option<&'a RidgeMap>,
    /// Motions of taps.
    pub(crate) strokes: &'a Strokes,
    /// Whether parts of the stock have come off.
    pub(crate) fallen: bool,
    /// Whether the program went to its end.
    pub(crate) finished: bool,
}

/// Receives the points.
pub(crate) type ShowPoints<'a> = dyn FnMut(&PointBand<'_>) -> Result<(), SimError> + 'a;

/// Measures the surface of the cut part where the scene has a design: in the windows of the patches on their
/// points, elsewhere on those of the stock.
pub(crate) fn survey(
    prepared: &Prepared,
    stock: &TriDexel,
    patches: &[Patch],
    Known { swept, ridges, strokes, fallen, finished }: Known<'_>,
    show: &mut ShowPoints<'_>,
) -> Result<Surveyed, SimError> {
    let design = design(prepared);
    let bound = |s: &TriDexel| s.sweep_bound_mm() + s.regrid_bound().map_or(0.0, |r| r.surface_mm);
    let finest = patches.iter().map(|p| bound(p.stock())).fold(bound(stock), f64::max);
    let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
    let tolerances = &prepared.scene.file.tolerances;
    let floor = design.as_ref().map_or(0.0, |d| d.floor) + finest;
    let solid_floor = design.as_ref().map_or(0.0, |d| d.solid_floor) + finest;
    let region = prepared.scene.file.part.as_ref().and_then(|p| p.judged_box).map(|b| b.aabb());
    let part = |s: &TriDexel, window| AreaPart { corner: s.bounds().min, cells: s.cells_mm(), window };
    let parts: Vec<AreaPart> =
        std::iter::once(part(stock, None)).chain(patches.iter().map(|p| part(p.stock(), Some(*p.window())))).collect();
    let mut sums = Sums {
        limits: [tolerances.gouge_mm + floor, tolerances.excess_mm + floor],
        missing: Areas::new(parts.clone(), tolerances.gouge_mm),
        left: Areas::new(parts.clone(), tolerances.excess_mm),
        films: Areas::new(parts.clone(), tolerances.excess_mm),
        threads: Areas::new(parts, tolerances.gouge_mm),
        film_thickness: 0.0,
        deepest: None,
        places: [Places::new(stock.cell_mm()), Places::new(stock.cell_mm())],
    };
    let mut result: Option<proveout_surface::Deviation> = None;
    let mut shape = SurfaceShape { cells_mm: stock.cells_mm(), judged: design.is_some(), ..SurfaceShape::default() };
    let mut deviations = Vec::new();
    let stocks = std::iter::once((None, stock)).chain(patches.iter().enumerate().map(|(k, p)| (Some(k), p.stock())));
    for (patch, rays) in stocks {
        let settings = DeviationSettings {
            range: design.as_ref().map_or(f64::INFINITY, |d| d.reach),
            region,
            only_cut: false,
            tolerance_floor: floor,
            cells: rays.cells_mm(),
        };
        let gaps = GapSettings {
            missing: tolerances.gouge_mm + solid_floor,
            left: tolerances.excess_mm + floor,
            floor: solid_floor,
        };
        // Both faces of a sheet are known within the error of the sweeps and of the pieces of motion.
        let thickest = (2.0 * (bound(rays) + prepared.piece_tolerance())).min(tolerances.excess_mm);
        sums.film_thickness = sums.film_thickness.max(thickest);
        let solid = design.as_ref().and_then(Design::solid);
        let window = patch.map(|k| windows[k]);
        // The first patch has a point on the face between two.
        let finer = &windows[..patch.unwrap_or(windows.len())];
        let part = Survey {
            stock: rays,
            design: design.as_ref().map(|d| d.surface.as_ref()),
            solid: solid.map(|(mesh, tree)| Solid { mesh, tree, gaps }),
            settings,
            fins: ThinFins { thickest, above: sums.limits[1] },
            window,
            finer,
        };
        let shown = |p: &Point| window.is_none_or(|w| w.contains(p)) && !finer.iter().any(|w| w.contains(p));
        let mut of_part = OfPart {
            number: patch.map_or(0, |k| k + 1),
            strokes,
            cells: rays.cells_mm(),
            tally: Tally::new(floor),
            points: 0,
            area: 0.0,
            deviations: Vec::new(),
        };
        part.run(|band| {
            let mut points = of_part.take(&band, &shown, &mut sums);
            if let Some(ridges) = ridges {
                let cut: Vec<Point> = points.iter().map(|p| Point::from(p.position)).collect();
                for (point, heights) in points.iter_mut().zip(ridges.at(&cut)) {
                    [point.scallop, point.scallop_geometric] = heights.map(|h| h.filter(|_| point.made_by.is_some()));
                }
            }
            show(&PointBand { patch, points: &points })
        })?;
        let own = of_part.tally.finish();
        match patch {
            None => {
                (shape.points, shape.triangles, shape.area_mm2) =
                    (of_part.points, rays.surface_triangles(), of_part.area)
            }
            Some(k) => shape.patches.push(PatchShape {
                name: patches[k].name().into(),
                window: windows[k],
                cells_mm: rays.cells_mm(),
                points: of_part.points,
                triangles: rays.surface_triangles(),
                area_mm2: of_part.area,
            }),
        }
        deviations.push(of_part.deviations);
        result = Some(match result {
            None => own,
            Some(all) => all.joined(&own),
        });
    }
    let measured = design.zip(result).map(|(design, result)| {
        let raw = RawShape::of(prepared);
        let places = std::mem::take(&mut sums.places);
        let between = Between {
            design: &design,
            stock,
            swept,
            strokes,
            region,
            limits: [tolerances.gouge_mm + solid_floor, sums.limits[1]],
            known: &places,
            finished,
        };
        let of_patches = patches.iter().map(|p| Watcher { stock: p.stock(), window: Some(*p.window()) });
        let watchers: Vec<Watcher<'_>> = std::iter::once(Watcher { stock, window: None }).chain(of_patches).collect();
        let between = [
            between.gouges(raw.as_ref(), &mut sums.missing),
            between.excesses(raw.as_ref(), &watchers, fallen, sums.film_thickness, [&mut sums.missing, &mut sums.left]),
        ];
        let seen = sees(&design, stock, &watchers, region.as_ref());
        let refine = swept.map(|s| Refine {
            path: &s.path,
            design: design.surface.as_ref(),
            bounds: stock.bounds(),
            region,
            cell: stock.cell_mm(),
        });
        let measured = sums.measured(&design, &result, floor, &shape, seen, refine.as_ref());
        let limits = [tolerances.gouge_mm + floor.max(solid_floor), measured.limits[1]];
        Measured { between, limits, ..measured }
    });
    Ok(Surveyed { shape, measured, deviations })
}

/// What is gathered over all parts.
struct Sums {
    /// Depth and height from which on points count, mm.
    limits: [f64; 2],
    missing: Areas,
    left: Areas,
    /// What of the material left is a film.
    films: Areas,
    film_thickness: f64,
    /// What of the material missing is thread.
    threads: Areas,
    /// Deepest gap: depth and place.
    deepest: Option<(f64, Point)>,
    /// Where material is missing, and where it is left.
    places: [Places; 2],
}

/// What is gathered of the stock or of a patch.
struct OfPart<'a> {
    number: usize,
    strokes: &'a Strokes,
    cells: [f64; 3],
    tally: Tally,
    points: u64,
    area: f64,
    deviations: Vec<f32>,
}

impl OfPart<'_> {
    /// Books a band; gives the points that are shown.
    fn take(&mut self, band: &Band, shown: &dyn Fn(&Point) -> bool, sums: &mut Sums) -> Vec<MapPoint> {
        let mut points = Vec::with_capacity(band.points.len());
        let none = Judged::Masked;
        for (k, ((sample, judged), film)) in band.points.iter().zip(&band.judged).zip(&band.fins).enumerate() {
            let margin = sums.limits[0];
            let thread =
                -judged.deviation() > margin && is_thread(self.strokes, sample.made_by, [&sample.point; 2], margin);
            // What lies on a film or in a thread counts for nothing else.
            let apart = film.is_some() || thread;
            let deviation = if apart { f64::NAN } else { judged.deviation() };
            self.deviations.push(deviation as f32);
            if !shown(&sample.point) {
                // Points of the stock under a patch are reported as left out; those of a patch
                // beyond its window count nowhere.
                if self.number == 0 {
                    self.tally.add(sample, &none);
                }
                continue;
            }
            self.tally.add(sample, if apart { &none } else { judged });
            let normal = sample.normal.unwrap_or_else(Vector::zeros);
            self.area += self.ray_area(usize::from(sample.axis)) * normal[usize::from(sample.axis)].abs();
            points.push(MapPoint {
                position: sample.point.coords.into(),
                normal: normal.into(),
                deviation: deviation.is_finite().then_some(deviation),
                scallop: None,
                scallop_geometric: None,
                made_by: sample.made_by,
            });
            if let Judged::Counts { deviation, weight } = *judged {
                let seed = |depth: f64| Seed {
                    depth,
                    point: sample.point,
                    made_by: sample.made_by,
                    cut_area: weight,
                    ..Seed::default()
                };
                if thread {
                    sums.threads.add(self.number, &seed(-deviation));
                } else if -deviation > sums.limits[0] {
                    sums.places[0].add(&sample.point);
                    sums.missing.add(self.number, &seed(-deviation));
                } else if deviation > sums.limits[1] {
                    match film {
                        None => {
                            sums.places[1].add(&sample.point);
                            sums.left.add(self.number, &seed(deviation));
                        }
                        Some(film) => {
                            sums.films.add(self.number, &self.film_seed(*film, band, k, &seed(deviation)));
                        }
                    }
                }
            }
        }
        self.points += points.len() as u64;
        for found in band.gaps.iter().filter(|f| f.length > 0.0) {
            self.gap(band, found, shown, sums);
        }
        points
    }

    /// A point of a film: half of its thickness, where its ray goes through. One in the sheet would count it
    /// as wide as a cell.
    fn film_seed(&self, film: FinCrossing, band: &Band, point: usize, seed: &Seed) -> Seed {
        let axis = usize::from(band.points[point].axis);
        // Both ends of an interval are neighbors.
        let other = band.points.get(point ^ 1).map_or(seed.point, |p| p.point);
        let half = 0.5 * (seed.point[axis] - other[axis]).abs();
        let gap = (film == FinCrossing::Across).then_some((axis, half, self.ray_area(axis)));
        Seed { gap, cut_area: 0.0, ..*seed }
    }

    fn ray_area(&self, axis: usize) -> f64 {
        self.cells[(axis + 1) % 3] * self.cells[(axis + 2) % 3]
    }

    /// Puts a gap into the areas: its worst point, with its volume, and its ends that count.
    fn gap(&self, band: &Band, found: &FoundGap, shown: &dyn Fn(&Point) -> bool, sums: &mut Sums) {
        let FoundGap { gap, ray, length, .. } = found;
        let axis = ray.axis;
        let worst = ray.point(gap.worst);
        let made_by = maker(band, found);
        if found.fin(band).is_some() {
            return; // its points have told it
        }
        let ends = gap.at.map(|at| ray.point(at));
        let thread =
            gap.side == Side::Missing && is_thread(self.strokes, made_by, [&ends[0], &ends[1]], sums.limits[0]);
        if !thread && !gap.foil {
            sums.places[usize::from(gap.side == Side::Left)].add(&worst);
        }
        let areas = match gap.side {
            Side::Missing if thread => &mut sums.threads,
            Side::Missing => &mut sums.missing,
            Side::Left => &mut sums.left,
        };
        if !thread && gap.side == Side::Missing && !gap.foil && sums.deepest.is_none_or(|d| gap.depth > d.0) {
            sums.deepest = Some((gap.depth, worst));
        }
        let seed = Seed {
            depth: gap.depth,
            point: worst,
            made_by,
            gap: Some((axis, *length, self.ray_area(axis))),
            wall: gap.wall,
            foil: gap.foil,
            ..Seed::default()
        };
        areas.add(self.number, &seed);
        for (at, end) in gap.at.into_iter().zip(&gap.ends) {
            let point = ray.point(at);
            if !shown(&point) {
                continue;
            }
            let design_area = match end {
                GapEnd::Design(n) => n[axis].abs() * self.ray_area(axis),
                GapEnd::Cut(_) => 0.0,
            };
            let end = Seed { point, design_area, made_by, foil: gap.foil, depth: 0.0, ..Seed::default() };
            areas.add(self.number, &end);
            areas.join(self.number, &worst, &point);
        }
    }
}

/// The motion that answers for a gap: that of its end on the cut part (of the two the nearer one to its worst
/// point). Where no material is left in the design on the ray, that of the material next to the gap, else the
/// last one that took all material from the ray.
fn maker(band: &Band, found: &FoundGap) -> Option<u32> {
    let FoundGap { gap, first_point, beside, last_to_empty, .. } = found;
    let of_point = |end: usize| band.points.get(first_point + end).and_then(|p| p.made_by);
    let nearer = usize::from((gap.worst - gap.at[0]).abs() > (gap.worst - gap.at[1]).abs());
    let cut = |k: usize| match gap.ends[k] {
        GapEnd::Cut(end) => Some(end),
        GapEnd::Design(_) => None,
    };
    if gap.side == Side::Left || cut(0).or(cut(1)).is_some() {
        return cut(nearer).or(cut(1 - nearer)).and_then(of_point);
    }
    beside.iter().flatten().find_map(|end| of_point(*end)).or(*last_to_empty)
}

/// What of the design no ray sees, in words.
fn sees(design: &Design<'_>, stock: &TriDexel, watchers: &[Watcher<'_>], region: Option<&Aabb>) -> Option<String> {
    let (mesh, tree) = design.solid()?;
    let Unseen { area, point, thickness } = unseen(mesh, tree, watchers, region)?;
    let [x, y, z]: [f64; 3] = point.coords.into();
    let reach = stock.bounds();
    Some(if reach.contains(&point) {
        // A cell across which the thinnest place fits twice meets it in any position.
        let cell = 0.7 * thickness.min(stock.cell_mm());
        format!(
            "{area:.3} mm2 of the design lie between the rays, for example at X{x:.3} Y{y:.3} Z{z:.3} where it is {thickness:.3} mm thick: whether they are cut away is not known; use a resolution_mm, or a [[stock.patch]] there, of {cell:.3} mm"
        )
    } else {
        format!(
            "{area:.3} mm2 of the design have no ray near, for example at X{x:.3} Y{y:.3} Z{z:.3}, outside of the raw stock: make \
             the stock larger"
        )
    })
}

/// Areas whose worst place is searched between the rays.
const SEARCHED: usize = 20;

/// The areas, the worst of them with their worst place on the surface that the motion has swept.
fn worst_between_rays(areas: Vec<(Area, Starts)>, side: Side, refine: Option<&Refine<'_>>) -> Vec<Area> {
    let Some(refine) = refine else { return areas.into_iter().map(|(area, _)| area).collect() };
    let searched = |(k, (area, starts)): (usize, (Area, Starts))| {
        let by_points = k < SEARCHED && area.wall.is_none() && !area.foil;
        let worst = by_points.then(|| refined(refine, side, &starts)).flatten().filter(|w| w.depth > area.depth);
        worst.map_or(area, |w| Area { depth: w.depth, point: w.point, made_by: Some(w.made_by), ..area })
    };
    let mut areas: Vec<Area> = areas.into_par_iter().enumerate().map(searched).collect();
    areas.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    areas
}

impl Sums {
    fn measured(
        self,
        design: &Design<'_>,
        result: &proveout_surface::Deviation,
        floor: f64,
        shape: &SurfaceShape,
        unseen: Option<String>,
        refine: Option<&Refine<'_>>,
    ) -> Measured {
        let mut left_out = Vec::new();
        let mut extent = format!("{}, against the {}", design.name, design.against);
        let mesh_error = design.solid().map(|_| design.solid_floor);
        if let Some(error) = mesh_error.filter(|_| design.against != MESH) {
            extent = format!(
                "{extent} (missing walls on rays through its mesh, up to {:.2} um off as measured)",
                UM_PER_MM * error
            );
        }
        if let Some(area) = design.area {
            let cover = result.area / area;
            extent = format!("{extent}, {:.1} % of its {area:.0} mm2", 100.0 * cover);
            if cover < FULL_COVER {
                left_out.push(format!(
                    "{:.1} % of the {} have no surface within {} mm of the design",
                    100.0 * (1.0 - cover),
                    design.name,
                    design.reach
                ));
            }
        }
        if !shape.patches.is_empty() {
            let names: Vec<&str> = shape.patches.iter().map(|p| p.name.as_str()).collect();
            extent = format!("{extent}, finer in {}", names.join(", "));
        }
        if result.samples == 0 {
            left_out.push("no point of the cut part lies near the design".into());
        }
        let known = |value: f64| (result.samples > 0).then_some(value);
        let gouges = worst_between_rays(self.missing.finish_with_starts(), Side::Missing, refine);
        let excesses = worst_between_rays(self.left.finish_with_starts(), Side::Left, refine);
        let films = self.films.finish();
        let threads = self.threads.finish();
        // An empty sum is -0.0.
        let volume = |areas: &[Area]| areas.iter().map(|a| a.volume).fold(0.0, |sum, v| sum + v);
        let count = |areas: &[Area]| Some(areas.len() as u64);
        // Where material is missing deeper than any point of the cut part shows, a wall is gone or
        // cut from one side.
        let deeper = self.deepest.filter(|d| d.0 > result.gouge_max);
        let gouge_max = deeper.map_or(result.gouge_max, |d| d.0);
        // Between the rays, where the worst areas were searched.
        let found =
            |areas: &[Area]| areas.iter().filter(|a| a.wall.is_none() && !a.foil).map(|a| a.depth).fold(0.0, f64::max);
        let (gouge_max, excess_max) = (gouge_max.max(found(&gouges)), result.excess_max.max(found(&excesses)));
        let worst = match (deeper, &result.worst) {
            (Some((depth, point)), w) if w.is_none_or(|w| depth > w.deviation.abs()) => Some(point),
            (_, w) => w.map(|w| w.point),
        };
        let largest = result.worst.map_or(0.0, |w| w.deviation.abs()).max(deeper.map_or(0.0, |d| d.0));
        let between = gouges.iter().chain(&excesses).filter(|a| a.depth > largest);
        let worst = between.reduce(|a, b| if b.depth > a.depth { b } else { a }).map(|a| a.point).or(worst);
        let deviation = Deviation {
            against: Some(design.against.into()),
            design_error_mm: Some(design.floor),
            mesh_error_mm: mesh_error,
            mesh_asked_mm: design.mesh_asked,
            tolerance_floor_mm: Some(floor),
            gouge_max_mm: if deeper.is_some() { Some(gouge_max) } else { known(gouge_max) },
            excess_max_mm: known(excess_max),
            mean_mm: known(result.mean),
            rms_mm: known(result.rms),
            gouge_area_mm2: known(result.gouge_area),
            samples: Some(result.samples),
            worst_point: worst.map(|p| p.coords.into()),
            gouges: count(&gouges),
            gouge_volume_mm3: Some(volume(&gouges)),
            excesses: count(&excesses),
            excess_volume_mm3: Some(volume(&excesses)),
            threads: count(&threads),
            thread_volume_mm3: Some(volume(&threads)),
            films: count(&films),
            film_volume_mm3: Some(volume(&films)),
            film_max_mm: films.iter().map(|a| a.depth).reduce(f64::max),
            film_thickness_mm: Some(self.film_thickness),
        };
        let (film_thickness, limits, between) = (self.film_thickness, self.limits, Default::default());
        Measured {
            deviation,
            gouges,
            excesses,
            films,
            film_thickness,
            threads,
            extent,
            left_out,
            unseen,
            limits,
            between,
        }
    }
}
