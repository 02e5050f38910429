//! From dimensions to an assembly of convex bodies.

use crate::cutter::{LARGEST_MM, length, refuse, within};
use crate::outline::ToolOutline;
use crate::profile::JOIN_MM;
use crate::{Body, Cutter, HolderSection, Role, ShapeError, Tool};

/// Builds a [`Tool`] from dimensions (mm).
///
/// ```text
///  z = gauge length  ___________   gauge line of the spindle
///                   |  holder   |  sections, from the tip side to the gauge line
///                    \_________/   z = gauge length - sum of the sections: holder nose
///                       |   |      shank
///                        \ /       transition
///                        | |       neck
///                        | |       z = flute length
///                        |_|       cutter
///  z = 0                  .        programmed tip
/// ```
///
/// ```
/// use proveout_tool::{Cutter, HolderSection, Role, ToolBuilder};
///
/// let holder = HolderSection { diameter: 40.0, top_diameter: 50.0, length: 70.0 };
/// let tool = ToolBuilder::new(3, "END_D12", Cutter::flat(12.0)?, 26.0, 120.0)
///     .shank(12.0)
///     .holder([holder])
///     .build()?;
/// let parts = tool.bodies.iter().map(|b| (b.role, b.profile.z_min(), b.profile.z_max()));
/// let parts: Vec<_> = parts.collect();
/// // The nose of the holder is at 120 - 70 = 50 mm.
/// assert_eq!(parts[0], (Role::Cutting, 0.0, 26.0));
/// assert_eq!(parts[1], (Role::Shank, 26.0, 50.0));
/// assert_eq!(parts[2], (Role::Holder, 50.0, 120.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ToolBuilder {
    tool: Tool,
    cutter: Cutter,
    neck: Option<(f64, f64)>,
    transition: Option<f64>,
    shank_diameter: Option<f64>,
    overall_length: Option<f64>,
    holder: Vec<HolderSection>,
}

impl ToolBuilder {
    /// A tool with its cutter, the length of its flutes and its gauge length.
    pub fn new(number: u32, name: impl Into<String>, cutter: Cutter, flute_length: f64, gauge_length: f64) -> Self {
        let tool = Tool {
            number,
            name: name.into(),
            description: String::new(),
            bodies: Vec::new(),
            gauge_length,
            flute_length,
            overall_length: None,
            flutes: None,
            center_cutting: None,
            dead_center: None,
            max_ramp_angle: None,
            max_speed_rpm: None,
            left_handed: false,
            has_holder: false,
            edges: None,
            is_tap: false,
            is_thread_mill: false,
            thread: None,
            stylus: None,
            residual: None,
        };
        Self { tool, cutter, neck: None, transition: None, shank_diameter: None, overall_length: None, holder: vec![] }
    }

    /// Words for people.
    pub fn description(mut self, text: impl Into<String>) -> Self {
        self.tool.description = text.into();
        self
    }

    /// A neck of this diameter, from the end of the flutes over this length.
    pub fn neck(mut self, diameter: f64, length: f64) -> Self {
        self.neck = Some((diameter, length));
        self
    }

    /// Length of the cone between flutes or neck and the shank.
    pub fn transition(mut self, length: f64) -> Self {
        self.transition = Some(length);
        self
    }

    /// Shank from there to the holder nose.
    pub fn shank(mut self, diameter: f64) -> Self {
        self.shank_diameter = Some(diameter);
        self
    }

    /// Length of the cutting tool alone, to prove that it reaches into the holder.
    pub fn overall_length(mut self, length: f64) -> Self {
        self.overall_length = Some(length);
        self
    }

    /// Sections of the holder, from the tip side to the gauge line.
    pub fn holder(mut self, sections: impl IntoIterator<Item = HolderSection>) -> Self {
        self.holder = sections.into_iter().collect();
        self
    }

    /// Number of flutes.
    pub fn flutes(mut self, count: u32) -> Self {
        self.tool.flutes = Some(count);
        self
    }

    /// Whether the tool may plunge.
    pub fn center_cutting(mut self, yes: bool) -> Self {
        self.tool.center_cutting = Some(yes);
        self
    }

    /// Radius of the region round the axis without edges, mm.
    pub fn dead_center(mut self, radius: f64) -> Self {
        self.tool.dead_center = Some(radius);
        self
    }

    /// Steepest way into material of a tool without edges at its center, radian.
    pub fn max_ramp_angle(mut self, angle: f64) -> Self {
        self.tool.max_ramp_angle = Some(angle);
        self
    }

    /// Highest spindle speed, 1/min.
    pub fn max_speed_rpm(mut self, speed: f64) -> Self {
        self.tool.max_speed_rpm = Some(speed);
        self
    }

    /// Cuts when the spindle turns counter-clockwise (M4).
    pub fn left_handed(mut self, yes: bool) -> Self {
        self.tool.left_handed = yes;
        self
    }

    /// Makes the bodies.
    ///
    /// The part above the flutes on the cutter's own curve or diameter is [`Role::Neck`]; from the end of the
    /// neck on, a part with a stated shank diameter is [`Role::Shank`].
    ///
    /// # Errors
    /// The first dimension that does not fit the others, with the key of the library file.
    pub fn build(mut self) -> Result<Tool, ShapeError> {
        let gauge = length("gauge_length_mm", self.tool.gauge_length)?;
        let flute = self.tool.flute_length;
        let (flutes, own_neck) = self.cutter.divided(flute)?;
        let nose = self.nose(gauge)?;
        let reach = flute.max(self.cutter.height());
        if nose < reach - JOIN_MM {
            let limit = format!("leaves {nose} mm from tip to holder nose, but the cutter ends at {reach} mm");
            return refuse("gauge_length_mm", gauge, limit);
        }
        if let Some(overall) = self.overall_length {
            length("overall_length_mm", overall)?;
            if overall < nose - JOIN_MM {
                return refuse("overall_length_mm", overall, format!("must be at least {nose} mm to reach the holder"));
            }
            self.tool.overall_length = Some(overall);
        }
        let cutter_radius = if own_neck.end()[0] > 0.0 { own_neck.end()[0] } else { flutes.end()[0] };
        self.add(Role::Cutting, &flutes)?;
        let mut neck = own_neck;
        let mut z = reach;
        if let Some((diameter, span)) = self.neck {
            let r = 0.5 * length("neck_diameter_mm", diameter)?;
            let top = reach + length("neck_length_mm", span)?;
            if top > nose + JOIN_MM {
                let limit = format!("must be at most {} mm, up to the holder nose", nose - reach);
                return refuse("neck_length_mm", span, limit);
            }
            neck = joined(neck, reach).line([r, reach]).line([r, top]);
            z = top;
        }
        let at_neck = if neck.end()[0] > 0.0 { neck.end()[0] } else { cutter_radius };
        let transition = within("transition_length_mm", self.transition.unwrap_or(0.0), 0.0, LARGEST_MM)?;
        let Some(shank_diameter) = self.shank_diameter else {
            if self.transition.is_some() {
                return refuse("transition_length_mm", transition, "needs a shank_diameter_mm to lead to");
            }
            if nose > z + JOIN_MM {
                neck = joined(neck, z).line([at_neck, z]).line([at_neck, nose]);
            }
            self.add(Role::Neck, &neck)?;
            return self.finish(nose);
        };
        self.add(Role::Neck, &neck)?;
        let r = 0.5 * length("shank_diameter_mm", shank_diameter)?;
        if z + transition > nose + JOIN_MM {
            let limit = format!("must be at most {} mm, up to the holder nose", nose - z);
            return refuse("transition_length_mm", transition, limit);
        }
        let foot = if transition > 0.0 { at_neck } else { r };
        let shank = ToolOutline::start(z).line([foot, z]).line([r, z + transition]).extended(nose);
        self.add(Role::Shank, &shank)?;
        self.finish(nose)
    }

    /// Height of the holder nose, mm; the gauge line when there is no holder.
    fn nose(&self, gauge: f64) -> Result<f64, ShapeError> {
        let mut sum = 0.0;
        for section in &self.holder {
            length("diameter_mm", section.diameter)?;
            length("top_diameter_mm", section.top_diameter)?;
            sum += length("length_mm", section.length)?;
        }
        if sum >= gauge {
            return refuse("gauge_length_mm", gauge, format!("must be above {sum} mm, the length of the holder"));
        }
        Ok(gauge - sum)
    }

    fn finish(mut self, nose: f64) -> Result<Tool, ShapeError> {
        let mut outline = ToolOutline::start(nose);
        let mut z = nose;
        for section in std::mem::take(&mut self.holder) {
            outline = outline.line([0.5 * section.diameter, z]);
            z += section.length;
            outline = outline.line([0.5 * section.top_diameter, z]);
            self.tool.has_holder = true;
        }
        self.add(Role::Holder, &outline)?;
        Ok(self.tool)
    }

    fn add(&mut self, role: Role, outline: &ToolOutline) -> Result<(), ShapeError> {
        self.tool.bodies.extend(outline.convex_bodies()?.into_iter().map(|profile| Body { role, profile }));
        Ok(())
    }
}

/// The curve, or a new one at height `z` when it is still empty.
fn joined(outline: ToolOutline, z: f64) -> ToolOutline {
    if outline.end()[0] > 0.0 { outline } else { ToolOutline::start(z) }
}
