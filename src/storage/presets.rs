//! Stub of branch `ui`.

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Name.
    pub name: &'static str,
    /// Scene file.
    pub text: &'static str,
}

static ALL: [Preset; 3] =
    [Preset { name: "fig2", text: "fig2" }, Preset { name: "fig3", text: "fig3" }, Preset { name: "tip", text: "tip" }];

/// All presets.
pub fn all() -> &'static [Preset] {
    &ALL
}

/// The preset of this name.
pub fn find(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|p| p.name == name)
}
