//! Attacks the command `vellus` like a hostile user and reports its failures: `cargo xtask torture`.

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
    eprintln!("the attacks need Unix signals and process limits: no attack runs here");
}
