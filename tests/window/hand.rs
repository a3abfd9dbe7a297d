//! What is done to a window by hand, and what is read on it, whatever solver is behind it.

use egui::{Event, Key, Modifiers, Pos2, Rect, Role, Vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tackscope::ui::App;
use tackscope::ui::view_state::ViewState;

/// The window under test.
pub type Window = Harness<'static, App>;

pub trait Hand {
    /// What is shown.
    fn view(&self) -> &ViewState;

    /// Every name and every value on the screen, a line each.
    fn names(&self) -> String;

    /// Where something stands whose name has these words in it.
    fn place(&self, words: &str) -> Rect;

    /// Where that of this very name stands.
    fn place_of(&self, name: &str) -> Rect;

    /// The whole name of that in whose name these words are.
    fn name(&self, words: &str) -> String;

    /// Clicks what has this name.
    fn hit(&mut self, name: &str);

    fn tap(&mut self, key: Key);

    /// Types into what has the focus.
    fn write(&mut self, text: &str);

    /// Types in place of what is there.
    fn write_over(&mut self, text: &str);

    /// The field for the number of this name.
    fn field<'a>(&'a self, name: &'a str) -> Node<'a>;

    fn click_at(&mut self, at: Pos2);

    /// Presses at a place, goes by these ways from there, and lets go at the last.
    fn drag_along(&mut self, from: Pos2, by: &[Vec2]);

    /// Draws until the surface rests.
    fn rest(&mut self);

    /// Draws until no file is being read or written any more.
    fn wait_for_file(&mut self);

    /// Begins what the palette finds.
    fn begin(&mut self, words: &str);

    /// Does what the palette finds, and draws until the surface rests.
    fn act(&mut self, words: &str) {
        self.begin(words);
        self.rest();
    }

    #[track_caller]
    fn says(&self, words: &str) {
        let names = self.names();
        assert!(names.contains(words), "{words} in {names}");
    }

    #[track_caller]
    fn lacks(&self, words: &str) {
        let names = self.names();
        assert!(!names.contains(words), "{words} in {names}");
    }
}

impl Hand for Window {
    fn view(&self) -> &ViewState {
        self.state().state()
    }

    fn names(&self) -> String {
        let mut all = String::new();
        for node in self.root().children_recursive() {
            let node = node.accesskit_node();
            for words in [node.label(), node.value()].into_iter().flatten() {
                all.push_str(&words);
                all.push('\n');
            }
        }
        all
    }

    fn place(&self, words: &str) -> Rect {
        self.get_by_label_contains(words).rect()
    }

    fn place_of(&self, name: &str) -> Rect {
        self.get_by_label(name).rect()
    }

    fn name(&self, words: &str) -> String {
        let node = self.get_by_label_contains(words);
        node.accesskit_node().label().expect("a name")
    }

    fn hit(&mut self, name: &str) {
        self.get_by_label(name).click();
        self.run();
    }

    fn tap(&mut self, key: Key) {
        self.key_press(key);
        self.run();
    }

    fn write(&mut self, text: &str) {
        self.event(Event::Text(text.to_owned()));
        self.run();
    }

    fn write_over(&mut self, text: &str) {
        self.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.run();
        self.write(text);
    }

    fn field<'a>(&'a self, name: &'a str) -> Node<'a> {
        self.get_by_role_and_label(Role::SpinButton, name)
    }

    fn click_at(&mut self, at: Pos2) {
        self.drag_along(at, &[]);
    }

    fn drag_along(&mut self, from: Pos2, by: &[Vec2]) {
        self.hover_at(from);
        self.step();
        self.drag_at(from);
        self.step();
        for by in by {
            self.hover_at(from + *by);
            self.step();
        }
        self.drop_at(from + by.last().copied().unwrap_or_default());
        self.run();
    }

    fn rest(&mut self) {
        self.run_steps(4);
        let mut frames = 0;
        while self.view().run.is_busy() {
            self.step();
            frames += 1;
            assert!(frames < 3000, "it never comes to rest");
        }
    }

    fn wait_for_file(&mut self) {
        let begun = Instant::now();
        let busy = |notice: &String| notice.ends_with('…');
        while self.view().messages.notice.as_ref().is_some_and(busy) {
            assert!(begun.elapsed() < Duration::from_secs(60), "it ends");
            sleep(Duration::from_millis(2));
            self.step();
        }
        self.run();
    }

    fn begin(&mut self, words: &str) {
        self.key_press_modifiers(Modifiers::COMMAND, Key::K);
        self.rest();
        self.event(Event::Text(words.to_owned()));
        self.step();
        self.key_press(Key::Enter);
    }
}

/// What has a name that begins with these words.
pub fn named_from<'a>(window: &'a Window, words: &'a str) -> Option<Node<'a>> {
    let begins = |node: &Node<'_>| {
        let name = node.accesskit_node().label();
        name.is_some_and(|name| name.starts_with(words))
    };
    window.query_all_by_label_contains(words).find(begins)
}
