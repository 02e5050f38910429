//! Heights over a rectangle.

/// Why a texture cannot be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TextureError {
    /// Fewer than two points along a direction, or heights that do not fill the lattice.
    #[error("{points} heights do not fill a lattice of {columns} x {rows} points with at least 2 in each direction")]
    Lattice {
        /// Heights given.
        points: usize,
        /// Points along x.
        columns: usize,
        /// Points along y.
        rows: usize,
    },
    /// A step that is not a positive length.
    #[error("a step of {0} mm is not a spacing of points")]
    Step(f64),
    /// A height that is not a number.
    #[error("height {index} is {value}; texture is evaluated on complete lattices")]
    Hole {
        /// Place in the list.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The data are shorter than what the setting asks for.
    #[error("{length_mm:.4} mm are there, {wanted_mm:.4} mm are needed for class {class}: {what}")]
    TooShort {
        /// Length at hand, mm.
        length_mm: f64,
        /// Length needed, mm.
        wanted_mm: f64,
        /// Setting class.
        class: &'static str,
        /// What needs it.
        what: &'static str,
    },
    /// The points lie too far apart for the class.
    #[error("points every {step_um:.4} um cannot carry class {class}, which needs {limit_um:.4} um or less")]
    TooCoarse {
        /// Spacing, um.
        step_um: f64,
        /// Largest spacing, um.
        limit_um: f64,
        /// Setting class.
        class: &'static str,
    },
}

/// Heights over a lattice of equal steps, mm; x runs fastest. Nodes are points, both ends included.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    columns: usize,
    rows: usize,
    step_x: f64,
    step_y: f64,
    heights: Vec<f64>,
}

impl HeightMap {
    /// A map of `columns` x `rows` heights with steps in mm.
    ///
    /// # Errors
    /// [`TextureError`] when the heights do not fill the lattice or something is not a finite number.
    pub fn new(columns: usize, rows: usize, step_x: f64, step_y: f64, heights: Vec<f64>) -> Result<Self, TextureError> {
        if columns < 2 || rows < 2 || columns.checked_mul(rows) != Some(heights.len()) {
            return Err(TextureError::Lattice { points: heights.len(), columns, rows });
        }
        for step in [step_x, step_y] {
            if !(step.is_finite() && step > 0.0) {
                return Err(TextureError::Step(step));
            }
        }
        if let Some(index) = heights.iter().position(|z| !z.is_finite()) {
            return Err(TextureError::Hole { index, value: heights[index] });
        }
        Ok(Self { columns, rows, step_x, step_y, heights })
    }

    /// Points along x.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Points along y.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Spacing along x, mm.
    pub fn step_x(&self) -> f64 {
        self.step_x
    }

    /// Spacing along y, mm.
    pub fn step_y(&self) -> f64 {
        self.step_y
    }

    /// Extent along x and y, mm.
    pub fn size(&self) -> [f64; 2] {
        [(self.columns - 1) as f64 * self.step_x, (self.rows - 1) as f64 * self.step_y]
    }

    /// All heights, x fastest, mm.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Height at column `i`, row `j`, mm.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * self.columns + i]
    }

    /// The same lattice with other heights; used by filters, which keep the length.
    pub(crate) fn with_heights(&self, heights: Vec<f64>) -> Self {
        debug_assert_eq!(heights.len(), self.heights.len());
        Self { heights, ..*self }
    }

    /// Height of each point above `other`, on the same lattice.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.with_heights(self.heights.iter().zip(&other.heights).map(|(a, b)| a - b).collect())
    }

    /// The map without its least-squares plane.
    #[must_use]
    pub fn leveled(&self) -> Self {
        let (nx, ny) = (self.columns, self.rows);
        let (mx, my) = (0.5 * (nx - 1) as f64, 0.5 * (ny - 1) as f64);
        let mean = super::areal::sum(self.heights.iter().copied()) / self.heights.len() as f64;
        // Over a full lattice the two slopes are independent of each other.
        let (mut xz, mut yz) = (0.0, 0.0);
        for (j, row) in self.heights.chunks(nx).enumerate() {
            for (i, z) in row.iter().enumerate() {
                xz += (i as f64 - mx) * (z - mean);
                yz += (j as f64 - my) * (z - mean);
            }
        }
        // Sum of squares of n places about their middle: n (n^2 - 1) / 12.
        let spread = |n: usize, m: usize| (n as f64 * ((n as f64).powi(2) - 1.0) / 12.0) * m as f64;
        let (sx, sy) = (xz / spread(nx, ny), yz / spread(ny, nx));
        let heights = (0..self.heights.len())
            .map(|k| self.heights[k] - mean - sx * ((k % nx) as f64 - mx) - sy * ((k / nx) as f64 - my))
            .collect();
        self.with_heights(heights)
    }
}
