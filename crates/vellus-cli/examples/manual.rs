//! Writes the manual pages and the shell completions of `vellus`.
//!
//! usage: manual FOLDER, the folder `share` of a prefix such as /usr/local

use clap_complete::Shell;
use std::fs::{File, create_dir_all};
use std::path::Path;

/// Where each shell looks for completions. Those of elvish and PowerShell are read from a script of the user.
const COMPLETIONS: [(Shell, &str); 5] = [
    (Shell::Bash, "bash-completion/completions/vellus"),
    (Shell::Elvish, "elvish/lib/vellus.elv"),
    (Shell::Fish, "fish/vendor_completions.d/vellus.fish"),
    (Shell::PowerShell, "powershell/vellus.ps1"),
    (Shell::Zsh, "zsh/site-functions/_vellus"),
];

fn main() -> std::io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1) else {
        eprintln!("usage: manual FOLDER");
        std::process::exit(2);
    };
    let mut command = vellus_cli::command();
    for (shell, name) in COMPLETIONS {
        let path = Path::new(&folder).join(name);
        create_dir_all(path.parent().unwrap_or(&path))?;
        clap_complete::generate(shell, &mut command, "vellus", &mut File::create(path)?);
    }
    let man = Path::new(&folder).join("man/man1");
    create_dir_all(&man)?;
    clap_mangen::generate_to(without_help(vellus_cli::command()), man)
}

/// Without the subcommands `help`, which would have pages about nothing.
fn without_help(command: clap::Command) -> clap::Command {
    command.disable_help_subcommand(true).mut_subcommands(without_help)
}
