use std::io;

use proveout_machine::{Direction, Machine, kinematics_csv};

use crate::{args::KinematicsArgs, failure::Failure};

/// Converts joint positions and tool poses, CSV from standard input to standard output.
pub(crate) fn kinematics(args: &KinematicsArgs) -> Result<(), Failure> {
    let machine = Machine::read(&args.machine).map_err(|e| Failure::from(&proveout_sim::SimError::from(e)))?;
    let direction = if args.forward { Direction::Forward } else { Direction::Inverse { nearest: args.nearest } };
    let (input, output) = (io::stdin().lock(), io::stdout().lock());
    kinematics_csv(&machine, input, io::BufWriter::new(output), direction, args.tool_length_mm)
        .map_err(|e| Failure::new(e).with_help("the columns are described by `proveout kinematics --help`"))?;
    Ok(())
}
