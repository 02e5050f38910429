//! A stretch of compensated contour with the path of the tool center along it, and where the tool enters the
//! contour.
//!
//! Every piece of the path is checked against every block of the contour, whatever lies between
//! them. Their least distance, in closed form ([`super::distance`]), must be the tool radius but
//! for [`GOUGE_MM`]. The blocks form a tree of boxes in the order of the program, two by two.
//! Successive blocks lie next to each other, so that the boxes are as small as sorting would make
//! them, and a piece meets few of them.

use super::contour::{Element, ElementShape, Point, norm, sub};
use super::distance::{self, Bounds};
use crate::Location;

/// Least depth of a cut into the contour that is one, mm: above the crumbs that the tool passes. Rounding of
/// intersections and the points that are taken as one stay below a thousandth of it.
pub(super) const GOUGE_MM: f64 = 1e-3;
/// Blocks that are kept for the check; the path is checked against so many before and after it.
pub(super) const WINDOW: usize = 100_000;

/// One block of the contour.
#[derive(Clone, Debug)]
pub(super) struct ContourBlock {
    pub(super) element: Element,
    /// Offset of the tool center to the left, mm; the smaller one where it changes along the block.
    pub(super) offset: f64,
    pub(super) location: Location,
    /// False at rapid rate: nothing is cut there, so nothing can be cut into.
    pub(super) in_feed: bool,
    /// Least and greatest height of the tip over the working plane, mm, where it is known.
    pub(super) heights: Option<[f64; 2]>,
    pub(super) look_ahead: usize,
}

/// What a piece of the path belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathRole {
    /// Along a block of the contour.
    Block,
    /// Around the corner at the start of a block.
    Corner,
    Entry,
    Exit,
}

/// A piece of the path of the tool center, in feed.
#[derive(Clone, Debug)]
pub(super) struct CenterPiece {
    pub(super) element: Element,
    pub(super) role: PathRole,
    /// Index of the block in the stretch; of the first block for the entry, of the last one for the exit.
    pub(super) wall: usize,
    /// Tool radius, mm.
    pub(super) radius: f64,
    pub(super) heights: Option<[f64; 2]>,
    pub(super) location: Location,
}

/// A piece of the path that comes nearer to a block than the radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContourCut {
    /// Index of the piece.
    pub(super) way: usize,
    /// Index of the block that is cut.
    pub(super) wall: usize,
    pub(super) depth: f64,
    /// Tool center at the deepest place, and the point of the contour there.
    pub(super) center: Point,
    pub(super) point: Point,
}

#[derive(Clone, Debug, Default)]
pub(super) struct ContourStretch {
    pub(super) walls: Vec<ContourBlock>,
    pub(super) ways: Vec<CenterPiece>,
    /// Blocks at the start that were checked before.
    checked: usize,
}

impl ContourStretch {
    pub(super) fn is_empty(&self) -> bool {
        self.walls.is_empty()
    }

    /// True when the stretch has grown so far that it is to be checked, and its older half forgotten.
    pub(super) fn is_full(&self) -> bool {
        self.walls.len() >= 2 * WINDOW
    }

    /// Drops the older half; what is left was checked.
    pub(super) fn forget(&mut self) {
        self.ways.retain(|way| way.wall >= WINDOW);
        for way in &mut self.ways {
            way.wall -= WINDOW;
        }
        self.walls.drain(..WINDOW.min(self.walls.len()));
        self.checked = self.walls.len();
    }

    /// Everything that the path cuts, in the order of the path.
    pub(super) fn cuts(&self) -> Vec<ContourCut> {
        let tree = BoundsTree::new(&self.walls);
        let mut cuts = Vec::new();
        for (index, way) in self.ways.iter().enumerate() {
            let first = if way.wall >= self.checked { 0 } else { self.checked };
            self.cuts_of(way, index, &tree, first, &mut cuts);
        }
        cuts
    }

    /// What a piece that is not part of the stretch cuts, deepest first.
    pub(super) fn cut_by(&self, way: &CenterPiece) -> Option<ContourCut> {
        let mut cuts = Vec::new();
        self.cuts_of(way, self.ways.len(), &BoundsTree::new(&self.walls), 0, &mut cuts);
        cuts.into_iter().max_by(|a, b| a.depth.total_cmp(&b.depth))
    }

    fn cuts_of(&self, way: &CenterPiece, index: usize, tree: &BoundsTree, first: usize, cuts: &mut Vec<ContourCut>) {
        let own = self.walls.get(way.wall).map_or(0.0, |wall| slack(&wall.element));
        let from = cuts.len();
        tree.search(&way.element, way.radius - GOUGE_MM, &mut |wall| {
            let Some(found) = self.walls.get(wall).filter(|_| wall >= first) else { return };
            let radius = way.radius.min(found.offset.abs());
            let (distance, center, point) = distance::between(&way.element, &found.element);
            let depth = radius - distance;
            if depth > GOUGE_MM + own + slack(&found.element) {
                cuts.push(ContourCut { way: index, wall, depth, center, point });
            }
        });
        cuts[from..].sort_by_key(|cut| cut.wall);
    }
}

/// How far the programmed end of an arc lies off its circle, mm: the text does not define the
/// contour any closer.
fn slack(element: &Element) -> f64 {
    match element.shape {
        ElementShape::Line => 0.0,
        ElementShape::Arc { center, radius, .. } => (norm(sub(element.end, center)) - radius).abs(),
    }
}

/// Boxes about the blocks, about pairs of them, pairs of pairs, up to all.
struct BoundsTree {
    levels: Vec<Vec<Bounds>>,
}

impl BoundsTree {
    fn new(walls: &[ContourBlock]) -> Self {
        let leaves = walls.iter().map(|wall| {
            let counts = wall.in_feed && wall.offset.abs() > GOUGE_MM;
            if counts { Bounds::of(&wall.element) } else { Bounds::EMPTY }
        });
        let mut levels = vec![leaves.collect::<Vec<_>>()];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let pairs = below.chunks(2).map(|pair| {
                let mut both = Bounds::EMPTY;
                pair.iter().for_each(|bounds| both.join(bounds));
                both
            });
            let pairs = pairs.collect();
            levels.push(pairs);
        }
        Self { levels }
    }

    /// Passes on the blocks whose boxes may come nearer to the element than the distance.
    fn search(&self, element: &Element, distance: f64, tell: &mut impl FnMut(usize)) {
        let bounds = Bounds::of(element);
        let mut open = vec![(self.levels.len() - 1, 0)];
        while let Some((level, index)) = open.pop() {
            let Some(found) = self.levels.get(level).and_then(|boxes| boxes.get(index)) else { continue };
            if found.at_least(element, &bounds) >= distance {
                continue;
            }
            if level == 0 {
                tell(index);
            } else {
                open.extend([(level - 1, 2 * index + 1), (level - 1, 2 * index)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn a_long_stretch_forgets_its_older_half_and_tells_nothing_twice() {
        // A wall along X in blocks of 1 mm; the path along it is 2 mm off and cuts nothing, but for
        // one that is 1 mm off.
        let location = Location { file: Arc::from("x"), line: 1, column: 1, length: 1, depth: 0 };
        let line = |x: f64, y: f64| Element { start: [x, y], end: [x + 1.0, y], shape: ElementShape::Line };
        let mut stretch = ContourStretch::default();
        let add = |stretch: &mut ContourStretch, index: usize, y: f64| {
            let (x, wall, location) = (index as f64, stretch.walls.len(), location.clone());
            let way =
                CenterPiece { element: line(x, y), role: PathRole::Block, wall, radius: 2.0, heights: None, location };
            let location = way.location.clone();
            let element = line(x, 0.0);
            stretch.walls.push(ContourBlock {
                element,
                offset: 2.0,
                location,
                in_feed: true,
                heights: None,
                look_ahead: 1,
            });
            stretch.ways.push(way);
        };
        for index in 0..2 * WINDOW {
            assert!(!stretch.is_full());
            add(&mut stretch, index, if index == WINDOW + 5 { 1.0 } else { 2.0 });
        }
        assert!(stretch.is_full());
        let cuts = stretch.cuts();
        // Its own block, and those on both sides that come nearer than 2 mm: ends 1 mm along X from
        // it are sqrt(2) away.
        assert_eq!(cuts.iter().map(|c| c.wall).collect::<Vec<_>>(), (WINDOW + 3..=WINDOW + 7).collect::<Vec<_>>());
        assert!((cuts[2].depth - 1.0).abs() < 1e-12 && (cuts[1].depth - 1.0).abs() < 1e-12);
        stretch.forget();
        assert_eq!((stretch.walls.len(), stretch.ways.len()), (WINDOW, WINDOW));
        assert!(stretch.cuts().is_empty(), "reported before");
        add(&mut stretch, 2 * WINDOW, 1.5);
        assert_eq!(stretch.cuts().iter().map(|c| c.wall).collect::<Vec<_>>(), [WINDOW - 2, WINDOW - 1, WINDOW]);
        assert!(stretch.cuts().iter().all(|c| c.way == WINDOW));
    }
}
