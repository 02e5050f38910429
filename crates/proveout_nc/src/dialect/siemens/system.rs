//! System variables that a program reads.
//!
//! Their values are computed when a line names one: `$P_EP[X]`, `$AA_IW[X]` (programmed position),
//! `$AA_IM[B]` (rotary axes only: machine positions of the linear axes depend on tool and machine),
//! `$P_TOOLNO`, `$P_TOOL`, `$P_TOOLR`, `$P_GG[n]`, `$P_F`, `$P_S`, `$P_SEARCH`, `$P_SIM`,
//! `$P_ISTEST`, and components of frames. Others are refused by name unless the settings give their
//! value.

use super::expr::Expr;
use super::modal::{FeedMode, Interpolation, SplineKind, Units};
use super::parser::{AddressValue, SiemensBlock, SiemensStatement, WordKind};
use super::run_state::Interpreter;
use crate::channel::expression::IndexedParameter;
use crate::compensation::OutsideCorner;
use crate::diagnostic::{Fault, FaultSubject};
use crate::settings::Compensation;
use crate::{AXIS_LETTERS, CompSide, Feed, PathMode, ToolName};

/// System variables have nine decimals.
const DECIMALS: f64 = 1e9;

/// What a fault about this variable is about: the variables of two families hold positions of axes.
pub(super) fn subject_of(variable: &str) -> Option<FaultSubject> {
    const FAMILIES: [&str; 2] = ["$P_EP", "$AA_I"];
    FAMILIES.iter().any(|family| variable.starts_with(family)).then_some(FaultSubject::PositionVariable)
}

impl Interpreter {
    /// Gives the variables the values of the system variables before this line.
    ///
    /// # Errors
    /// The block reads what no measuring motion has found.
    pub(crate) fn refresh_system(&mut self, block: &SiemensBlock) -> Result<(), Fault> {
        if let Some(fault) = self.reads_unmeasured(block) {
            return Err(fault);
        }
        let mut values: Vec<(String, f64)> = Vec::new();
        // Rounded to 1e-9: conversion to degrees and back changes the last bits, and programs
        // compare such values.
        let mut put = |name: &str, value: f64| values.push((name.to_owned(), (value * DECIMALS).round() / DECIMALS));
        let length = self.modal.units.length();
        for (axis, letter) in AXIS_LETTERS.iter().enumerate() {
            let unit = |v: f64| if (3..6).contains(&axis) { v.to_degrees() } else { v / length };
            if let Some(value) = self.position.work.get(axis) {
                put(&format!("$P_EP[{letter}]"), unit(value));
                put(&format!("$AA_IW[{letter}]"), unit(value));
            }
            if let Some(value) = self.position.base.get(axis).filter(|_| (3..6).contains(&axis)) {
                put(&format!("$AA_IM[{letter}]"), unit(value));
            }
        }
        for name in ["$P_SEARCH", "$P_SIM", "$P_ISTEST", "$P_DRYRUN"] {
            put(name, 0.0);
        }
        put("$P_TOOL", f64::from(self.own.edge.unwrap_or(1)));
        let tool = self.technology.in_spindle.as_ref();
        match tool {
            Some(ToolName::Number(number)) => put("$P_TOOLNO", f64::from(*number)),
            Some(ToolName::Empty) => put("$P_TOOLNO", 0.0),
            _ => {}
        }
        if let (Compensation::ToolCenter(radii), Some(tool)) = (&self.settings.compensation, tool)
            && let Some(radius) = radii.by_tool.get(tool)
        {
            put("$P_TOOLR", *radius);
        }
        if let Some(speed) = self.technology.speed {
            put("$P_S", speed);
        }
        if let Some(Feed::PerTime(feed)) = self.technology.feed {
            put("$P_F", feed * 60.0 / self.modal.units.feed());
        }
        self.measured_values(&mut |name, value| put(&name, value));
        for (group, value) in self.g_groups() {
            put(&format!("$P_GG[{group}]"), f64::from(value));
        }
        let mut components = Vec::new();
        visit_block(block, &mut |expr| {
            if let Expr::Element(name, indices) = expr
                && self.is_frame(name)
                && let Some(value) = self.frame_component(name, indices, block.span)
            {
                components.push((system_key(name, indices, &|e| self.variables.number(e, block.span).ok()), value));
            }
        });
        values.extend(components);
        self.variables.set_system(values);
        Ok(())
    }

    /// Numbers of the words in force by G group, after the list of G functions of the programming manual.
    fn g_groups(&self) -> Vec<(u32, u32)> {
        let modal = &self.modal;
        let mut groups = vec![
            (
                1,
                match modal.interpolation {
                    Interpolation::Rapid => 1,
                    Interpolation::Linear => 2,
                    Interpolation::Clockwise => 3,
                    Interpolation::CounterClockwise => 4,
                    Interpolation::Intermediate => 5,
                    Interpolation::Spline(SplineKind::Akima) => 6,
                    Interpolation::Spline(SplineKind::Basis) => 7,
                    Interpolation::Spline(SplineKind::Cubic) => 8,
                    Interpolation::Polynomial => 9,
                    Interpolation::Thread => 10,
                    Interpolation::TapIn => 11,
                    Interpolation::TapOut => 12,
                    Interpolation::Tangential => 15,
                },
            ),
            (6, [3, 2, 1][modal.normal.min(2)]),
            (
                7,
                match modal.compensation.side {
                    CompSide::Off => 1,
                    CompSide::Left => 2,
                    CompSide::Right => 3,
                },
            ),
            (
                13,
                match modal.units {
                    Units::InchLengths => 1,
                    Units::Metric => 2,
                    Units::Inch => 3,
                },
            ),
            (14, if modal.incremental { 2 } else { 1 }),
            (
                15,
                match modal.feed_mode {
                    FeedMode::InverseTime => 1,
                    FeedMode::PerTime => 2,
                    FeedMode::PerRevolution => 3,
                },
            ),
            (18, if modal.compensation.style.corner == OutsideCorner::Arc { 1 } else { 2 }),
        ];
        if modal.path_mode == PathMode::ExactStop {
            groups.push((10, 1));
        }
        groups
    }
}

/// Name of an element as the system variables are kept: `$P_UIFR[1,X,TR]`.
pub(crate) fn system_key(name: &str, indices: &[Expr], number: &dyn Fn(&Expr) -> Option<f64>) -> String {
    let mut key = format!("{name}[");
    for (at, index) in indices.iter().enumerate() {
        if at > 0 {
            key.push(',');
        }
        match (number(index), index) {
            (Some(value), _) => key.push_str(&value.to_string()),
            (None, Expr::Name(word)) => key.push_str(word),
            _ => key.push('?'),
        }
    }
    key.push(']');
    key
}

/// Calls the visitor with every expression of a block.
pub(super) fn visit_block(block: &SiemensBlock, visitor: &mut impl FnMut(&Expr)) {
    for word in &block.words {
        match &word.kind {
            WordKind::Address { value: AddressValue::Expr(expr), .. } => visit(expr, visitor),
            WordKind::Assign { value, .. } => visit(value, visitor),
            WordKind::Call(call) => call.arguments.iter().flatten().flatten().for_each(|e| visit(e, visitor)),
            _ => {}
        }
    }
    match &block.statement {
        Some(
            SiemensStatement::If(e)
            | SiemensStatement::IfGoto(e, _)
            | SiemensStatement::While(e)
            | SiemensStatement::Until(e),
        ) => {
            visit(e, visitor);
        }
        Some(SiemensStatement::For { from, to, .. }) => {
            visit(from, visitor);
            visit(to, visitor);
        }
        Some(SiemensStatement::Case { selector, .. }) => visit(selector, visitor),
        Some(SiemensStatement::Define { variables, .. }) => {
            variables.iter().filter_map(|v| v.initial.as_ref()).for_each(|e| visit(e, visitor));
        }
        _ => {}
    }
}

fn visit(expr: &Expr, visitor: &mut impl FnMut(&Expr)) {
    visitor(expr);
    match expr {
        Expr::Param(IndexedParameter(inner)) | Expr::Unary(_, inner) => visit(inner, visitor),
        Expr::Chain(first, rest) => {
            visit(first, visitor);
            rest.iter().for_each(|(_, operand)| visit(operand, visitor));
        }
        Expr::Call(_, arguments) => arguments.iter().flatten().for_each(|e| visit(e, visitor)),
        Expr::Element(_, indices) => indices.iter().for_each(|e| visit(e, visitor)),
        Expr::Number(_) | Expr::Text(_) | Expr::Name(_) => {}
    }
}
