//! The walls of the house: which room may name what. Read from the sources, so that a wall cannot
//! fall unnoticed.

use crate::binary::content;
use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The rooms and their floors; an arrow may point down or sideways, never up.
const ROOMS: [(&str, u8); 13] = [
    ("numerics", 0),
    ("physics", 1),
    ("solver", 2),
    ("scene", 2),
    ("follow", 3),
    ("study", 4),
    ("plot", 5),
    ("paper", 6),
    ("lessons", 6),
    ("worker", 7),
    ("storage", 7),
    ("ui", 8),
    ("cli", 8),
];

/// Neighbours on one floor that must not know each other: `worker` and `paper` touch no files, the
/// window does not call the shell.
const NEIGHBOURS: [(&str, &str); 5] = [
    ("worker", "storage"),
    ("paper", "storage"),
    ("paper", "worker"),
    ("ui", "cli"),
    ("lessons", "paper"),
];

/// Paths (by their first segments) that only one room may name.
const OWNED: [(&[&str], &str); 12] = [
    (&["egui"], "ui"),
    (&["eframe"], "ui"),
    (&["egui_plot"], "ui"),
    (&["rfd"], "ui"),
    (&["std", "thread"], "worker"),
    (&["std", "sync", "mpsc"], "worker"),
    (&["crossbeam_channel"], "worker"),
    (&["std", "fs"], "storage"),
    (&["fs"], "storage"),
    (&["File"], "storage"),
    (&["OpenOptions"], "storage"),
    (&["tempfile"], "storage"),
];

/// The door through which the rooms below share work among threads.
const DOOR: (&str, &[&str]) = ("numerics/threads.rs", &["std", "sync", "mpsc"]);

/// Rooms that must not read a clock, and the names of clocks.
const TIMELESS: [&str; 3] = ["numerics", "physics", "solver"];
const CLOCKS: [&str; 3] = ["Instant", "SystemTime", "cpu_time"];

/// A file holds one idea and all of it.
const LINES_MAX: usize = 600;

/// How far apart (in lines) two `cfg`s may be and still be one place: both arms of one choice.
const ONE_PLACE: usize = 12;

/// The room of a file given relative to src; `None` for lib.rs and main.rs.
fn room(path: &str) -> Option<&str> {
    let first = path.split(['/', '.']).next()?;
    (path.contains('/') || !["lib", "main"].contains(&first)).then_some(first)
}

fn floor(room: &str) -> Option<u8> {
    ROOMS
        .iter()
        .find(|(name, _)| *name == room)
        .map(|(_, floor)| *floor)
}

/// The words and signs of the code, brackets among them, with `::`, `->` and `=>` as one sign each;
/// comments and literals left out.
fn tokens(code: &str) -> Vec<String> {
    let stream = code.parse::<TokenStream>();
    let stream = stream.unwrap_or_else(|why| panic!("{why}: {code}"));
    let mut list = Vec::new();
    flatten(stream, &mut list);
    list
}

/// Signs of two characters that are one.
const PAIRS: [&str; 3] = ["::", "->", "=>"];

fn flatten(stream: TokenStream, list: &mut Vec<String>) {
    let mut joined = false;
    for tree in stream {
        match tree {
            TokenTree::Group(group) => {
                let [open, close] = match group.delimiter() {
                    Delimiter::Brace => ["{", "}"],
                    Delimiter::Bracket => ["[", "]"],
                    _ => ["(", ")"],
                };
                list.push(open.to_owned());
                flatten(group.stream(), list);
                list.push(close.to_owned());
            }
            TokenTree::Punct(sign) => {
                match list.last_mut().filter(|_| joined) {
                    Some(last) if PAIRS.contains(&format!("{last}{sign}").as_str()) => {
                        last.push(sign.as_char());
                    }
                    _ => list.push(sign.to_string()),
                }
                joined = sign.spacing() == Spacing::Joint;
                continue;
            }
            TokenTree::Ident(word) => list.push(word.to_string()),
            TokenTree::Literal(_) => {}
        }
        joined = false;
    }
}

/// Every path of the code, with the groups of `use a::{b, c::d}` written out.
fn paths(tokens: &[String]) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        if is_word(&tokens[i]) {
            i = path(tokens, i, &[], &mut found);
        } else {
            i += 1;
        }
    }
    found
}

fn is_word(token: &str) -> bool {
    token.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// Reads one path at `i` below `stem`, adds it (or its group) to `found`, and returns where it
/// ends.
fn path(tokens: &[String], mut i: usize, stem: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let mut here = stem.to_vec();
    loop {
        here.push(tokens[i].clone());
        i += 1;
        let next = |k: usize| tokens.get(i + k).map_or("", String::as_str);
        if next(0) != "::" {
            found.push(here);
            return i;
        }
        if next(1) == "{" {
            i += 2;
            while i < tokens.len() && tokens[i] != "}" {
                if is_word(&tokens[i]) {
                    i = path(tokens, i, &here, found);
                } else {
                    i += 1;
                }
            }
            return i + 1;
        }
        if next(1).is_empty() || !is_word(next(1)) {
            found.push(here);
            return i + 1;
        }
        i += 1;
    }
}

/// The path as seen from the crate's root, where it starts at `crate`, `tackscope` or enough
/// `super`s for this file.
fn from_root<'a>(path: &str, segments: &'a [String]) -> Option<&'a [String]> {
    let head = segments[0].as_str();
    if head == "crate" || head == "tackscope" {
        return Some(&segments[1..]);
    }
    let supers = segments.iter().take_while(|s| *s == "super").count();
    let depth = path.split('/').filter(|part| *part != "mod.rs").count();
    (supers > 0 && supers >= depth).then_some(&segments[supers..])
}

/// What is wrong with one source file; `path` is relative to src, as in `physics/law/mod.rs`.
fn faults(path: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let room = room(path);
    if let Some(room) = room
        && floor(room).is_none()
    {
        faults.push(format!("{path}: the room {room} has no floor"));
    }
    let lines = text.lines().count();
    if lines > LINES_MAX {
        faults.push(format!("{path}: {lines} lines, at most {LINES_MAX}"));
    }
    let tokens = tokens(text);
    if tokens.iter().any(|token| token == "unsafe") {
        faults.push(format!("{path}: unsafe"));
    }
    for segments in paths(&tokens) {
        let name = segments.join("::");
        if let (Some(room), Some([other, ..])) = (room, from_root(path, &segments)) {
            let above =
                floor(other).is_some_and(|other| floor(room).is_some_and(|own| other > own));
            if above || NEIGHBOURS.contains(&(room, other)) {
                faults.push(format!("{path}: {room} names {name}"));
            }
        }
        for (owned, owner) in OWNED {
            let starts =
                segments.len() >= owned.len() && segments.iter().zip(owned).all(|(a, b)| a == b);
            // A lone word may be a local name; as the head of a longer path it is the crate, module
            // or type.
            let is_door = (path, owned) == DOOR;
            if starts && segments.len() > 1 && room != Some(owner) && !is_door {
                faults.push(format!("{path}: only {owner} names {name}"));
            }
        }
        if room.is_some_and(|room| TIMELESS.contains(&room))
            && segments.iter().any(|s| CLOCKS.contains(&s.as_str()))
        {
            faults.push(format!("{path}: {name} is a clock"));
        }
    }
    faults.extend(feature_faults(path, text));
    faults
}

/// `feature = "..."` may name `gui` only, in lib.rs and in cli.
fn feature_faults(path: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let uses = features(text);
    for (line, value) in &uses {
        if value != "gui" {
            faults.push(format!(
                "{path}:{line}: the feature {value}; there is only gui"
            ));
        }
        if path != "lib.rs" && room(path) != Some("cli") {
            faults.push(format!("{path}:{line}: a feature outside lib.rs and cli"));
        }
    }
    if let (true, Some(first), Some(last)) = (path != "lib.rs", uses.first(), uses.last())
        && last.0 - first.0 > ONE_PLACE
    {
        faults.push(format!(
            "{path}: features at lines {} and {}, more than one place",
            first.0, last.0
        ));
    }
    faults
}

/// Line (from 1) and value of every `feature = "value"` outside of comments.
fn features(text: &str) -> Vec<(usize, String)> {
    let numbered = (1..).zip(
        text.lines()
            .map(|line| line.split("//").next().unwrap_or("")),
    );
    let each = numbered.flat_map(|(number, line)| {
        let found = line.split("feature").skip(1).filter_map(|rest| {
            let value = rest.trim_start().strip_prefix('=')?.split('"').nth(1)?;
            Some(value.to_owned())
        });
        found.map(move |value| (number, value))
    });
    each.collect()
}

fn sources() -> Vec<(String, String)> {
    files_under("src")
}

/// Every Rust file under a folder of the package, relative to it.
pub fn files_under(folder: &str) -> Vec<(String, String)> {
    let root = Path::new(folder);
    let mut open: Vec<PathBuf> = vec![root.to_owned()];
    let mut files = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(
                fs::read_dir(&path)
                    .unwrap()
                    .map(|entry| entry.unwrap().path()),
            );
        } else if path.extension().is_some_and(|e| e == "rs") {
            let name = path.strip_prefix(root).unwrap().to_str().unwrap();
            files.push((name.replace('\\', "/"), content(&path)));
        }
    }
    files
}

/// A file right under its room, together with the folder of the same name: `follow/walk` for
/// `follow/walk/advance.rs`. None for the room's own mod.rs, which only lists and re-exports.
fn unit(module: &[&str]) -> Option<String> {
    (module.len() > 1).then(|| module[..2].join("/"))
}

/// Which units each unit names, tests aside.
fn arrows(files: &[(String, String)]) -> BTreeMap<String, BTreeSet<String>> {
    let modules = |path: &str| -> Vec<String> {
        path.trim_end_matches(".rs")
            .split('/')
            .filter(|part| *part != "mod")
            .map(str::to_owned)
            .collect()
    };
    let known: BTreeSet<String> = files
        .iter()
        .filter_map(|(path, _)| unit(&modules(path).iter().map(String::as_str).collect::<Vec<_>>()))
        .collect();
    let mut arrows: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in files {
        let module = modules(path);
        let here: Vec<&str> = module.iter().map(String::as_str).collect();
        let Some(from) = unit(&here) else { continue };
        let tokens = tokens(text);
        let test = ["#", "[", "cfg", "(", "test", ")", "]"];
        let end = tokens.windows(test.len()).position(|them| them == test);
        for segments in paths(&tokens[..end.unwrap_or(tokens.len())]) {
            let supers = segments.iter().take_while(|s| *s == "super").count();
            let stem = match segments[0].as_str() {
                "crate" => &here[..0],
                "super" if supers <= here.len() => &here[..here.len() - supers],
                _ => continue,
            };
            let named: Vec<&str> = stem
                .iter()
                .copied()
                .chain(segments[supers.max(1)..].iter().map(String::as_str))
                .collect();
            if let Some(to) = unit(&named).filter(|to| known.contains(to) && *to != from) {
                arrows.entry(from.clone()).or_default().insert(to);
            }
        }
    }
    arrows
}

/// Units that can be reached from themselves.
fn circles(arrows: &BTreeMap<String, BTreeSet<String>>) -> Vec<String> {
    let reaches_itself = |start: &String| {
        let mut open: Vec<&String> = arrows[start].iter().collect();
        let mut seen = BTreeSet::new();
        while let Some(unit) = open.pop() {
            if seen.insert(unit) {
                open.extend(arrows.get(unit).into_iter().flatten());
            }
        }
        seen.contains(start)
    };
    arrows
        .keys()
        .filter(|start| reaches_itself(start))
        .cloned()
        .collect()
}

#[test]
fn no_files_depend_on_each_other_in_a_circle() {
    let arrows = arrows(&sources());
    assert!(
        arrows.values().map(BTreeSet::len).sum::<usize>() > 300,
        "the arrows were not found"
    );
    assert!(
        arrows["follow/walk"].contains("solver/method")
            && arrows["ui/files"].contains("ui/loop_plot")
    );
    assert_eq!(circles(&arrows), Vec::<String>::new());
}

#[test]
fn a_circle_of_files_is_found() {
    let file = |path: &str, text: &str| (path.to_owned(), text.to_owned());
    let files = [
        file("a/one.rs", "use super::two::f;"),
        file("a/two/deep.rs", "use super::super::three::{g, h};"),
        file("a/two.rs", "mod deep;"),
        file("a/three.rs", "fn f() { crate::a::one::f() }"),
        file(
            "a/four.rs",
            "use super::one::f;\n#[cfg(test)]\nuse super::five::f;",
        ),
        file("a/five.rs", "use super::four::f;"),
        file("a/mod.rs", "pub use one::f;"),
    ];
    assert_eq!(circles(&arrows(&files)), ["a/one", "a/three", "a/two"]);
}

#[test]
fn no_source_file_breaks_a_wall() {
    let files = sources();
    assert!(
        files.len() > 20 && files.iter().any(|(path, _)| path == "physics/law/mod.rs"),
        "the sources were not found"
    );
    let faults: Vec<String> = files
        .iter()
        .flat_map(|(path, text)| faults(path, text))
        .collect();
    assert!(
        faults.is_empty(),
        "{} faults:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

/// They are compiled without the window too, where these crates need not be.
#[test]
fn only_tests_of_the_window_name_its_crates() {
    let crates = [
        "eframe",
        "egui",
        "egui_kittest",
        "egui_plot",
        "rfd",
        "ron",
        "winit",
    ];
    for (path, text) in files_under("tests") {
        let tokens = tokens(&text);
        let whole = "#![cfg(feature = \"gui\")]";
        let of_the_window = path.starts_with("window/") || text.contains(whole);
        let named = crates
            .iter()
            .find(|name| tokens.iter().any(|token| token == *name));
        assert!(of_the_window || named.is_none(), "{path}: {named:?}");
    }
}

/// What is shown as code is formulas: `cargo test` runs none of it (`doctest` in Cargo.toml).
#[test]
fn no_documentation_shows_code_that_would_have_to_be_run() {
    for (path, text) in sources() {
        let lines = text.lines().map(str::trim_start);
        let fences = lines.filter_map(|line| {
            line.split("//")
                .nth(1)?
                .get(1..)?
                .trim()
                .strip_prefix("```")
        });
        for (i, word) in fences.enumerate() {
            assert_eq!(word, if i % 2 == 0 { "text" } else { "" }, "{path}");
        }
    }
}

/// The inside of the first brackets `open` that follow each `word`, with the name after it, unless a
/// `;` comes first: the fields of structs, the arguments of functions.
fn insides<'a>(
    tokens: &'a [String],
    word: &str,
    [open, close]: [&str; 2],
) -> Vec<(&'a str, &'a [String])> {
    let of = |at: usize| {
        let rest = &tokens[at + 1..];
        let start = rest
            .iter()
            .position(|token| token == open || token == ";")?;
        let inside = (rest[start] == open).then(|| &rest[start + 1..])?;
        let mut depth = 1;
        let end = inside.iter().position(|token| {
            depth += i32::from(token == open) - i32::from(token == close);
            depth == 0
        });
        Some((rest[0].as_str(), &inside[..end?]))
    };
    let words = (0..tokens.len()).filter(|at| tokens[*at] == word);
    words.filter_map(of).collect()
}

/// Parts of a list that commas outside all brackets separate.
fn parts(list: &[String]) -> usize {
    let (mut depth, mut parts, mut blank) = (0, 0, true);
    for token in list {
        depth += i32::from(["(", "[", "{", "<"].contains(&token.as_str()));
        depth -= i32::from([")", "]", "}", ">"].contains(&token.as_str()));
        let comma = token == "," && depth == 0;
        parts += usize::from(comma && !blank);
        blank = comma;
    }
    parts + usize::from(!blank)
}

/// Fields of a struct, and bool arguments of all functions together: their number may only fall.
const FIELDS_MAX: usize = 20;
const BOOLS_MAX: usize = 12;

#[test]
fn structs_stay_small_and_bool_arguments_few() {
    let mut bools = Vec::new();
    for (path, text) in sources() {
        let tokens = tokens(&text);
        for (name, fields) in insides(&tokens, "struct", ["{", "}"]) {
            let count = parts(fields);
            assert!(count <= FIELDS_MAX, "{path}: {name} has {count} fields");
        }
        for (name, arguments) in insides(&tokens, "fn", ["(", ")"]) {
            let bool = |pair: &&[String]| pair[0] == ":" && pair[1] == "bool";
            let count = arguments.windows(2).filter(bool).count();
            bools.extend(std::iter::repeat_n(format!("{path}: {name}"), count));
        }
    }
    assert!(
        bools.len() < BOOLS_MAX,
        "{} bool arguments:\n{}",
        bools.len(),
        bools.join("\n")
    );
}

#[test]
fn fields_and_arguments_are_counted_outside_of_brackets() {
    let tokens = tokens(
        "struct A<T> { x: Vec<(f64, T)>, y: [u8; 2] } fn f(a: bool, g: fn(u8, u8) -> u8,) {} \
         struct B; fn g() {}",
    );
    let [a] = insides(&tokens, "struct", ["{", "}"])[..] else {
        panic!("one struct with fields: {tokens:?}");
    };
    assert_eq!((a.0, parts(a.1)), ("A", 2));
    let functions = insides(&tokens, "fn", ["(", ")"]);
    let count = |i: usize| (functions[i].0, parts(functions[i].1));
    assert_eq!([count(0), count(2)], [("f", 2), ("g", 0)]);
}

#[test]
fn the_gui_feature_is_asked_about_at_one_place_of_cli() {
    let files: Vec<String> = sources()
        .into_iter()
        .filter(|(path, text)| path != "lib.rs" && !features(text).is_empty())
        .map(|f| f.0)
        .collect();
    assert!(files.len() <= 1, "{files:?}");
}

/// Files by path and text, and what is wrong with each.
const BAD: [(&str, &str, &str); 27] = [
    (
        "physics/law/mod.rs",
        "use crate::solver::Stop;",
        "physics names crate::solver::Stop",
    ),
    (
        "physics/law/mod.rs",
        "use crate::{physics::body, ui::App};",
        "physics names crate::ui::App",
    ),
    (
        "physics/grid.rs",
        "fn f() { super::super::ui::open() }",
        "physics names super::super::ui::open",
    ),
    (
        "physics/mod.rs",
        "use super::follow;",
        "physics names super::follow",
    ),
    (
        "solver/mod.rs",
        "fn f() -> tackscope::worker::Event {}",
        "solver names tackscope::worker::Event",
    ),
    (
        "numerics/cancel.rs",
        "pub(in crate::physics) fn f() {}",
        "numerics names crate::physics",
    ),
    (
        "worker/mod.rs",
        "use crate::storage::save;",
        "worker names crate::storage::save",
    ),
    (
        "paper/mod.rs",
        "use crate::worker::Event;",
        "paper names crate::worker::Event",
    ),
    (
        "worker/mod.rs",
        "fn f(c: &egui::Context) {}",
        "only ui names egui::Context",
    ),
    (
        "cli/mod.rs",
        "use eframe::{run_native};",
        "only ui names eframe::run_native",
    ),
    (
        "storage/mod.rs",
        "rfd::FileDialog::new()",
        "only ui names rfd::FileDialog::new",
    ),
    (
        "solver/mod.rs",
        "use std::{fmt, thread};",
        "only worker names std::thread",
    ),
    (
        "numerics/krylov.rs",
        "use std::sync::mpsc::channel;",
        "only worker names std::sync::mpsc::channel",
    ),
    (
        "ui/app.rs",
        "let (a, b) = crossbeam_channel::bounded(1);",
        "only worker names crossbeam_channel::bounded",
    ),
    (
        "ui/app.rs",
        "std::thread::spawn(f);",
        "only worker names std::thread::spawn",
    ),
    ("cli/run.rs", "use std::fs;", "only storage names std::fs"),
    (
        "cli/run.rs",
        "use std::{io, fs::File};",
        "only storage names std::fs::File",
    ),
    (
        "ui/app.rs",
        "let f = File::open(p);",
        "only storage names File::open",
    ),
    (
        "ui/app.rs",
        "let d = tempfile::tempdir();",
        "only storage names tempfile::tempdir",
    ),
    (
        "main.rs",
        "fn main() { std::fs::read(p); }",
        "only storage names std::fs::read",
    ),
    (
        "solver/mod.rs",
        "use std::time::{Duration, Instant};",
        "std::time::Instant is a clock",
    ),
    (
        "physics/mod.rs",
        "let t = SystemTime::now();",
        "SystemTime::now is a clock",
    ),
    ("numerics/mod.rs", "unsafe { f() }", "unsafe"),
    ("rooftop/mod.rs", "", "the room rooftop has no floor"),
    ("rooftop.rs", "", "the room rooftop has no floor"),
    (
        "ui/app.rs",
        "#[cfg(feature = \"gui\")]",
        "a feature outside lib.rs and cli",
    ),
    (
        "lib.rs",
        "#[cfg(not(feature=\"fast\"))]",
        "the feature fast; there is only gui",
    ),
];

#[test]
fn every_kind_of_bad_file_is_caught() {
    let long = "\n".repeat(LINES_MAX + 1);
    let long_file = ("ui/app.rs", &*long, "lines, at most");
    for (path, text, expected) in BAD.into_iter().chain([long_file]) {
        let faults = faults(path, text);
        assert!(
            faults.iter().any(|fault| fault.contains(expected)),
            "{path}: {text:?} gave {faults:?}"
        );
    }
    let twice = format!(
        "#[cfg(feature = \"gui\")]{}#[cfg(not(feature = \"gui\"))]",
        "\n".repeat(ONE_PLACE + 1)
    );
    assert!(faults("cli/mod.rs", &twice)[0].contains("more than one place"));
}

#[test]
fn a_good_file_is_left_alone() {
    for (path, text) in [
        (
            "physics/law/mod.rs",
            "use super::grid; use crate::numerics::threads::Cancel; use super::super::numerics;",
        ),
        (
            "physics/mod.rs",
            "//! crate::ui, unsafe, std::fs\n/* egui::Context /* nested */ std::thread */ fn f() {}",
        ),
        (
            "physics/mod.rs",
            "const S: &str = \"crate::ui and unsafe { std::fs::read }\"; const R: &str = r#\"use crate::\"ui\";\"#;",
        ),
        (
            "physics/mod.rs",
            "fn f<'a>(c: &'a str) -> char { let _ = '\"'; let _ = '\\''; 'u' }",
        ),
        (
            "lib.rs",
            "#![forbid(unsafe_code)]\n#[cfg(feature = \"gui\")]\npub mod ui;",
        ),
        (
            "cli/mod.rs",
            "#[cfg(feature = \"gui\")]\nfn f() { crate::ui::open() }\n#[cfg(not(feature = \"gui\"))]\nfn f() {}",
        ),
        (
            "ui/app.rs",
            "use crate::worker; fn f(c: &egui::Context) { let thread = 1; let fs = 2; }",
        ),
        (
            "storage/mod.rs",
            "use std::fs::File; use crate::scene::Scene; use crate::paper;",
        ),
        (
            "worker/mod.rs",
            "use std::thread; let t = std::time::Instant::now();",
        ),
        ("follow/mod.rs", "let t = std::time::Instant::now();"),
    ] {
        assert_eq!(faults(path, text), Vec::<String>::new(), "{text}");
    }
}
