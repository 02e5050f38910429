//! Coordinate systems in the form of `CAMWorks`: `TRNTYP` before each operation, and `CSYS` with
//! three rows of four values, the axes of the system in its columns and its origin in the fourth.
//!
//! ```text
//!   CSYS/ xx, yx, zx, ox,
//!         xy, yy, zy, oy,
//!         xz, yz, zz, oz
//! ```

use super::reader::{AptReader, arity};
use super::statement::{AptStatement, Bad};
use crate::codes;
use crate::source::Source;

/// Values that differ by no more than this from the identity mean no change of system: CL data has
/// six digits.
const SAME: f64 = 1e-6;

impl AptReader {
    /// CSYS: only the system of the program itself. Whether the points of another system refer to
    /// it or to the part depends on the setup of the CAM system.
    pub(crate) fn csys(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 12];
        let count = self.numbers(source, st, &mut n)?;
        if count != 12 {
            return Err(arity(st.head, "CSYS", count, "three rows of four values"));
        }
        let identity = |at: usize| if at.is_multiple_of(5) { 1.0 } else { 0.0 };
        if n.iter().enumerate().any(|(at, value)| (value - identity(at)).abs() > SAME) {
            return Err(st.head.bad(
                codes::UNSUPPORTED_WORD,
                "`CSYS` other than 1,0,0,0, 0,1,0,0, 0,0,1,0 is not supported",
                "output the points in one coordinate system, with the tool axis as a vector",
            ));
        }
        self.note("CSYS");
        Ok(())
    }

    /// TRNTYP/WORLD,0,0,0: the points are those of the part.
    pub(crate) fn transform_type(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let word = st.items.first().map(|item| Self::word(source, item)).unwrap_or_default();
        let rest = st.items.get(1..).unwrap_or_default();
        let values = rest.iter().map(|item| self.number(source, item)).collect::<Result<Vec<f64>, _>>()?;
        if word != "WORLD" || values.iter().any(|value| value.abs() > SAME) {
            return Err(st.head.bad(
                codes::UNSUPPORTED_WORD,
                format!("`TRNTYP/{word}` with these values is not supported"),
                "output the points in the coordinate system of the part: TRNTYP/WORLD,0,0,0",
            ));
        }
        self.note("TRNTYP/WORLD");
        Ok(())
    }
}
