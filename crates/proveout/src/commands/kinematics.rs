use std::{
    fs::File,
    io::{self, BufReader, BufWriter, Read},
};

use proveout_machine::{Direction, Machine, kinematics_csv};

use crate::{
    args::KinematicsArgs,
    commands::output_file::{check, put_bytes},
    failure::Failure,
};

/// Converts joint positions and tool poses, CSV to CSV.
pub(crate) fn kinematics(args: &KinematicsArgs) -> Result<(), Failure> {
    let length = args.tool_length_mm;
    if !(length >= 0.0 && length.is_finite()) {
        return Err(Failure::new(format!("--tool-length-mm {length} is not a valid length"))
            .with_help("give the distance from the tip to the gauge line, mm, zero or more"));
    }
    let machine = Machine::read(&args.machine).map_err(|e| Failure::from(&proveout_sim::SimError::from(e)))?;
    let direction = if args.forward { Direction::Forward } else { Direction::Inverse { nearest: args.nearest } };
    let input: Box<dyn Read> = match &args.input {
        None => Box::new(io::stdin().lock()),
        Some(file) => {
            let open = File::open(file).map_err(|e| {
                Failure::new(format!("{} cannot be read: {e}", file.display())).with_help("check the path")
            })?;
            Box::new(BufReader::new(open))
        }
    };
    let from = args.input.as_ref().map_or_else(|| "standard input".to_owned(), |f| f.display().to_string());
    let wrong =
        |e| Failure::new(format!("{from}: {e}")).with_help("`proveout kinematics --help` describes the columns");
    let Some(file) = &args.output else {
        let output = BufWriter::new(io::stdout().lock());
        return kinematics_csv(&machine, input, output, direction, length).map(|_| ()).map_err(wrong);
    };
    check(file, args.force)?;
    // A file is written when the whole table is good.
    let mut table = Vec::new();
    kinematics_csv(&machine, input, &mut table, direction, length).map_err(wrong)?;
    put_bytes(file, args.force, &table)
}
