//! Exit codes, signals, and outputs that are closed or full.
#![cfg(target_os = "linux")]

use crate::common::{Limited, Running, command, shell, vellus, wait_until};
use std::fs::OpenOptions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};
use vellus_testing::program::Signal;

/// Checks the exit code. Returns standard error.
fn ends(output: &Output, code: i32) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

/// Commands that print to standard output. The last one also writes a file.
const PRINTING: [&[&str]; 7] = [
    &["scene"],
    &["fiber", "list"],
    &["eval"],
    &["table", "info"],
    &["--help"],
    &["--version"],
    &["plot", "lobes", "--out", "lobes.svg"],
];

#[test]
fn a_closed_pipe_is_no_error_and_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    for args in PRINTING {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = command(folder.path(), args).stdout(writer).start().unwrap().end();
        assert_eq!(ends(&output, 0), "", "{args:?}");
    }
    assert!(folder.path().join("lobes.svg").exists());
}

#[test]
fn a_full_output_is_a_condition_that_may_pass_and_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    for args in PRINTING {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let message = ends(&command(folder.path(), args).stdout(full).start().unwrap().end(), 75);
        assert!(message.contains("cannot write to standard output: No space left"), "{args:?}: {message}");
    }
    assert!(folder.path().join("lobes.svg").exists());
    let message = ends(&vellus(folder.path(), &["eval", "--out", "/dev/full"]), 75);
    assert!(message.contains("cannot write /dev/full: No space left"), "{message}");
}

#[test]
fn messages_that_nobody_can_read_do_not_change_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    for redirection in ["2>&-", "2>/dev/full", ">&- 2>&-"] {
        let run = |args: &[&str]| shell(folder.path(), &format!("exec \"$@\" {redirection}"), args).run().unwrap();
        ends(&run(&["eval", "--h", "2"]), 2);
        ends(&run(&["eval", "--nope"]), 2);
        ends(&run(&["eval", "--out", "answer.txt"]), 0);
        std::fs::remove_file(folder.path().join("answer.txt")).unwrap();
    }
}

#[test]
fn dev_stdout_is_a_name_of_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["eval", "--format", "csv"];
    let plain = vellus(folder.path(), &args).stdout;
    for name in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
        let piped = vellus(folder.path(), &[&args[..], &["--out", name]].concat());
        assert_eq!(ends(&piped, 0), "");
        assert_eq!(piped.stdout, plain, "{name}");
        // In a file, the lines are between those of other programs.
        for redirection in ["> all.txt", ">> all.txt"] {
            std::fs::remove_file(folder.path().join("all.txt")).ok();
            let script = format!("(echo before; \"$@\"; echo after) {redirection}");
            ends(&shell(folder.path(), &script, &[&args[..], &["--out", name]].concat()).run().unwrap(), 0);
            let all = std::fs::read(folder.path().join("all.txt")).unwrap();
            assert_eq!(all, [b"before\n", &plain[..], b"after\n"].concat(), "{name} {redirection}");
        }
    }
    // A name with the required extension, and a table that must not contain messages.
    std::os::unix::fs::symlink("/dev/stdout", folder.path().join("out.svg")).unwrap();
    let svg = vellus(folder.path(), &["plot", "lobes", "--out", "out.svg"]);
    assert!(svg.stdout.starts_with(b"<svg") && ends(&svg, 0).is_empty());
    let script = "\"$@\" --work pieces --out /dev/stdout | \"$1\" table info /dev/stdin";
    let args = ["table", "build", "--quality", "smoke", "--photons", "1000"];
    let info = shell(folder.path(), script, &args).run().unwrap();
    assert!(String::from_utf8_lossy(&info.stdout).contains("every factor is non-negative"));
    let message = ends(&vellus(folder.path(), &["table", "build", "--out", "/dev/null"]), 2);
    assert!(message.contains("--work"), "{message}");
}

#[test]
fn files_follow_the_umask() {
    let folder = tempfile::tempdir().unwrap();
    for (umask, mode) in [("022", 0o644), ("027", 0o640), ("077", 0o600), ("002", 0o664)] {
        for (args, file) in
            [(&["eval", "--out", "a.txt"][..], "a.txt"), (&["plot", "lobes", "--out", "a.png"], "a.png")]
        {
            ends(&shell(folder.path(), &format!("umask {umask}; exec \"$@\""), args).run().unwrap(), 0);
            let path = folder.path().join(file);
            assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, mode, "{file}, umask {umask}");
            std::fs::remove_file(path).unwrap();
        }
    }
}

#[test]
fn a_file_size_limit_is_a_condition_that_may_pass() {
    let folder = tempfile::tempdir().unwrap();
    // The limit is 8 or 16 KB. The probe fits, but the picture does not.
    let output = shell(folder.path(), "ulimit -f 16; exec \"$@\"", &["plot", "profile", "--out", "a.png"]).run();
    let message = ends(&output.unwrap(), 75);
    assert!(message.contains("cannot write a.png: File too large"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "no temporary file is left");
}

/// A build of some seconds, after one piece is finished.
fn build(folder: &Path, photons: &str) -> Running {
    let args = ["table", "build", "--quality", "smoke", "--photons", photons, "--out", "a.vellus"];
    let child = command(folder, &args).start().unwrap();
    let pieces = || std::fs::read_dir(folder.join("a.vellus.work")).map_or(0, Iterator::count);
    wait_until("a finished piece", || pieces() > 0);
    child
}

/// Without a signal, the builds would take several times longer than one piece.
#[test]
fn a_signal_ends_the_program_with_its_own_code_and_names_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    // Some senders repeat a signal at once. The repetition must not end the program before it saves its results.
    for (signal, count, code) in [
        (Signal::INT, 1, 130),
        (Signal::TERM, 1, 143),
        (Signal::HUP, 1, 129),
        (Signal::TERM, 2, 143),
        (Signal::HUP, 2, 129),
    ] {
        let child = build(folder.path(), "60000");
        for _ in 0..count {
            child.send(signal);
        }
        let message = ends(&child.end(), code);
        assert!(
            message.contains("interrupted: ") && message.contains("a.vellus.work"),
            "{count} {signal:?}: {message}"
        );
        assert!(!folder.path().join("a.vellus").exists());
        std::fs::remove_dir_all(folder.path().join("a.vellus.work")).unwrap();
    }
}

#[test]
fn a_second_signal_ends_the_program_at_once() {
    let folder = tempfile::tempdir().unwrap();
    // A piece takes many times longer than this test waits.
    let args = ["table", "build", "--quality", "shipping", "--photons", "100000000", "--out", "a.vellus"];
    let child = command(folder.path(), &args).start().unwrap();
    // Before its first piece begins, it would end at once.
    let pieces = folder.path().join("a.vellus.work");
    wait_until("the folder of pieces", || pieces.exists());
    std::thread::sleep(Duration::from_millis(1000));
    child.send(Signal::TERM);
    std::thread::sleep(Duration::from_millis(1000));
    child.send(Signal::INT);
    let sent = Instant::now();
    ends(&child.end(), 130);
    assert!(sent.elapsed() < Duration::from_secs(20), "{:?}", sent.elapsed());
}

#[test]
fn signals_that_were_ignored_stay_so() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["table", "build", "--quality", "smoke", "--photons", "5000", "--out", "a.vellus"];
    let child = shell(folder.path(), "trap '' HUP; exec \"$@\"", &args).start().unwrap();
    child.wait_until_it_catches(Signal::TERM);
    child.send(Signal::HUP);
    ends(&child.end(), 0);
    assert!(folder.path().join("a.vellus").exists());
}

/// The viewer of a small scene, after it has printed its address.
fn viewer(folder: &Path, port: &str) -> Running {
    let args = ["live", "hair-lock", "--small", "--no-open", "--port", port];
    let temporary = folder.join("temporary");
    std::fs::create_dir_all(&temporary).unwrap();
    let address = OpenOptions::new().create(true).append(true).open(folder.join("address")).unwrap();
    let child = command(folder, &args).env("TMPDIR", temporary).stdout(address).start().unwrap();
    wait_until("an address", || std::fs::read(folder.join("address")).is_ok_and(|text| text.ends_with(b"/\n")));
    child
}

#[test]
fn the_viewer_ends_with_the_code_of_its_signal_and_removes_its_files() {
    for (signal, code) in [(Signal::INT, 130), (Signal::TERM, 143), (Signal::HUP, 129)] {
        let folder = tempfile::tempdir().unwrap();
        let child = viewer(folder.path(), "0");
        let files = || std::fs::read_dir(folder.path().join("temporary")).unwrap().count();
        assert_eq!(files(), 1);
        child.send(signal);
        assert!(ends(&child.end(), code).contains("interrupted: the viewer has ended"));
        assert_eq!(files(), 0);
    }
}

#[test]
fn the_viewer_finds_a_used_port_before_it_opens_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let _first = viewer(folder.path(), "0");
    let address = std::fs::read_to_string(folder.path().join("address")).unwrap();
    let port = address.trim().trim_end_matches('/').rsplit(':').next().unwrap();
    let message = ends(&vellus(folder.path(), &["live", "no such scene", "--no-open", "--port", port]), 2);
    assert!(message.contains("cannot listen on 127.0.0.1"), "{message}");
}

#[test]
fn the_viewer_needs_no_reader_of_its_address_but_room_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["live", "hair-lock", "--small", "--no-open", "--port", "0"];
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let message = ends(&command(folder.path(), &args).stdout(full).start().unwrap().end(), 75);
    assert!(message.contains("cannot write to standard output: No space left"), "{message}");
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut child = command(folder.path(), &args).stdout(writer).start().unwrap();
    assert!(child.ended_within(Duration::from_secs(3)).is_none());
    child.send(Signal::INT);
    ends(&child.end(), 130);
}
