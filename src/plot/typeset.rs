//! Formulas in a line of text: labels are written as in "p~ = p u_0/gamma" or "u₀/ρ", and shown
//! with Greek letters, sub- and superscripts by whoever can draw them.

/// Where a piece of text stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Script {
    /// On the line.
    Base,
    /// Below it, smaller.
    Sub,
    /// Above it, smaller.
    Super,
}

/// A piece of text that stands in one way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The text.
    pub text: String,
    /// Where it stands.
    pub script: Script,
}

/// Greek letters and the root by name.
const GREEK: [(&str, char); 14] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("Delta", 'Δ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("pi", 'π'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("chi", 'χ'),
    ("omega", 'ω'),
    ("sqrt", '√'),
];

/// Accents by the end of a word, as marks that combine with the letter before.
const ACCENTS: [(&str, char); 3] = [("hat", '\u{302}'), ("bar", '\u{304}'), ("tilde", '\u{303}')];

/// Unicode's small digits stand lower or higher by themselves; here they become runs, so that all
/// look alike.
const SUB_DIGITS: [char; 10] = ['₀', '₁', '₂', '₃', '₄', '₅', '₆', '₇', '₈', '₉'];

/// The runs of a line.
///
/// Names of Greek letters and "vhat", "abar" are replaced where they are whole words; `_` and `^`
/// lower and raise the word, the number or the bracket `{...}` after them (`^` also a bracket
/// `(...)`); a `~` after a letter goes on top of it; "u0" is u_0.
pub fn runs(text: &str) -> Vec<Run> {
    let c: Vec<char> = text.chars().collect();
    let mut list = Vec::new();
    let mut i = 0;
    while i < c.len() {
        let shift = match c[i] {
            '_' => Some(Script::Sub),
            '^' => Some(Script::Super),
            _ => None,
        };
        if let Some(script) = shift
            && let Some((inside, next)) = argument(&c, i + 1, script)
        {
            push(
                &mut list,
                &words(&inside).replace(
                    '-',
                    if script == Script::Super {
                        "\u{2212}"
                    } else {
                        "-"
                    },
                ),
                script,
            );
            i = next;
        } else if let Some(digit) = SUB_DIGITS.iter().position(|d| *d == c[i]) {
            push(&mut list, &digit.to_string(), Script::Sub);
            i += 1;
        } else if c[i] == 'u'
            && c.get(i + 1) == Some(&'0')
            && !alphanumeric(&c, i.wrapping_sub(1))
            && !alphanumeric(&c, i + 2)
        {
            push(&mut list, "u", Script::Base);
            push(&mut list, "0", Script::Sub);
            i += 2;
        } else {
            let end = (i + 1..c.len())
                .find(|&k| !c[k].is_alphabetic() || !c[i].is_alphabetic())
                .unwrap_or(c.len());
            let opens = i == 0 || " (=".contains(c[i - 1]);
            let minus = c[i] == '-' && opens && i + 1 < c.len();
            // A sign, where it is no hyphen.
            push(
                &mut list,
                &if minus {
                    "\u{2212}".to_owned()
                } else {
                    words(&c[i..end])
                },
                Script::Base,
            );
            i = end;
            if c.get(i) == Some(&'~') && c[i - 1].is_alphabetic() {
                push(&mut list, "\u{303}", Script::Base);
                i += 1;
            }
        }
    }
    list
}

fn alphanumeric(c: &[char], i: usize) -> bool {
    c.get(i).is_some_and(|c| c.is_alphanumeric())
}

/// What `_` or `^` is about, from `start` on, and where it ends; `None` if nothing follows.
fn argument(c: &[char], start: usize, script: Script) -> Option<(Vec<char>, usize)> {
    let close = match c.get(start)? {
        '{' => '}',
        '(' if script == Script::Super => ')',
        _ => {
            let sign = usize::from(script == Script::Super && c[start] == '-');
            let digits = c.get(start + sign)?.is_ascii_digit();
            let fits = |c: &char| {
                if digits {
                    c.is_ascii_digit()
                } else {
                    c.is_alphanumeric()
                }
            };
            let count = c[start + sign..].iter().take_while(|c| fits(c)).count();
            return (count > 0).then(|| {
                (
                    c[start..start + sign + count].to_vec(),
                    start + sign + count,
                )
            });
        }
    };
    let length = c[start + 1..].iter().position(|c| *c == close)?;
    Some((
        c[start + 1..start + 1 + length].to_vec(),
        start + length + 2,
    ))
}

fn push(list: &mut Vec<Run>, text: &str, script: Script) {
    match list.last_mut() {
        Some(last) if last.script == script => last.text.push_str(text),
        _ => list.push(Run {
            text: text.to_owned(),
            script,
        }),
    }
}

/// Every whole word that names a letter replaced by it.
fn words(c: &[char]) -> String {
    let mut out = String::new();
    let mut i = 0;
    while i < c.len() {
        let length = c[i..]
            .iter()
            .take_while(|c| c.is_ascii_alphabetic())
            .count();
        if length == 0 {
            out.push(c[i]);
            i += 1;
        } else {
            let word: String = c[i..i + length].iter().collect();
            out.push_str(&letter(&word).unwrap_or(word));
            i += length;
        }
    }
    out
}

/// The letter that a word names, accent and all.
fn letter(word: &str) -> Option<String> {
    if let Some((_, greek)) = GREEK.iter().find(|(name, _)| *name == word) {
        return Some(greek.to_string());
    }
    let (stem, accent) = ACCENTS
        .iter()
        .find_map(|(name, accent)| Some((word.strip_suffix(name)?, accent)))?;
    let one = |stem: &str| {
        matches!(stem.as_bytes(), [b'a'..=b'z']) && !["c", "h", "t", "b", "w"].contains(&stem)
    };
    let base = if one(stem) {
        stem.to_owned()
    } else {
        letter(stem)?
    };
    // The paper's ahat and abar are made of alpha.
    let base = if stem == "a" { "α".to_owned() } else { base };
    Some(format!("{base}{accent}"))
}

/// The line in one size, for places that take no layout: digits are raised and lowered, the rest
/// stays as it is written.
pub fn plain(text: &str) -> String {
    let raised = |c: char| match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4'..='9' => char::from_u32('⁴' as u32 + (c as u32 - '4' as u32)).unwrap_or(c),
        '\u{2212}' => '⁻',
        c => c,
    };
    let lowered = |c: char| char::from_u32('₀' as u32 + (c as u32 - '0' as u32)).unwrap_or(c);
    let one = |run: Run| match run.script {
        Script::Base => run.text,
        Script::Sub if run.text.chars().all(|c| c.is_ascii_digit()) => {
            run.text.chars().map(lowered).collect()
        }
        Script::Sub => format!("_{}", run.text),
        Script::Super => run.text.chars().map(raised).collect(),
    };
    runs(text).into_iter().map(one).collect()
}

/// Six digits, as one reads them.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "not available".to_owned();
    }
    let size = value.abs();
    let text = if size == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (5 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{value:.2e}")
    };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marked(text: &str) -> String {
        let mark = |run: Run| match run.script {
            Script::Base => run.text,
            Script::Sub => format!("[{}]", run.text),
            Script::Super => format!("<{}>", run.text),
        };
        runs(text).into_iter().map(mark).collect()
    }

    #[test]
    fn greek_letters_scripts_and_accents_are_set() {
        for (plain, set) in [
            ("L/L_c", "L/L[c]"),
            ("mu_rho = 0.5", "μ[ρ] = 0.5"),
            ("u0/rho", "u[0]/ρ"),
            ("mean displacement u₀/ρ", "mean displacement u[0]/ρ"),
            ("p~ = p u0/gamma", "p\u{303} = p u[0]/γ"),
            (
                "rho~^2 and u~^{2/3} and u~^(4/5)",
                "ρ\u{303}<2> and u\u{303}<2/3> and u\u{303}<4/5>",
            ),
            ("p/σ_max", "p/σ[max]"),
            ("10^-3", "10<\u{2212}3>"),
            (
                "p~ = -(4/pi), two-fold",
                "p\u{303} = \u{2212}(4/π), two-fold",
            ),
            ("E*/L", "E*/L"),
            ("ln(x) - 8c", "ln(x) \u{2212} 8c"),
            ("vhat(alpha)", "v\u{302}(α)"),
            ("gamma_hys/gamma", "γ[hys]/γ"),
            ("abar", "α\u{304}"),
        ] {
            assert_eq!(marked(plain), set, "{plain}");
        }
    }

    #[test]
    fn ordinary_words_and_loose_signs_stay_as_they_are() {
        for text in [
            "what a chat about the bar",
            "What? That.",
            "a ~ b",
            "rhombus, pie",
            "a_",
            "x^",
            "",
            "tenth: 100 %",
            "u01, tau0",
        ] {
            assert_eq!(marked(text), text);
        }
    }

    #[test]
    fn numbers_have_six_digits_and_say_where_there_is_none() {
        let texts = [0.0, 0.400642787, -131.92225, 1e-7, 123456.0, 2.0, f64::NAN].map(number);
        assert_eq!(
            texts,
            [
                "0",
                "0.400643",
                "\u{2212}131.922",
                "1.00e\u{2212}7",
                "123456",
                "2",
                "not available"
            ]
        );
    }

    #[test]
    fn powers_are_raised_and_indices_lowered_where_there_is_one_size_only() {
        assert_eq!(plain("10^{\u{2212}3}"), "10⁻³");
        assert_eq!(plain("5·10^{7}"), "5·10⁷");
        assert_eq!(plain("mu_rho"), "μ_ρ");
        assert_eq!(plain("u0"), "u₀");
    }
}
