//! What a package installs with the program: shell completions, manual pages.

use std::fs;

use clap::CommandFactory;

use crate::{
    args::{Cli, CompletionsArgs, ManualArgs},
    commands::output_file::put_bytes,
    failure::Failure,
};

pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "proveout", &mut script);
    put_bytes(&args.output, args.force, script)
}

/// `proveout.1`, and `proveout-COMMAND.1` for every command.
pub(crate) fn manual(args: &ManualArgs) -> Result<(), Failure> {
    fs::create_dir_all(&args.output)
        .map_err(|e| Failure::new(format!("{}: {e}", args.output.display())).with_help("name another folder"))?;
    let mut whole = Cli::command();
    whole.build();
    let pages = pages(&whole, "proveout");
    for (name, command) in &pages {
        let fault = |e: std::io::Error| Failure::new(format!("{name}.1 cannot be written: {e}"));
        let mut page = Vec::new();
        clap_mangen::Man::new(command.clone()).title(name.to_uppercase()).render(&mut page).map_err(fault)?;
        put_bytes(&args.output.join(format!("{name}.1")), args.force, page)?;
    }
    say!("{} pages in {}", pages.len(), args.output.display());
    Ok(())
}

/// A command and all below it, by the names of their pages.
fn pages(of: &clap::Command, name: &str) -> Vec<(String, clap::Command)> {
    let below = of.get_subcommands().filter(|c| c.get_name() != "help");
    let inner = below.flat_map(|c| pages(c, &format!("{name}-{}", c.get_name())));
    std::iter::once((name.to_owned(), of.clone())).chain(inner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_and_every_option_stands_in_it() {
        let mut whole = Cli::command();
        whole.build();
        let pages = pages(&whole, "proveout");
        assert!(pages.iter().any(|(name, _)| name == "proveout-sweep-plan"));
        for (name, command) in pages {
            let mut page = Vec::new();
            clap_mangen::Man::new(command.clone()).render(&mut page).expect("rendered");
            // Dashes are written as \- in the language of the pages.
            let text = String::from_utf8(page).expect("text").replace("\\-", "-");
            for option in command.get_arguments().filter_map(clap::Arg::get_long) {
                assert!(text.contains(&format!("--{option}")), "{name}: --{option}");
            }
        }
    }
}
