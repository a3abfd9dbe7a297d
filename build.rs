//! Tells the program its version, in a release with the commit it is built from. Other builds would
//! all be made anew after each commit.

use std::process::Command;

/// What git says, if this is a checkout.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let version = env!("CARGO_PKG_VERSION");
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = || {
        let commits = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
        for place in [&commits, "src", "Cargo.toml"] {
            println!("cargo::rerun-if-changed={place}");
        }
        git(&["describe", "--always", "--dirty", "--exclude=*"])
    };
    let commit = is_release.then(commit).flatten();
    let version = commit.map_or(version.to_owned(), |commit| format!("{version} ({commit})"));
    println!("cargo::rustc-env=TACKSCOPE_VERSION={version}");
}
