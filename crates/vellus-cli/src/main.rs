//! The command `vellus`. The library does the work, so that the generator of manual pages can use its definition.

fn main() -> std::process::ExitCode {
    vellus_cli::main()
}
