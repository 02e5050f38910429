use proveout_geom::Vector;

/// A shift that comes with the turn of a rotary joint: `-(1 - cos q)` times this vector, mm, in M with all
/// joints at zero. The tilt joint of a [`Platform`](crate::Platform) has one: half the moving radius along
/// leg 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnShift(pub Vector);

impl TurnShift {
    /// The shift at a joint value (radian), mm.
    pub fn at(&self, value: f64) -> Vector {
        let half = (0.5 * value).sin();
        self.0 * (-2.0 * half * half)
    }

    /// Its derivative by the joint value, mm/rad.
    pub fn rate(&self, value: f64) -> Vector {
        self.0 * -value.sin()
    }
}
