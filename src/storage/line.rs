//! Somebody else's words (titles, sources, file names) where they meet a terminal, a picture or a
//! page: one rule for all of them.

/// The text on one line: line breaks and tabs are spaces, and what has no sign of its own is
/// written by its number, as in `\u{1b}`. That is what could steer a terminal or spoil an XML text:
/// control characters, marks that turn the direction of writing, code points that are no
/// characters.
pub fn line(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\t' | '\n' | '\r' | '\u{2028}' | '\u{2029}' => out.push(' '),
            c if signless(c) => out.extend(c.escape_unicode()),
            c => out.push(c),
        }
    }
    out
}

fn signless(c: char) -> bool {
    let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let no_character = u32::from(c) & 0xfffe == 0xfffe || matches!(c, '\u{fdd0}'..='\u{fdef}');
    c.is_control() || turns || no_character
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_steers_a_terminal_is_written_by_its_number() {
        assert_eq!(
            line("\u{1b}[31mred\u{7}\u{9b}"),
            "\\u{1b}[31mred\\u{7}\\u{9b}"
        );
        assert_eq!(line("one\ntwo\tthree\r"), "one two three ");
        assert_eq!(
            line("M\u{fc}ser \u{3c1}\u{303} \u{4e2d} \u{5d0} \u{1f600}"),
            "M\u{fc}ser \u{3c1}\u{303} \u{4e2d} \u{5d0} \u{1f600}"
        );
    }

    proptest! {
        #[test]
        fn whatever_comes_in_is_one_line_of_legal_xml_and_stays_what_it_is(text in any::<String>(), odd in "[\u{0}-\u{9f}\u{202e}\u{fffe}\u{ffff}\u{1fffe}a]*") {
            for text in [text, odd] {
                let once = line(&text);
                // The characters of XML 1.0, without its line breaks and the C1 controls.
                let legal = |c: char| matches!(c, ' '..='~' | '\u{a0}'..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..);
                prop_assert!(once.chars().all(legal), "{once:?}");
                prop_assert_eq!(line(&once), once.clone());
            }
        }
    }
}
