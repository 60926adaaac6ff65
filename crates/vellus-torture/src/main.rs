//! Attacks the command `vellus` the way a hostile user does, and says what it did wrong: `cargo xtask torture`.

#[cfg(unix)]
mod attacks;
#[cfg(unix)]
mod child;
#[cfg(unix)]
mod dice;
#[cfg(unix)]
mod material;
#[cfg(unix)]
mod mutate;
#[cfg(unix)]
mod picture;
#[cfg(unix)]
mod session;
#[cfg(unix)]
mod trial;

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    session::main()
}

#[cfg(not(unix))]
fn main() {
    eprintln!("signals and limits of processes are those of Unix: nothing is tried here");
}
