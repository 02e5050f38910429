//! Refuses a raw stock of which the rays see too little, or too much.
//!
//! A bar of 1 mm between rays 2 mm apart is no stock at all: whatever a tool does to it passes every gate.
//! The volume on the rays of each direction, counted by whole cells, is compared with that of the shape
//! itself.

use proveout_stock::{RawBody, TriDexel};

use crate::{
    prepare::error::SimError,
    scene::{Scene, mesh_unit},
    units::MM_PER_M,
};

/// Part of its volume by which a stock may differ on the rays of any direction.
pub(crate) const SHARE: f64 = 1.0 / 3.0;
/// Each try of a finer cell has so much of the edge of the one before.
const FINER: f64 = 0.8;
/// Tries of a finer cell: down to a few thousandths of the first.
const TRIES: i32 = 40;
/// Rays that a try may cost.
const MOST_RAYS: f64 = 4e6;
/// A box smaller than this in all directions is no workpiece, mm: meters or inches read as millimeters.
const SMALL_MM: f64 = 0.5;
/// A mesh without a unit that is smaller than this may have been written in inches, mm.
const SMALL_IN_INCHES_MM: f64 = 10.0;

/// Volume on the rays of the three directions, by whole cells, mm³.
fn on_rays(stock: &TriDexel) -> [f64; 3] {
    [0, 1, 2].map(|axis| stock.volume_along(axis))
}

/// The volume that is farthest from the shape's, where it differs by more than [`SHARE`].
fn too_far(stock: &TriDexel, own: Option<f64>) -> Option<f64> {
    let on_rays = on_rays(stock);
    let Some(own) = own else { return on_rays.into_iter().find(|v| *v <= 0.0) };
    let off = |v: f64| (v - own).abs();
    let worst = on_rays.into_iter().max_by(|a, b| off(*a).total_cmp(&off(*b)))?;
    (off(worst) > SHARE * own.abs() || worst <= 0.0).then_some(worst)
}

/// Refuses a stock that its rays do not hold.
///
/// # Errors
/// The place of the cell size, both volumes, and the cell size that would do.
pub(crate) fn check(scene: &Scene, body: &RawBody, stock: &TriDexel) -> Result<(), SimError> {
    let own = body.own_volume();
    let Some(worst) = too_far(stock, own) else { return Ok(()) };
    let size = stock.bounds().size();
    let [x, y, z] = stock.cells_mm();
    let cells = if x == y && y == z { format!("{x} mm") } else { format!("{x} x {y} x {z} mm") };
    let volume = own.map_or_else(String::new, |own| format!(" of its {own:.6} mm3"));
    let message = format!(
        "the stock of {:.4} x {:.4} x {:.4} mm has {:.6} mm3{volume} on rays {cells} apart, more than {:.0} percent off: most of it lies \
         between the rays, where no cut would be seen",
        size.x,
        size.y,
        size.z,
        worst.max(0.0) + 0.0,
        100.0 * SHARE
    );
    let finer = fitting(body, stock).map_or_else(
        || format!("use a resolution_mm below {:.6} mm", size.min() / 3.0),
        |cell| format!("a resolution_mm of {cell} mm would do"),
    );
    let in_unit = |(name, word, factor): (&str, &str, f64)| {
        let [x, y, z] = [0, 1, 2].map(|a| factor * size[a]);
        format!(
            "; if the drawing is {x:.3} x {y:.3} x {z:.3} mm, the stock was written in {name}: write mesh_unit = \"{word}\" under [stock]"
        )
    };
    let unit = match size.max() {
        size if size < SMALL_MM => in_unit(("meters", "m", MM_PER_M)),
        size if size < SMALL_IN_INCHES_MM && mesh_unit::is_stock_in_doubt(scene) => in_unit(("inches", "inch", 25.4)),
        _ => String::new(),
    };
    Err(scene.fault(scene.file.resolution_mm.span().start, message, finer + &unit).into())
}

/// A cell size, rounded down to two digits, on whose rays the stock holds; none where no try did.
fn fitting(body: &RawBody, stock: &TriDexel) -> Option<f64> {
    let bounds = stock.bounds();
    // A cell that is longer than the stock sees nothing of it.
    let first = stock.cell_mm().min(bounds.size().max());
    (1..=TRIES).map(|k| two_digits(first * FINER.powi(k))).find(|cell| {
        let affordable = TriDexel::rays_in(&bounds, *cell) <= MOST_RAYS;
        affordable && body.stock(*cell, u64::MAX).is_ok_and(|finer| too_far(&finer, body.own_volume()).is_none())
    })
}

fn two_digits(x: f64) -> f64 {
    let exponent = x.log10().floor() as i32 - 1;
    // Tens of a negative power are divided by, so that 0.4 is 0.4.
    let digits = (x / 10_f64.powi(exponent)).floor();
    if exponent < 0 { digits / 10_f64.powi(-exponent) } else { digits * 10_f64.powi(exponent) }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, Point, TriMesh, Vector, box_mesh};

    use super::*;

    const GIB: u64 = 1 << 30;

    fn block(x: f64, y: f64, z: f64) -> RawBody {
        RawBody::block(&Aabb { min: Point::origin(), max: Point::new(x, y, z) })
    }

    fn bar(radius: f64, along: &Vector, length: f64) -> RawBody {
        RawBody::cylinder(&Point::new(0.3, 0.2, -0.1), along, radius, length).expect("a bar")
    }

    /// Thin bars, plates and rods, at cells that miss them: refused, and the cell size that is named holds
    /// them.
    #[test]
    fn a_stock_between_the_rays_is_refused_with_a_cell_size_that_holds_it() {
        let meters =
            |size: f64| -> TriMesh { box_mesh(&Aabb { min: Point::origin(), max: Point::new(size, size, size) }) };
        let thin = [
            (bar(0.5, &Vector::z(), 40.0), 2.0),
            (bar(0.3, &Vector::x(), 50.0), 1.0),
            (bar(1.0, &Vector::y(), 30.0), 5.0),
            (block(4.0, 4.0, 40.0), 10.0),
            (block(60.0, 2.0, 1.0), 5.0),
            (block(60.0, 60.0, 0.1), 1.0),
            (block(1.0, 1.0, 1.0), 1e3),
            (RawBody::mesh(meters(0.06)).expect("solid"), 0.5),
        ];
        for (k, (body, cell)) in thin.iter().enumerate() {
            let stock = body.stock(*cell, GIB).expect("rays");
            assert!(
                too_far(&stock, body.own_volume()).is_some(),
                "{k}: {:?} of {:?}",
                on_rays(&stock),
                body.own_volume()
            );
            let finer = fitting(body, &stock).unwrap_or_else(|| panic!("{k} fits"));
            assert!(finer < *cell, "{k}");
            let stock = body.stock(finer, GIB).expect("rays");
            assert!(too_far(&stock, body.own_volume()).is_none(), "{k} at {finer}");
        }
    }

    #[test]
    fn a_stock_of_a_few_cells_is_taken() {
        let of = |body: RawBody, cell: f64| too_far(&body.stock(cell, GIB).expect("rays"), body.own_volume());
        for cell in [0.5, 1.0, 2.0, 3.0, 4.0] {
            assert_eq!(of(block(40.0, 40.0, 20.0), cell), None, "{cell}");
            assert_eq!(of(bar(10.0, &Vector::z(), 30.0), cell), None, "{cell}");
        }
    }

    #[test]
    fn cell_sizes_are_named_with_two_digits() {
        for (x, expected) in [(0.0345, 0.034), (1.99, 1.9), (12.0, 12.0), (345.0, 340.0), (0.4, 0.4)] {
            assert_eq!(two_digits(x), expected);
        }
    }
}
