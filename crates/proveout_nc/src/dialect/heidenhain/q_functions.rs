//! Words of FN functions and conditional jumps.

use super::expr::Expr;
use super::lexer::{Lexer, refused};
use super::statements::label;
use super::words::{Condition, Relation, Statement, Value};
use crate::channel::expression::{Function, Operator};
use crate::diagnostic::Fault;

/// Value of a term of FN 0 to FN 13.
fn term(x: &mut Lexer<'_>, start: usize) -> Result<Value, Fault> {
    x.need(start)
}

fn as_expr(value: Value) -> Expr {
    match value {
        Value::Number(number) => Expr::Number(number),
        Value::Param { negative: false, param } => Expr::Param(param),
        Value::Param { negative: true, param } => Expr::Unary(Function::Negate, Box::new(Expr::Param(param))),
    }
}

/// What function `FN 0` to `FN 13` or `D00` to `D13` computes from its terms; none for others.
pub(crate) fn arithmetic(number: u32, first: Value, second: Option<Value>) -> Option<Expr> {
    let one = |function| Some(Expr::Unary(function, Box::new(as_expr(first))));
    let two = |operator| Some(Expr::pair(operator, as_expr(first), as_expr(second?)));
    match number {
        0 => Some(as_expr(first)),
        1 => two(Operator::Add),
        2 => two(Operator::Subtract),
        3 => two(Operator::Multiply),
        4 => two(Operator::Divide),
        5 => one(Function::Sqrt),
        6 => one(Function::Sin),
        7 => one(Function::Cos),
        8 => two(Operator::Length),
        13 => two(Operator::Angle),
        _ => None,
    }
}

pub(crate) fn function(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    x.blanks();
    let Some(number) = x.s.integer() else { return Err(x.unexpected()) };
    x.blanks();
    x.s.take(b':');
    match number {
        0..=8 | 13 => {
            let Some(target) = x.param()? else { return Err(x.unexpected()) };
            x.blanks();
            if !x.s.take(b'=') {
                return Err(x.unexpected());
            }
            match number {
                5 => x.prefix("SQRT"),
                6 => x.prefix("SIN"),
                7 => x.prefix("COS"),
                _ => false,
            };
            let first = term(x, start)?;
            let second = if matches!(number, 1..=4 | 8 | 13) {
                let sign = ["+", "-", "*", "DIV", "", "", "", "LEN", "", "", "", "", "ANG"];
                let word = sign.get(number as usize - 1).copied().unwrap_or_default();
                if !(x.prefix(word) || number == 4 && x.prefix("/")) {
                    return Err(x.unexpected());
                }
                Some(term(x, start)?)
            } else {
                None
            };
            x.finish()?;
            arithmetic(number, first, second).map(|e| Statement::Assign(target, e)).ok_or_else(|| x.unexpected())
        }
        9..=12 => {
            if !x.word("IF") {
                return Err(x.unexpected());
            }
            branch(x, start)
        }
        14 => {
            x.word("ERROR");
            x.blanks();
            x.s.take(b'=');
            Ok(Statement::Error(x.need(start)?))
        }
        23 => {
            let Some(target) = x.param()? else { return Err(x.unexpected()) };
            x.blanks();
            x.s.take(b'=');
            x.word("CDATA");
            let Some(from) = x.param()? else { return Err(x.unexpected()) };
            x.finish()?;
            Ok(Statement::CircleData(target, from))
        }
        18 => {
            x.word("SYSREAD");
            let Some(target) = x.param()? else { return Err(x.unexpected()) };
            x.blanks();
            if !x.s.take(b'=') {
                return Err(x.unexpected());
            }
            let mut from = [None; 3];
            for (slot, word) in from.iter_mut().zip(["ID", "NR", "IDX"]) {
                if x.prefix(word) {
                    *slot = Some(term(x, start)?);
                }
            }
            if from[0].is_none() {
                return Err(x.unexpected());
            }
            x.finish()?;
            Ok(Statement::SystemRead(target, from))
        }
        15 | 16 | 19 | 20 | 29 | 37 | 38 => Ok(Statement::Note(format!("FN {number}: {}", x.rest()))),
        _ => {
            x.rest();
            let remedy = match number {
                17 | 25 => "change the datum with CYCL DEF 7 or CYCL DEF 247",
                26..=28 => "tables of the control are not known: assign the values to Q parameters",
                _ => "assign the result to the Q parameter",
            };
            Err(refused(&format!("FN {number}"), x.span_from(start), remedy))
        }
    }
}

pub(crate) fn branch(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    let left = term(x, start)?;
    let condition = if x.word("IS") {
        let defined = if x.word("DEFINED") {
            true
        } else if x.word("UNDEFINED") {
            false
        } else {
            return Err(x.unexpected());
        };
        let Value::Param { param, .. } = left else { return Err(x.unexpected()) };
        Condition::Defined(param, defined)
    } else {
        let mut relation = None;
        for (word, found) in
            [("EQU", Relation::Equal), ("NE", Relation::NotEqual), ("GT", Relation::Greater), ("LT", Relation::Less)]
        {
            if x.prefix(word) {
                relation = Some(found);
                break;
            }
        }
        let Some(relation) = relation else { return Err(x.unexpected()) };
        Condition::Compare(left, relation, term(x, start)?)
    };
    if !x.word("GOTO") || !x.prefix("LBL") {
        return Err(x.unexpected());
    }
    let target = label(x, start)?;
    x.finish()?;
    Ok(Statement::Branch(condition, target))
}
