//! The surface in three dimensions.

use super::bench::fig2;
use super::stepped::{act, opened};
use egui::epaint::{ClippedShape, Mesh, Shape};
use egui::{Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use std::sync::Arc;
use tackscope::plot::style::Colours;
use tackscope::scene::Points;
use tackscope::ui::App;

/// The window with the tab open.
fn seen() -> Harness<'static, App> {
    let mut scene = fig2();
    scene.cell.points = Points::Square(32);
    let mut window = opened(scene);
    act(&mut window, "Tab: 3D");
    window
}

/// Ground and surface.
fn sheets(window: &Harness<'static, App>) -> [Arc<Mesh>; 2] {
    let area = window.get_by_label_contains("in three dimensions").rect();
    let sheet = |shape: &ClippedShape| match &shape.shape {
        Shape::Mesh(mesh)
            if area.contains_rect(mesh.calc_bounds()) && mesh.vertices.len() > 1000 =>
        {
            Some(mesh.clone())
        }
        _ => None,
    };
    let all: Vec<Arc<Mesh>> = window.output().shapes.iter().filter_map(sheet).collect();
    all.try_into().expect("ground and surface, within the tab")
}

/// By how many degrees it is turned, and from how high it is seen.
fn angles(window: &Harness<'static, App>) -> [i32; 2] {
    let node = window.get_by_label_contains("in three dimensions");
    let words = node.accesskit_node().label().expect("a sentence");
    let numbers = words
        .split_whitespace()
        .filter_map(|word| word.parse().ok());
    let numbers: Vec<i32> = numbers.collect();
    numbers.try_into().expect("two angles")
}

#[test]
fn the_surface_is_seen_in_three_dimensions_and_turned_by_a_drag_or_by_name() {
    let mut window = seen();
    let [turn, lift] = angles(&window);
    let area = window.get_by_label_contains("in three dimensions").rect();
    window.hover_at(area.center());
    window.step();
    window.drag_at(area.center());
    window.step();
    window.hover_at(area.center() + vec2(50.0, 30.0));
    window.step();
    window.step();
    window.drop_at(area.center() + vec2(50.0, 30.0));
    window.run();
    let [turned, lifted] = angles(&window);
    // A hundredth of a radian for each point, told in whole degrees.
    assert!((turned - turn - 29).abs() <= 1 && (lifted - lift - 17).abs() <= 1);
    act(&mut window, "3D: turn left");
    assert_eq!(angles(&window), [turned - 15, lifted]);
    for _ in 0..8 {
        act(&mut window, "3D: higher");
    }
    assert_eq!(
        angles(&window)[1],
        90,
        "from straight above, and no farther"
    );
    act(&mut window, "Restore layout");
    act(&mut window, "Tab: 3D");
    assert_eq!(angles(&window), [turn, lift]);
}

#[test]
fn a_flat_surface_lies_as_flat_as_the_ground_and_a_bulge_reaches_down_to_it() {
    let mut window = seen();
    let bounds = |window: &Harness<'static, App>| sheets(window).map(|sheet| sheet.calc_bounds());
    let [ground, flat] = bounds(&window);
    let same = |a: Rect, b: Rect| (a.size() - b.size()).length() < 0.5;
    assert!(
        same(ground, flat) && flat.bottom() < ground.bottom(),
        "{ground:?} {flat:?}"
    );
    act(&mut window, "3.0");
    assert!(!window.state().state().run.record.jumps.is_empty());
    let lowest = |mesh: &Mesh| {
        let ys = mesh.vertices.iter().map(|vertex| vertex.pos.y);
        ys.fold(f32::MIN, f32::max)
    };
    let [ground, bulge] = sheets(&window);
    // The pattern is in the middle of the cell: there the surface all but touches the ground.
    let middle = |mesh: &Mesh| mesh.vertices[mesh.vertices.len() / 2].pos;
    let gap = (middle(&ground) - middle(&bulge)).length();
    let apart = (ground.vertices[0].pos - bulge.vertices[0].pos).length();
    assert!(
        gap < 0.25 * apart && lowest(&bulge) <= lowest(&ground),
        "{gap} {apart}"
    );
    // In the colours of the map.
    let inks = |mesh: &Mesh| {
        mesh.vertices
            .iter()
            .map(|vertex| vertex.color)
            .collect::<Vec<_>>()
    };
    act(&mut window, "colours: as in the paper");
    assert_eq!(window.state().state().view.colours, Colours::Paper);
    assert_ne!(inks(&sheets(&window)[1]), inks(&bulge));
}
