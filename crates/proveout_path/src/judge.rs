//! What a path asks of a machine, before anything moves: joint positions at every contact, their way, their
//! rates for each mm of the contact's path, the feed that the joint limits allow, the distance to poles.
//!
//! With q the joints at the contacts and s the length of the contacts' path, a block asks `|q_i - q_(i-1)| /
//! (s_i - s_(i-1))` of each joint for each mm, and its limit allows a feed of `limit |s_i - s_(i-1)| / |q_i -
//! q_(i-1)|` at the contact: the measures of Lu et al. 2022, section 4, by the blocks that the program will
//! have. The legs of platforms count as joints of their own.
//!
//! Without tool center point control the joints move straight from block to block and the tip does not: its
//! distance from its chord is looked at 20 places inside of every block.

use proveout_geom::{Pose, ToolPose};
use proveout_machine::{JointValues, Machine};

use super::{BladeLocation, LineContacts, PathContact, PathError};
use proveout_blade::Domain;

/// Where a path runs.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Frame of the surface on the table.
    pub table_from_surface: Pose,
    /// From the tip to the gauge line, mm.
    pub tool_length: f64,
    /// Ranges of the surface's parameters, for messages.
    pub domain: Domain,
    /// Feed at the contact, mm/s.
    pub feed: f64,
}

/// A largest or smallest value with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// The value.
    pub value: f64,
    /// Its line.
    pub line: String,
    /// Its place.
    pub at: BladeLocation,
}

/// What a joint or a leg does.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDemand {
    /// Name.
    pub name: String,
    /// In radian instead of mm.
    pub rotary: bool,
    /// Sum of its steps along all lines, without the ways between lines, mm or radian.
    pub travel: f64,
    /// Lowest and highest position at contacts.
    pub range: [f64; 2],
    /// Changes of direction along lines.
    pub reversals: usize,
    /// Largest change for each mm of the contact's path, mm/mm or radian/mm.
    pub rate: Option<Extreme>,
    /// Limit of its velocity, mm/s or radian/s, where one is stated.
    pub limit: Option<f64>,
}

impl JointDemand {
    /// Velocity at a feed of the contact (mm/s), mm/s or radian/s.
    pub fn velocity(&self, feed: f64) -> f64 {
        self.rate.as_ref().map_or(0.0, |r| r.value * feed)
    }
}

/// What a path asks.
#[derive(Clone, Debug, PartialEq)]
pub struct PathJudgement {
    /// Joints, then legs of platforms.
    pub joints: Vec<JointDemand>,
    /// Joint positions at the contacts of every line.
    pub positions: Vec<Vec<JointValues>>,
    /// Feed that joint limits allow in the block that ends at each contact, mm/s; infinite where nothing
    /// limits it. For the first contact of a line that of the second.
    pub feeds: Vec<Vec<f64>>,
    /// Lowest of them.
    pub lowest_feed: Option<Extreme>,
    /// Joint that allows no more there.
    pub slowest_joint: Option<String>,
    /// Largest turn of the tool axis for each mm, radian/mm.
    pub axis_rate: Option<Extreme>,
    /// Smallest angle between the tool axis and a pole of the machine, radian; none on machines without
    /// poles.
    pub pole: Option<Extreme>,
    /// Largest distance of the tip from its chord where the joints move straight between contacts, mm.
    pub tip_error_without_tcp: Option<Extreme>,
    /// Largest error of the straight motion of tip and axis between contacts, mm.
    pub chord_error: Option<Extreme>,
    /// Highest scallop as computed, mm.
    pub scallop: Option<Extreme>,
    /// Largest side step, mm.
    pub side_step: Option<Extreme>,
    /// Deepest cut of a flank into its side, mm.
    pub flank_gouge: Option<Extreme>,
    /// Most that a flank leaves, mm.
    pub flank_left: Option<Extreme>,
    /// Largest angle between the normals at both ends of a ruling, radian.
    pub ruling_twist: Option<Extreme>,
    /// Length of the contacts' path, mm.
    pub length: f64,
    /// Number of contacts.
    pub contacts: usize,
    /// Places at which the programmed feed is more than the joints allow.
    pub slowed: usize,
    /// Time along the lines at the programmed feed, and where the joints allow less, at that, s.
    pub time: [f64; 2],
}

/// Places inside of a block at which the tip is looked at.
const INSIDE: usize = 20;
/// A step of a joint below this is rounding and turns nothing round, mm or radian.
const NO_STEP: f64 = 1e-10;

impl Setting<'_> {
    fn pose(&self, contact: &PathContact) -> ToolPose {
        contact.touch.pose.transformed(&self.table_from_surface)
    }

    /// The joints at every contact, each line going on from the one before.
    ///
    /// # Errors
    /// The first contact that the machine cannot take.
    pub fn positions(&self, lines: &[LineContacts], start: &JointValues) -> Result<Vec<Vec<JointValues>>, PathError> {
        let mut previous = *start;
        let mut all = Vec::with_capacity(lines.len());
        for line in lines {
            let mut positions = Vec::with_capacity(line.contacts.len());
            for contact in &line.contacts {
                let found = self.machine.inverse_nearest(&self.pose(contact), self.tool_length, &previous);
                let found =
                    found.map_err(|fault| PathError::Unreachable { at: contact.place.named(&self.domain), fault })?;
                previous = found.q;
                positions.push(found.q);
            }
            all.push(positions);
        }
        Ok(all)
    }

    /// Judges a path that begins with the joints at `start`.
    ///
    /// # Errors
    /// As [`Setting::positions`].
    pub fn judge(&self, lines: &[LineContacts], start: &JointValues) -> Result<PathJudgement, PathError> {
        let positions = self.positions(lines, start)?;
        let machine = self.machine;
        let mut joints: Vec<JointDemand> = Vec::new();
        for (j, joint) in machine.joints.iter().enumerate() {
            joints.push(self.demand(&joint.name, joint.is_rotary(), joint.max_velocity, lines, &positions, |q| q[j]));
        }
        for platform in &machine.platforms {
            for (k, leg) in platform.legs.iter().enumerate() {
                let length = |q: &JointValues| platform.leg_lengths(q)[k];
                joints.push(self.demand(&leg.name, false, leg.max_velocity, lines, &positions, length));
            }
        }
        let mut judged = PathJudgement {
            joints,
            feeds: Vec::with_capacity(lines.len()),
            lowest_feed: None,
            slowest_joint: None,
            axis_rate: None,
            pole: None,
            tip_error_without_tcp: None,
            chord_error: None,
            scallop: None,
            side_step: None,
            flank_gouge: None,
            flank_left: None,
            ruling_twist: None,
            length: lines.iter().filter_map(|l| l.contacts.last()).map(|c| c.length).sum(),
            contacts: lines.iter().map(|l| l.contacts.len()).sum(),
            slowed: 0,
            time: [0.0; 2],
            positions: Vec::new(),
        };
        for (line, q) in lines.iter().zip(&positions) {
            let feeds = self.along(line, q, &mut judged);
            judged.feeds.push(feeds);
        }
        judged.positions = positions;
        Ok(judged)
    }

    fn extreme(&self, line: &LineContacts, contact: &PathContact, value: f64) -> Extreme {
        Extreme { value, line: line.name.clone(), at: contact.place.named(&self.domain) }
    }

    fn most(&self, most: &mut Option<Extreme>, line: &LineContacts, contact: &PathContact, value: f64) {
        if most.as_ref().is_none_or(|m| value > m.value) {
            *most = Some(self.extreme(line, contact, value));
        }
    }

    fn least(&self, least: &mut Option<Extreme>, line: &LineContacts, contact: &PathContact, value: f64) {
        if least.as_ref().is_none_or(|m| value < m.value) {
            *least = Some(self.extreme(line, contact, value));
        }
    }

    fn demand(
        &self,
        name: &str,
        rotary: bool,
        limit: Option<f64>,
        lines: &[LineContacts],
        positions: &[Vec<JointValues>],
        value: impl Fn(&JointValues) -> f64,
    ) -> JointDemand {
        let mut demand = JointDemand {
            name: name.to_owned(),
            rotary,
            travel: 0.0,
            range: [f64::INFINITY, f64::NEG_INFINITY],
            reversals: 0,
            rate: None,
            limit,
        };
        for (line, q) in lines.iter().zip(positions) {
            let mut direction = 0.0;
            for k in 0..q.len() {
                let here = value(&q[k]);
                demand.range = [demand.range[0].min(here), demand.range[1].max(here)];
                if k == 0 {
                    continue;
                }
                let step = here - value(&q[k - 1]);
                let way = line.contacts[k].length - line.contacts[k - 1].length;
                demand.travel += step.abs();
                // Rounding turns nothing round.
                if step.abs() > NO_STEP {
                    demand.reversals += usize::from(step * direction < 0.0);
                    direction = step;
                }
                if way > 0.0 {
                    self.most(&mut demand.rate, line, &line.contacts[k], step.abs() / way);
                }
            }
        }
        demand
    }

    /// Feeds of a line, and what it adds to the extremes.
    fn along(&self, line: &LineContacts, q: &[JointValues], judged: &mut PathJudgement) -> Vec<f64> {
        let machine = self.machine;
        let mut feeds = Vec::with_capacity(q.len());
        let mut poles: Option<(JointValues, Vec<proveout_geom::Vector>)> = None;
        for (k, contact) in line.contacts.iter().enumerate() {
            let pose = self.pose(contact);
            // Poles do not move unless a joint that inverse kinematics does not turn has moved.
            let turned = |held: &JointValues| {
                machine.joints.iter().enumerate().any(|(j, joint)| joint.held && held[j] != q[k][j])
            };
            if poles.as_ref().is_none_or(|(held, _)| turned(held)) {
                poles = Some((q[k], machine.poles(&q[k]).collect()));
            }
            let angles =
                poles.iter().flat_map(|(_, poles)| poles).map(|p| p.cross(&pose.axis).norm().atan2(p.dot(&pose.axis)));
            if let Some(angle) = angles.reduce(f64::min) {
                self.least(&mut judged.pole, line, contact, angle);
            }
            if contact.chord_error > 0.0 || judged.chord_error.is_none() {
                self.most(&mut judged.chord_error, line, contact, contact.chord_error);
            }
            if let Some(scallop) = contact.scallop {
                self.most(&mut judged.scallop, line, contact, scallop);
            }
            if let Some(flank) = contact.flank {
                self.most(&mut judged.flank_gouge, line, contact, flank.gouge);
                self.most(&mut judged.flank_left, line, contact, flank.left);
                self.most(&mut judged.ruling_twist, line, contact, flank.twist);
            }
            if let Some(step) = contact.side_step {
                self.most(&mut judged.side_step, line, contact, step);
            }
            if k == 0 {
                continue;
            }
            let before = &line.contacts[k - 1];
            let way = contact.length - before.length;
            let turn = contact.touch.pose.angle_to(&before.touch.pose);
            if way > 0.0 {
                self.most(&mut judged.axis_rate, line, contact, turn / way);
            }
            self.tip_error(line, k, q, judged);
            let mut feed = f64::INFINITY;
            let mut slowest = None;
            let mut limited = |name: &str, limit: Option<f64>, step: f64| {
                let allowed = limit.map_or(f64::INFINITY, |l| if step > 0.0 { l * way / step } else { f64::INFINITY });
                if allowed < feed {
                    (feed, slowest) = (allowed, Some(name.to_owned()));
                }
            };
            for (j, joint) in machine.joints.iter().enumerate() {
                limited(&joint.name, joint.max_velocity, (q[k][j] - q[k - 1][j]).abs());
            }
            for platform in &machine.platforms {
                let [a, b] = [k - 1, k].map(|i| platform.leg_lengths(&q[i]));
                for (i, leg) in platform.legs.iter().enumerate() {
                    limited(&leg.name, leg.max_velocity, (b[i] - a[i]).abs());
                }
            }
            if judged.lowest_feed.as_ref().is_none_or(|l| feed < l.value) {
                judged.lowest_feed = Some(self.extreme(line, contact, feed));
                judged.slowest_joint = slowest;
            }
            judged.slowed += usize::from(feed < self.feed);
            judged.time[0] += way / self.feed;
            judged.time[1] += way / self.feed.min(feed);
            feeds.push(feed);
        }
        if let Some(&first) = feeds.first() {
            feeds.insert(0, first);
        } else {
            feeds.resize(q.len(), f64::INFINITY);
        }
        feeds
    }

    fn tip_error(&self, line: &LineContacts, k: usize, q: &[JointValues], judged: &mut PathJudgement) {
        let [from, to] = [k - 1, k].map(|i| self.pose(&line.contacts[i]).tip);
        let chord = to - from;
        let length2 = chord.norm_squared();
        let mut worst = 0.0_f64;
        for i in 1..=INSIDE {
            let at = q[k - 1].interpolated(q[k], i as f64 / (INSIDE + 1) as f64);
            let off = self.machine.forward(&at, self.tool_length).tip - from;
            let part = if length2 > 0.0 { (off.dot(&chord) / length2).clamp(0.0, 1.0) } else { 0.0 };
            worst = worst.max((off - chord * part).norm());
        }
        self.most(&mut judged.tip_error_without_tcp, line, &line.contacts[k], worst);
    }
}
