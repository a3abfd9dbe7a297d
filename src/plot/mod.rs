//! Floor 5: the one diagram. A [`panel::Panel`] says what is shown; `storage` draws it into SVG and
//! PNG, the window with its own plot.
//!
//! [`loop_panel`], [`diagram_panel`] and [`chart_panel`] make panels of results, the figures of
//! `paper` make their own. [`style`] is the one code of colours, strokes and symbols,
//! [`panel::entries`] says what they are called, [`scale`] what an axis shows, where a value stands
//! on it and which numbers it bears, [`typeset`] how formulas in words are set. Stress over u0 has
//! x = u0/rho and y = stress/sigma_max, tension positive. May use `study` and below; no drawing,
//! files, or threads.

pub mod chart_panel;
pub mod curve;
pub mod diagram_panel;
pub mod loop_panel;
pub mod panel;
pub mod scale;
pub mod study_panel;
pub mod style;
pub mod typeset;
