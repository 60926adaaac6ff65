//! The page in a real browser. The scripts are in `browser/`. `NODE_PATH` names the folder with playwright-core.

use std::process::Command;
use std::time::Duration;
use vellus_live::{Engine, Options, Server};
use vellus_testing::program::Limited;
use vellus_testing::{need, succeeds};

/// Twice what the longest script takes.
const LONGEST: Duration = Duration::from_secs(1200);

/// Runs a script against a server with a scene. `VELLUS_LIVE_SCENE` replaces the scene, in its full version.
/// `VELLUS_LIVE_SHOTS` is a folder for screenshots.
fn run(script: &str, scene: &str) {
    let chromium = std::env::var("CHROMIUM").unwrap_or_else(|_| "/usr/bin/chromium".to_owned());
    let there = std::path::Path::new(&chromium).exists().then_some(()).ok_or(format!("no {chromium}"));
    let module = || succeeds(Command::new("node").args(["-e", "require('playwright-core')"]));
    if need("browser", there.and_then(|()| module())).is_none() {
        return;
    }
    let chosen = std::env::var("VELLUS_LIVE_SCENE");
    let small = chosen.is_err();
    let engine = Engine::open(chosen.as_deref().unwrap_or(scene), small, None).unwrap();
    let server = Server::start(engine, &Options::default()).unwrap();
    let mut command = Command::new("node");
    command.arg(format!("{}/tests/browser/{script}", env!("CARGO_MANIFEST_DIR"))).arg(server.url());
    // The memory of this process is that of the server.
    command.env("VELLUS_LIVE_PID", std::process::id().to_string());
    command.args(std::env::var_os("VELLUS_LIVE_SHOTS"));
    assert!(command.start().unwrap().end_within(LONGEST).status.success());
}

#[test]
#[ignore = "full: a browser, which `cargo xtask test` does not install"]
fn every_control_works_in_chromium() {
    run("live.mjs", "cat");
}

#[test]
#[ignore = "full: a browser, which `cargo xtask test` does not install"]
fn the_panel_keeps_what_is_typed_at_any_width() {
    run("panel.mjs", "hair-lock");
}

#[test]
#[ignore = "full: a browser, which `cargo xtask test` does not install"]
fn the_page_survives_losses_garbage_and_other_pages() {
    run("robust.mjs", "hair-lock");
}

#[test]
#[ignore = "full: ten minutes of random dragging"]
fn random_dragging_needs_no_more_memory() {
    run("dragging.mjs", "cat");
}
