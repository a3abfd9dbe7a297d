//! Scene files: what is read, what is refused and how, and that no text whatever makes the reader
//! panic.

use crate::binary::{content, says, text_with};
use proptest::prelude::*;
use tackscope::physics::body::{Body, Layer};
use tackscope::physics::control::Control;
use tackscope::physics::indenter::{Hertz, Indenter, Rough, Wave};
use tackscope::physics::law::{Cosine, DoubleExponential, Mie, Morse, Shape};
use tackscope::physics::parameter::{Parameter, Value};
use tackscope::scene::{Cell, Drive, LawChoice, Points, Range, Scene, Turn, edit, parameter};
use tackscope::storage::{self, Failure, scene_file};

const NAME: &str = "my scene.toml";

fn fig2() -> &'static str {
    storage::preset("fig2").expect("fig2 is built in").text
}

/// Why a text is refused.
#[track_caller]
fn why(text: &str) -> String {
    let refused = scene_file::parse(text, NAME).expect_err("refused");
    refused.to_string()
}

/// What the text of a scene says.
fn again(scene: &Scene) -> Result<Scene, Failure> {
    scene_file::parse(&scene_file::to_text(scene), NAME)
}

/// Fig. 2 with one line replaced, and why it is refused.
fn refusal(line: &str, replacement: &str) -> String {
    let sentence = why(&text_with("fig2", &[(line, replacement)]));
    assert!(sentence.starts_with(NAME), "{sentence}");
    sentence
}

/// A line of Fig. 2, what it is replaced by, and parts of the sentence that refuses it.
#[track_caller]
fn refused(cases: &[(&str, &str, &[&str])]) {
    for (line, replacement, parts) in cases {
        says(&refusal(line, replacement), parts);
    }
}

#[test]
fn every_preset_is_an_allowed_scene_and_says_what_to_look_for() {
    let names: Vec<_> = storage::presets()
        .iter()
        .map(|preset| preset.name)
        .collect();
    assert_eq!(
        names,
        [
            "fig2",
            "fig3",
            "no-hysteresis",
            "coarse-mesh",
            "ridge-line",
            "hertz",
            "wavy",
            "rough",
            "soft-machine",
            "thin-film",
            "rubber"
        ]
    );
    for preset in storage::presets() {
        let scene = preset.scene().unwrap_or_else(|failure| panic!("{failure}"));
        assert!(!scene.title.is_empty() && !scene.source.is_empty());
        assert!(
            preset.hint().starts_with("What to look for"),
            "{}",
            preset.name
        );
        assert!(
            preset.look_for().starts_with(char::is_uppercase),
            "{}",
            preset.look_for()
        );
        assert_eq!(storage::preset_titled(&scene.title), Some(preset));
        assert_eq!(
            preset
                .text
                .lines()
                .take_while(|line| line.starts_with('#'))
                .count(),
            3,
            "{}",
            preset.name
        );
        assert!(preset.question().ends_with('?'), "{}", preset.name);
        assert!(!preset.hint().contains('?'), "{}", preset.hint());
        // Its small picture has both directions, and spans what it shows.
        for (direction, points) in preset.thumbnail() {
            assert!(points.len() > 30, "{} {direction}", preset.name);
            let shares = points.iter().flatten();
            assert!(shares.copied().all(|share| (0.0..=1.0).contains(&share)));
        }
        assert_eq!(again(&scene), Ok(scene));
    }
}

#[test]
fn the_coarse_mesh_preset_has_the_range_of_the_mesh_rule() {
    let model = storage::resolve("coarse-mesh")
        .unwrap()
        .model()
        .expect("allowed");
    // Eq. 11 with da = 256/32.
    let range = (0.15f64 * 256.0 / 32.0).sqrt() / (2.0 * 1.5);
    assert!((model.law.range - range).abs() < 1e-12 && (model.mu_rho - 1.5).abs() < 1e-12);
}

#[test]
fn what_may_be_left_out_has_its_default() {
    let text = "format = 1\ncell = { length = 64, points = [32, 32] }\nlaw = { kind = \"cosine\", surface_energy = 0.15, range = 1 }\n\
                drive = { start = 4, turn = 1, step = 0.1 }\n";
    let scene = scene_file::parse(text, NAME).expect("allowed");
    assert_eq!(
        (scene.body, scene.indenter, scene.accuracy, scene.seed),
        (Body::HalfSpace, Indenter::Flat, 0.01, 1)
    );
    assert_eq!(
        (scene.title.as_str(), scene.source.as_str()),
        ("untitled", "")
    );
    assert_eq!(scene.cell.points, Points::Square(32));
    assert_eq!(scene.law.shape, Shape::Cosine(Cosine { smooth: false }));
}

#[test]
fn an_unknown_key_is_refused_with_the_allowed_ones_and_a_guess() {
    refused(&[
        (
            "length = 256.0",
            "lenght = 256.0",
            &["cell.lenght", "did you mean length", "length, points"],
        ),
        (
            "[noise]",
            "[nose]",
            &["nose", "did you mean noise", "cell, body, law, indenter"],
        ),
        (
            "range = 1.0",
            "range = 1.0\nm = 8.0",
            &["law.m", "kind, surface_energy, range, mu_rho"],
        ),
        (
            "kind = \"flat\"",
            "kind = \"flat\"\nradius = 1.0",
            &["indenter.radius"],
        ),
    ]);
}

#[test]
fn a_wrong_type_is_refused_with_key_value_and_what_is_allowed() {
    refused(&[
        (
            "length = 256.0",
            "length = \"long\"",
            &[
                "cell.length = \"long\"",
                "allowed is a finite number above 0",
                "from 1e-110 to 1e110",
            ],
        ),
        ("title = ", "title = 3 #", &["title = 3", "text"]),
    ]);
    says(
        &why("format = 1\ncell = 3\n"),
        &["cell = 3", "allowed is a table, [cell]"],
    );
    refused(&[
        (
            "kind = \"morse\"",
            "kind = \"cosine\"\nsmooth = 1",
            &["law.smooth = 1", "true or false"],
        ),
        (
            "turn = 0.2",
            "turn = \"zero\"",
            &["drive.turn = \"zero\"", "zero_load"],
        ),
    ]);
}

#[test]
fn a_missing_key_or_table_is_named() {
    refused(&[
        (
            "length = 256.0",
            "",
            &["cell.length is missing", "finite number above 0"],
        ),
        ("[drive]", "[noise2]", &["noise2"]),
        ("format = 1", "", &["format is missing", "format = 1"]),
    ]);
    says(
        &why("format = 1\n"),
        &[NAME, "[cell] is missing", "length and points"],
    );
}

#[test]
fn a_turn_above_the_start_and_a_mesh_that_is_none_are_refused() {
    refused(&[(
        "turn = 0.2",
        "turn = 5",
        &["drive.turn = 5", "below drive.start = 4.2"],
    )]);
    for n in [
        "63",
        "0",
        "1000000",
        "-4",
        "[64, 2]",
        "[63, 1]",
        "64.0",
        "\"many\"",
        "9999999999999999999",
    ] {
        says(
            &refusal("points = 64", &format!("points = {n}")),
            &[if n.len() > 9 {
                "line 10"
            } else {
                "cell.points"
            }],
        );
    }
}

#[test]
fn a_law_has_its_own_keys_and_limits() {
    let mie = |m, n| {
        refusal(
            "kind = \"morse\"",
            &format!("kind = \"mie\"\nm = {m}\nn = {n}"),
        )
    };
    says(&mie(2, 2), &["law.m = 2", "above law.n = 2"]);
    says(&mie(2, 8), &["law.m = 2", "above law.n = 8"]);
    refused(&[
        ("kind = \"morse\"", "kind = \"mie\"", &["law.m is missing"]),
        (
            "kind = \"morse\"",
            "kind = \"double_exponential\"\nratio = 1.0",
            &["law.ratio = 1", "below 1"],
        ),
        (
            "kind = \"morse\"",
            "kind = \"mores\"",
            &["law.kind = \"mores\"", "\"mie\"", "did you mean morse"],
        ),
        (
            "range = 1.0",
            "range = 1.0\nmu_rho = 0.5",
            &["law.mu_rho = 0.5", "not together with law.range"],
        ),
        ("range = 1.0", "", &["law.range is missing", "mu_rho"]),
    ]);
}

const ROUGH: &str =
    "kind = \"rough\"\nhurst = 0.8\nrms = 1\nlongest = 64\nshortest = 8.0\nseed = 3";

#[test]
fn wavy_and_rough_ground_are_read() {
    let with = |indenter: &str| {
        scene_file::parse(&fig2().replacen("kind = \"flat\"", indenter, 1), NAME)
            .expect("allowed")
            .indenter
    };
    let wave = |periods| {
        Indenter::Wave(Wave {
            amplitude: 0.5,
            periods,
        })
    };
    assert_eq!(
        with("kind = \"wave\"\namplitude = 0.5\nperiods = 2"),
        wave([2, 0])
    );
    assert_eq!(
        with("kind = \"wave\"\namplitude = 0.5\nperiods = [1, 3]"),
        wave([1, 3])
    );
    let rough = Rough {
        hurst: 0.8,
        rms: 1.0,
        longest: 64.0,
        shortest: 8.0,
        seed: 3,
    };
    assert_eq!(with(ROUGH), Indenter::Rough(rough));
    assert_eq!(
        with(&ROUGH.replace("\nseed = 3", "")),
        Indenter::Rough(Rough { seed: 1, ..rough })
    );
}

#[test]
fn a_layer_has_its_own_keys_and_limits() {
    let body = |keys: &str| refusal("[law]", &format!("[body]\n{keys}\n[law]"));
    let layer = |keys: &str| body(&format!("kind = \"layer\"\n{keys}"));
    says(
        &layer("thickness = 3\npoisson = -1"),
        &[
            "body.poisson = -1",
            "allowed is a number above -1, at most 0.5",
        ],
    );
    says(
        &layer("thickness = 1e-3\npoisson = 0.5"),
        &[
            "body.thickness = 0.001",
            "at least 1e-5 of cell.length = 256",
        ],
    );
    says(&layer("poisson = 0.5"), &["body.thickness is missing"]);
    says(&layer("thickness = 3"), &["body.poisson is missing"]);
    says(
        &body("kind = \"half_space\"\nthickness = 3"),
        &["body.thickness", "kind"],
    );
    says(
        &body("kind = \"shell\""),
        &["body.kind = \"shell\"", "half_space", "layer"],
    );
}

#[test]
fn an_indenter_has_its_own_keys_and_limits() {
    let wave = |periods| {
        refusal(
            "kind = \"flat\"",
            &format!("kind = \"wave\"\namplitude = 0.5\nperiods = {periods}"),
        )
    };
    says(
        &wave("-1"),
        &["indenter.periods = -1", "whole number", "[2, 1]"],
    );
    says(&wave("[1, 2, 3]"), &["indenter.periods", "[2, 1]"]);
    says(
        &wave("0"),
        &["indenter.periods = [0, 0]", "above 0 along x or y"],
    );
    says(
        &wave("17"),
        &[
            "indenter.periods = [17, 0]",
            "a quarter of the points along a side (16)",
        ],
    );
    says(
        &refusal("kind = \"flat\"", "kind = \"wave\"\nperiods = 1"),
        &["indenter.amplitude is missing"],
    );
    let rough = |from, to| refusal("kind = \"flat\"", &ROUGH.replacen(from, to, 1));
    says(
        &rough("rms = 1", ""),
        &["indenter.rms is missing", "root mean square height"],
    );
    says(
        &rough("longest = 64", "longest = 300"),
        &["indenter.longest = 300", "at most cell.length = 256"],
    );
    says(
        &rough("shortest = 8.0", "shortest = 65"),
        &["indenter.shortest = 65", "to indenter.longest = 64"],
    );
    says(
        &rough("shortest = 8.0", "shortest = 0.4"),
        &["indenter.shortest = 0.4", "from 0.5 (cell.length/512)"],
    );
    says(
        &rough("rms = 1", "rms = 1\nradius = 2"),
        &["indenter.radius", "hurst, rms, longest, shortest, seed"],
    );
    says(
        &refusal("kind = \"flat\"", "kind = \"ruff\""),
        &["indenter.kind = \"ruff\"", "\"wave\"", "\"rough\""],
    );
    let line = text_with(
        "fig2",
        &[
            ("points = 64", "points = [64, 1]"),
            (
                "kind = \"flat\"",
                "kind = \"wave\"\namplitude = 0.5\nperiods = [1, 1]",
            ),
        ],
    );
    says(
        &why(&line),
        &["indenter.periods = [1, 1]", "along x alone on a line cell"],
    );
}

#[test]
fn another_format_is_refused_before_anything_else() {
    refused(&[
        (
            "format = 1",
            "format = 2\nnew = true",
            &["format = 2", "allowed is 1"],
        ),
        ("format = 1", "format = \"1\"", &["format = \"1\""]),
    ]);
}

#[test]
fn a_syntax_error_names_line_and_column() {
    refused(&[
        (
            "length = 256.0",
            "length = = 3",
            &["line 9", "column 10", "not TOML"],
        ),
        ("points = 64", "length = 256.0", &["line 10", "duplicate"]),
    ]);
}

#[test]
fn files_that_are_missing_too_long_or_not_text_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.toml");
    let refused = |part: &str| {
        let sentence = scene_file::load(&path).expect_err("refused").to_string();
        says(&sentence, &[&path.display().to_string(), part]);
    };
    refused("No such file");
    std::fs::write(&path, vec![b'#'; (1 << 20) + 1]).expect("written");
    refused("longer than 1048576 bytes");
    std::fs::write(&path, b"title = \"M\xfcser\"").expect("written");
    refused("UTF-8");
    let folder = scene_file::load(folder.path()).unwrap_err().to_string();
    assert!(folder.contains("cannot be read"), "{folder}");
}

#[test]
fn a_scene_is_saved_whole_and_comes_back_and_an_impossible_one_is_not_saved() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("new folder").join("scene.toml");
    let mut scene = storage::resolve("ridge-line").unwrap();
    scene_file::save(&path, &scene).expect("saved");
    assert_eq!(scene_file::load(&path), Ok(scene.clone()));
    let before = std::fs::read(&path).expect("there");
    scene.cell.length = f64::NAN;
    says(
        &scene_file::save(&path, &scene)
            .expect_err("refused")
            .to_string(),
        &["cell.length = nan"],
    );
    assert_eq!(
        std::fs::read(&path).expect("there"),
        before,
        "the old file is untouched"
    );
    assert_eq!(
        std::fs::read_dir(path.parent().expect("a folder"))
            .expect("listed")
            .count(),
        1,
        "no temporary file is left"
    );
    scene.cell.length = 256.0;
    let below_a_file = path.join("other.toml");
    says(
        &scene_file::save(&below_a_file, &scene)
            .expect_err("refused")
            .to_string(),
        &["cannot be written", "other.toml"],
    );
}

fn shapes() -> impl Strategy<Value = Shape> {
    prop_oneof![
        Just(Shape::Morse(Morse)),
        (0.1..20.0, 0.01..70.0).prop_map(|(n, more)| Shape::Mie(Mie { m: n + more, n })),
        any::<bool>().prop_map(|smooth| Shape::Cosine(Cosine { smooth })),
        (0.01..0.99).prop_map(|ratio| Shape::DoubleExponential(DoubleExponential { ratio })),
    ]
}

fn meshes() -> impl Strategy<Value = (Points, Range)> {
    let (sides, positive) = (
        || (2usize..=2048).prop_map(|half| 2 * half),
        || prop_oneof![1e-9..1e-3, 0.01..10.0, 1e3..1e12],
    );
    let range = move || {
        prop_oneof![
            positive().prop_map(Range::Length),
            positive().prop_map(Range::MuRho)
        ]
    };
    prop_oneof![
        (sides().prop_map(Points::Square), range()),
        (sides().prop_map(Points::Line), range()),
        (Just(Points::Auto), (0.5..2.0).prop_map(Range::Length)),
    ]
}

fn grounds() -> impl Strategy<Value = Indenter> {
    prop_oneof![
        Just(Indenter::Flat),
        (1e-3..1e6).prop_map(|radius| Indenter::Hertz(Hertz { radius })),
        (1e-3..1e3).prop_map(|amplitude| Indenter::Wave(Wave {
            amplitude,
            periods: [1, 0]
        })),
        (
            0.01..1.0,
            1e-6..1e6,
            10.0..50.0,
            1.0..10.0,
            0..=i64::MAX as u64
        )
            .prop_map(
                |(hurst, rms, longest, shortest, seed)| Indenter::Rough(Rough {
                    hurst,
                    rms,
                    longest,
                    shortest,
                    seed
                })
            ),
    ]
}

fn bodies() -> impl Strategy<Value = Body> {
    let layer = |(thickness, poisson)| Body::Layer(Layer { thickness, poisson });
    prop_oneof![
        Just(Body::HalfSpace),
        (0.1..1e4, -0.99..=0.5).prop_map(layer)
    ]
}

fn controls() -> impl Strategy<Value = Control> {
    (1e-6..1e6).prop_flat_map(|stiffness| prop::sample::select(Control::all(stiffness).to_vec()))
}

prop_compose! {
    fn scenes()(
        title in any::<String>(), source in "\\PC*", length in 50.0..500.0, (points, range) in meshes(), shape in shapes(),
        surface_energy in 0.01..0.5, indenter in grounds(), turn in prop::option::of(1e-6..3.0),
        control in controls(), body in bodies(), drop in 0.1..9.0, steps in 1.0..1e5, accuracy in 0.05..0.9, seed in 0..=i64::MAX as u64,
    ) -> Scene {
        let turn = if indenter == Indenter::Flat { Turn::At(turn.unwrap_or(0.5)) } else { turn.map_or(Turn::ZeroLoad, Turn::At) };
        let bottom = if let Turn::At(turn) = turn { turn } else { 0.0 };
        Scene {
            title, source, cell: Cell { length, points }, body, law: LawChoice { shape, surface_energy, range }, indenter,
            drive: Drive { control, start: bottom + drop, turn, step: drop / steps }, accuracy, seed, units: None,
        }
    }
}

/// A text that is almost a scene file: pieces of a preset cut out, doubled, swapped, or replaced by
/// what means something elsewhere.
fn mutated() -> impl Strategy<Value = String> {
    let words = prop::sample::select(vec![
        "nan",
        "-inf",
        "[",
        "]",
        "]]",
        "{",
        "}",
        "\"",
        "'''",
        "=",
        ".",
        ",",
        "\n",
        "\0",
        "\u{feff}",
        "#",
        "1e999",
        "0x",
        "-1",
        "64",
        "[64, 1]",
        "\"auto\"",
        "cell.",
        "[cell]",
        "[[law]]",
        "format = 1",
        "1979-05-27",
        "9223372036854775808",
        "é",
        "\r",
    ]);
    let edit = (
        any::<prop::sample::Index>(),
        any::<prop::sample::Index>(),
        0..4u8,
        words,
    );
    (
        prop::sample::select(storage::presets()),
        prop::collection::vec(edit, 1..6),
    )
        .prop_map(|(preset, edits)| {
            let mut text: Vec<char> = preset.text.chars().collect();
            for (from, to, what, word) in edits {
                let (a, b) = (from.index(text.len() + 1), to.index(text.len() + 1));
                let piece = a.min(b)..a.max(b).min(a.min(b) + 40);
                let copy: Vec<char> = text[piece.clone()].to_vec();
                match what {
                    0 => drop(text.drain(piece)),
                    1 => drop(text.splice(b..b, copy)),
                    2 => drop(text.splice(a..a, word.chars())),
                    _ => drop(
                        text.splice(piece.start..(piece.start + 3).min(text.len()), word.chars()),
                    ),
                }
            }
            text.into_iter().collect()
        })
}

/// Parses; a refusal must be one line of readable length that names the file, an acceptance must
/// come back the same.
fn parses_or_says_why(text: &str) -> Result<(), TestCaseError> {
    match scene_file::parse(text, NAME) {
        Ok(scene) => prop_assert_eq!(again(&scene), Ok(scene)),
        Err(failure) => {
            let sentence = failure.to_string();
            prop_assert!(sentence.starts_with(NAME), "{}", sentence);
            prop_assert!(
                sentence.chars().count() < 500 && !sentence.contains('\n'),
                "{}",
                sentence
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn an_allowed_scene_comes_back_from_its_text(scene in scenes()) {
        prop_assume!(scene.validate().is_ok());
        prop_assert_eq!(again(&scene), Ok(scene));
    }

    #[test]
    fn any_text_is_read_or_refused_by_name(text in any::<String>()) {
        parses_or_says_why(&text)?;
    }

    #[test]
    fn any_lines_of_key_and_value_are_read_or_refused_by_name(text in "(\\[?[a-z_.]{1,9}\\]? ?=? ?[-0-9a-z\"\\[\\]{},.]{0,9}\n){0,12}") {
        parses_or_says_why(&text)?;
    }

    #[test]
    fn a_damaged_scene_file_is_read_or_refused_by_name(text in mutated()) {
        parses_or_says_why(&text)?;
    }
}

/// The page that the README links.
const GUIDE: &str = "assets/guide/scene-files.md";

#[test]
fn the_guide_lists_every_number_with_its_range_as_the_program_knows_it() {
    let page = content(GUIDE);
    let row = |parameter: &Parameter| {
        let default = parameter.default.map(|value| value.to_string());
        let default = default.unwrap_or_else(|| "must be given".to_owned());
        let (key, unit) = (parameter.key, parameter.unit.word());
        let (title, allowed) = (parameter.title(), parameter.allowed());
        format!("| `{key}` | {title} | {unit} | {default} | {allowed} |\n")
    };
    let rows: String = parameter::all().into_iter().map(row).collect();
    let table = format!(
        "| key | name | unit | where the file says nothing | allowed |\n|---|---|---|---|---|\n{rows}"
    );
    assert!(page.contains(&table), "{GUIDE} should contain:\n\n{table}");
    let readme = content("README.md");
    assert!(readme.contains(GUIDE), "the README links {GUIDE}");
}

/// Ground whose period is the cell of Fig. 2.
const MEASURED: &str = "kind = \"measured\"\nfile = \"tests/data/heights.csv\"\nsize = 128.0\n\
    height_scale = 1.0\nunit = \"um\"\ndetrend = \"none\"\nperiodic = \"mirror\"\nshortest = 0.0";

/// A scene that gives the number `parameter`, and the text in its file that is the number.
fn giving(parameter: &Parameter) -> (String, String) {
    let (law, ground) = ("kind = \"morse\"", "kind = \"flat\"");
    let [old, new] = match parameter.key {
        "law.mu_rho" => ["range = 1.0", "mu_rho = 0.5"],
        "law.m" | "law.n" => [law, "kind = \"mie\"\nm = 8.0\nn = 2.0"],
        "law.smooth" => [law, "kind = \"cosine\"\nsmooth = false"],
        "law.ratio" => [law, "kind = \"double_exponential\"\nratio = 0.4"],
        "drive.stiffness" => ["[drive]", "[drive]\ncontrol = \"spring\"\nstiffness = 0.1"],
        "indenter.radius" => [ground, "kind = \"hertz\"\nradius = 30.0"],
        "indenter.amplitude" | "indenter.periods" => {
            [ground, "kind = \"wave\"\namplitude = 0.5\nperiods = 1"]
        }
        "body.contact_modulus" | "units.temperature" => [
            "[law]",
            "[units]\nlength = \"um\"\nmodulus = \"MPa\"\ntemperature = 300.0\n\n\
             [body]\nkind = \"half_space\"\ncontact_modulus = 2.0\n\n[law]",
        ],
        "body.thickness" | "body.poisson" => [
            "[law]",
            "[body]\nkind = \"layer\"\nthickness = 32.0\npoisson = 0.4\n\n[law]",
        ],
        "indenter.seed" => [ground, ROUGH],
        key if key.starts_with("indenter") && parameter.default.is_some() => [ground, MEASURED],
        key if key.starts_with("indenter") => [ground, ROUGH],
        _ => [""; 2],
    };
    let text = text_with("fig2", &[(old, new)]);
    // Fig. 2 has a seed of its own.
    let line = match parameter.key {
        "indenter.seed" => "seed = 3".to_owned(),
        _ => format!("{} = ", parameter.name()),
    };
    let at = text
        .find(&format!("\n{line}"))
        .unwrap_or_else(|| panic!("{line} is in the file"))
        + 1;
    let end = text[at..]
        .find(['\n', '#'])
        .map_or(text.len(), |end| at + end);
    let given = text[at..end].trim_end().to_owned();
    (text, given)
}

#[test]
fn a_number_outside_its_range_is_refused_with_the_range() {
    for parameter in parameter::all() {
        let (text, given) = giving(parameter);
        assert!(scene_file::parse(&text, NAME).is_ok(), "{}", parameter.key);
        let (low, high) = (*parameter.range.start(), *parameter.range.end());
        let whole = ["points", "periods", "seed"].contains(&parameter.name());
        let word = matches!(parameter.default, Some(Value::Choice { .. }));
        let beyond = if parameter.name() == "smooth" || word {
            vec!["2".to_owned(), "\"yes\"".to_owned()]
        } else if whole {
            vec![
                format!("{}", low as i64 - 1),
                if high > 1e6 {
                    "9223372036854775808".to_owned()
                } else {
                    format!("{}", high as i64 + 1)
                },
            ]
        } else {
            vec![
                format!("{:e}", low - (0.5 * low.abs()).max(1e-200)),
                format!("{:e}", high + 0.5 * high.abs()),
                "nan".to_owned(),
                "-inf".to_owned(),
            ]
        };
        for value in beyond {
            let changed = text.replacen(&given, &format!("{} = {value}", parameter.name()), 1);
            let sentence = scene_file::parse(&changed, NAME)
                .expect_err(&value)
                .to_string();
            // An integer that TOML cannot hold is refused by its parser.
            if value != "9223372036854775808" {
                says(&sentence, &[parameter.key, &parameter.allowed()]);
            }
        }
    }
}

#[test]
fn every_number_of_a_scene_is_in_the_list_and_the_list_has_no_other() {
    let mut seen = std::collections::BTreeSet::new();
    for parameter in parameter::all() {
        let scene = scene_file::parse(&giving(parameter).0, NAME).expect("allowed");
        seen.extend(scene.numbers().iter().map(|(parameter, _)| parameter.key));
        // What the file holds and what the scene lists are the same.
        let text = scene_file::to_text(&scene);
        let table: toml::Table = text.parse().expect("TOML");
        for (section, value) in table
            .iter()
            .filter_map(|(name, value)| Some((name, value.as_table()?)))
        {
            for (name, _) in value.iter().filter(|(_, value)| !value.is_str()) {
                let key = format!("{section}.{name}");
                assert!(
                    scene
                        .numbers()
                        .iter()
                        .any(|(parameter, _)| parameter.key == key),
                    "{key} is not listed"
                );
            }
        }
    }
    assert_eq!(
        seen,
        parameter::all()
            .into_iter()
            .map(|parameter| parameter.key)
            .collect()
    );
}

#[test]
fn every_body_law_and_ground_of_the_pickers_opens_from_its_file() {
    let scene = storage::resolve("fig2").unwrap();
    let model = scene.model().expect("allowed");
    for body in Body::all() {
        let body = body.elastic().suited(&model.grid);
        let edited = edit::with_body(&scene, &model, body);
        let text = scene_file::to_text(&edited);
        assert!(text.contains(body.word()), "{text}");
        assert_eq!(scene_file::parse(&text, NAME), Ok(edited));
    }
    for shape in Shape::all() {
        // Measured ground needs a file: `heights.rs`.
        let all = Indenter::all().into_iter();
        for ground in all.filter(|ground| ground.check().is_ok()) {
            let indenter = ground.ground().suited(&model.law, &model.grid);
            let edited =
                edit::with_ground(&edit::with_shape(&scene, &model, shape), &model, indenter);
            let text = scene_file::to_text(&edited);
            assert_eq!(
                scene_file::parse(&text, NAME).as_ref(),
                Ok(&edited),
                "{text}"
            );
            assert!(
                text.contains(shape.word()) && text.contains(ground.word()),
                "{text}"
            );
        }
    }
}

#[test]
fn the_unit_of_length_may_be_anything_from_tiny_to_huge() {
    let base = fig2();
    let reference = scene_file::parse(base, NAME)
        .expect("allowed")
        .model()
        .expect("allowed");
    for unit in [1e-100, 1e-9, 1e9, 1e100] {
        let mut scene = scene_file::parse(base, NAME).expect("allowed");
        scene.cell.length *= unit;
        scene.law.surface_energy *= unit;
        scene.law.range = Range::Length(unit);
        (scene.drive.start, scene.drive.step) = (scene.drive.start * unit, scene.drive.step * unit);
        scene.drive.turn = Turn::At(0.2 * unit);
        let model = scene.model().unwrap_or_else(|error| panic!("{error}"));
        assert!(
            (model.mu_rho / reference.mu_rho - 1.0).abs() < 1e-12,
            "{unit}: {}",
            model.mu_rho
        );
    }
}

#[test]
fn more_waves_than_a_mesh_can_have_are_the_waves_fault_and_not_the_ranges() {
    let wave = |periods: &str| {
        let wave = format!("kind = \"wave\"\namplitude = 0.5\nperiods = {periods}");
        why(&text_with(
            "fig2",
            &[
                ("points = 64", "points = \"auto\""),
                ("kind = \"flat\"", &wave),
            ],
        ))
    };
    for periods in ["1000000000", "4611686018427387904", "[1, 600]", "513"] {
        says(&wave(periods), &["indenter.periods"]);
    }
}

#[test]
fn a_step_that_moves_nothing_is_refused() {
    for step in ["1e-18", "1e-8", "1e-7"] {
        let text = text_with(
            "fig2",
            &[
                ("kind = \"flat\"", "kind = \"hertz\"\nradius = 30.0"),
                ("turn = 0.2", "turn = \"zero_load\""),
                ("step = 0.02", &format!("step = {step}")),
            ],
        );
        says(&why(&text), &["drive.step = 1e-", "at least"]);
    }
    says(
        &refusal(
            "start = 4.2\nturn = 0.2\nstep = 0.02",
            "start = 1e15\nturn = 999999999999999\nstep = 1e-6",
        ),
        &["drive.step", "digits"],
    );
}

#[test]
fn a_drive_into_the_wall_of_a_mie_law_is_refused_on_any_ground() {
    // Over whole waves a cosine has no mean, so that the mean of the ground lies an amplitude below
    // each crest of its two waves.
    for (indenter, level) in [
        (Indenter::Flat, 0.0),
        (
            Indenter::Wave(Wave {
                amplitude: 0.3,
                periods: [1, 0],
            }),
            -0.3,
        ),
        (
            Indenter::Wave(Wave {
                amplitude: 0.3,
                periods: [1, 1],
            }),
            -0.6,
        ),
    ] {
        let mut scene = scene_file::parse(fig2(), NAME).unwrap();
        scene.law.shape = Shape::Mie(Mie { m: 9.0, n: 3.0 });
        scene.indenter = indenter.clone();
        scene.drive.turn = Turn::At(level + 0.01);
        assert!(
            scene.model().is_ok(),
            "{indenter:?}: {}",
            scene.model().unwrap_err()
        );
        scene.drive.turn = Turn::At(level - 0.01);
        let error = scene.model().unwrap_err();
        assert!(
            error.key == "drive.turn" && error.allowed.contains("above "),
            "{error:?}"
        );
    }
}
