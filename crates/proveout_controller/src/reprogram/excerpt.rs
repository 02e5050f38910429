//! The part of a program that the control is asked about when one run is planned: the run with the
//! blocks that lead to it and away from it.
//!
//! Running the whole program for each trial schedule of each row would take time that grows with
//! the square of the rows. The times of a row depend only on the blocks near it, as far as the
//! control looks ahead and back from there:
//!
//! ```text
//!   head of program | ... | last blocks before, rapids, THE RUN, rapids, first after | ... | end of program
//!        kept        left                           kept                              left       kept
//! ```
//!
//! Commands that are not motions are kept everywhere, so that feeds, frames, tools and modes are in
//! force as they were. If the control refuses the excerpt, it is asked about the whole program.

use proveout_nc::{Command, Op};

/// Motions of neighboring runs that stay on either side: the ends of the rapids between are entered and left
/// as in the whole program. Fewer than the blocks of the shortest run, so that none of them is taken for it.
const BESIDE: usize = 4;

/// Whether a command moves the machine along a way that leads to the next one.
fn moves(command: &Command) -> bool {
    matches!(
        command.op,
        Op::Rapid(_) | Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_) | Op::Thread(_) | Op::Retract(_)
    )
}

/// The commands of an excerpt about a run from its first to its last command; none where that is nearly the
/// whole program.
pub(super) fn excerpt(commands: &[Command], [first, last]: [usize; 2]) -> Option<Vec<bool>> {
    let cuts = |c: &Command| moves(c) && !matches!(c.op, Op::Rapid(_));
    let head = commands.iter().position(cuts)?;
    let tail = commands.iter().rposition(cuts)? + 1;
    let rapid = |i: &usize| commands.get(*i).is_some_and(|c| matches!(c.op, Op::Rapid(_)));
    let mut keep: Vec<bool> = commands
        .iter()
        .enumerate()
        .map(|(i, c)| !moves(c) || i < head || i >= tail || (first..=last).contains(&i))
        .collect();
    let beside = |way: &mut dyn Iterator<Item = usize>, keep: &mut [bool]| {
        let mut left = BESIDE;
        for i in way.filter(|i| commands.get(*i).is_some_and(moves)) {
            if left == 0 {
                break;
            }
            // All rapids next to the run, then a few blocks.
            left -= usize::from(left < BESIDE || !rapid(&i));
            keep[i] = true;
        }
    };
    beside(&mut (0..first).rev(), &mut keep);
    beside(&mut (last + 1..commands.len()), &mut keep);
    let kept = keep.iter().filter(|k| **k).count();
    (10 * kept < 9 * commands.len()).then_some(keep)
}

#[cfg(test)]
mod tests {
    use proveout_nc::{Feed, Location, Motion};

    use super::*;

    fn command(op: Op) -> Command {
        Command { op, location: Location { file: "a.mpf".into(), line: 1, column: 1, length: 1, depth: 0 } }
    }

    fn motion() -> Motion {
        Motion::default()
    }

    #[test]
    fn a_row_is_asked_with_its_rapids_and_few_blocks_of_its_neighbors() {
        let mut commands = vec![command(Op::Rapid(motion()))];
        let mut rows = Vec::new();
        for _ in 0..5 {
            let start = commands.len();
            commands.extend((0..20).map(|_| command(Op::Linear(motion()))));
            rows.push([start, commands.len() - 1]);
            commands.push(command(Op::Feed(Feed::InverseTime(1.0))));
            commands.extend((0..3).map(|_| command(Op::Rapid(motion()))));
        }
        let keep = excerpt(&commands, rows[2]).expect("much is left out");
        let kept = |range: std::ops::Range<usize>| keep[range].iter().filter(|k| **k).count();
        assert_eq!(kept(rows[2][0]..rows[2][1] + 1), 20);
        assert_eq!([kept(rows[1][0]..rows[1][1] + 1), kept(rows[3][0]..rows[3][1] + 1)], [BESIDE; 2]);
        assert_eq!(kept(rows[1][1] + 1..rows[2][0]), 4, "all rapids between, and the feed");
        assert_eq!([kept(rows[0][0]..rows[0][1] + 1), kept(rows[4][0]..rows[4][1] + 1)], [0; 2]);
        assert!(keep[0] && keep[keep.len() - 1], "head and end stay");
        assert!(keep.iter().zip(&commands).all(|(k, c)| *k || moves(c)), "what is no motion stays");
        assert!(excerpt(&commands[..rows[0][1] + 1], rows[0]).is_none(), "one run is the whole program");
    }
}
