//! The page in a real browser: `browser/live.mjs` uses every control. Without node, playwright-core or Chromium the
//! test is skipped.

use std::process::Command;
use vellus_live::{Engine, Options, Server};

#[test]
#[ignore = "slow: a browser"]
fn every_control_works_in_chromium() {
    let chromium = std::env::var("CHROMIUM").unwrap_or_else(|_| "/usr/bin/chromium".to_owned());
    let has_module = || {
        let found = Command::new("node").args(["-e", "require('playwright-core')"]).output();
        found.is_ok_and(|output| output.status.success())
    };
    if !std::path::Path::new(&chromium).exists() || !has_module() {
        println!("skipped: node, playwright-core (NODE_PATH) or {chromium} is missing");
        return;
    }
    let scene = std::env::var("VELLUS_LIVE_SCENE").unwrap_or_else(|_| "cat".to_owned());
    let small = std::env::var_os("VELLUS_LIVE_SCENE").is_none();
    let server = Server::start(Engine::open(scene, small, None).unwrap(), &Options::default()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/browser/live.mjs");
    let mut command = Command::new("node");
    command.args([script, &server.url()]).args(std::env::var_os("VELLUS_LIVE_SHOTS"));
    assert!(command.status().unwrap().success());
}
