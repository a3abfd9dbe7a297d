//! Key screens, light and dark, large and small, drawn and held against the pictures in `screens`,
//! which somebody has looked at.
//!
//! TACKSCOPE_SCREENS=renew writes the pictures anew: look at what has changed before it is kept.
//!
//! The toolkit's triangles are filled on the processor: the same pixels on every machine, with no display
//! and no graphics.

use super::bench::fig2;
use super::hand::{Hand, Window, computing};
use super::stored::strip;
use egui::epaint::{ClippedPrimitive, Mesh, Primitive, Vertex};
use egui::{
    Color32, ColorImage, Context, FullOutput, ImageData, Key, Modifiers, Rect, TextureFilter,
    TextureId, TextureOptions, TexturesDelta, Theme, Vec2, vec2,
};
use egui_kittest::TestRenderer;
use egui_kittest::kittest::Queryable;
use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use tackscope::scene::Points;
use tackscope::ui::view_state::ViewState;

const SIZES: [[f32; 2]; 2] = [[1280.0, 800.0], [900.0, 600.0]];
/// What the harness leaves free around the window.
const MARGIN: f32 = 8.0;
/// Side of the squares of a picture whose mean colours are compared (its pixels, which are two of
/// the window), and by how much they may differ (of 255).
const SQUARE: u32 = 8;
const SHADE: f64 = 6.0;

struct Screen {
    window: Window,
    canvas: Canvas,
}

impl Screen {
    /// At rest a little before the first jump of Fig. 2, on so many points.
    fn on(points: usize) -> Self {
        let mut scene = fig2();
        scene.cell.points = Points::Square(points);
        let state = ViewState::at_first_jump(scene).expect("allowed");
        let canvas = Canvas::default();
        let window = computing(state, canvas.clone());
        Self { window, canvas }
    }

    /// After a loop, with this tab open.
    fn looped(tab: &str) -> Self {
        Self::on(48)
            .act("speed as fast")
            .click("Play loop")
            .open(tab)
    }

    fn press(mut self, modifiers: Modifiers, key: Key) -> Self {
        self.window.key_press_modifiers(modifiers, key);
        self.window.rest();
        self
    }

    /// Does what the palette finds.
    fn act(mut self, words: &str) -> Self {
        self.window.act(words);
        self
    }

    fn open(self, tab: &str) -> Self {
        self.act(&format!("Tab: {tab}"))
    }

    fn click(mut self, label: &str) -> Self {
        self.window.get_by_label(label).click();
        self.window.rest();
        self
    }

    /// What is seen at this size in this theme, at half its size. What a clock tells is left out.
    fn picture(&mut self, [width, height]: [f32; 2], theme: Theme) -> RgbImage {
        let window = &mut self.window;
        window.ctx.set_theme(theme);
        let zoom = window.ctx.zoom_factor();
        window.set_size(vec2(width, height) / zoom + Vec2::splat(2.0 * MARGIN));
        window.run_steps(6);
        let (ctx, output) = (&window.ctx, window.output());
        let mut picture = halved(&self.canvas.draw(ctx, output, MARGIN * zoom));
        let told = window.query_all_by_label_contains(" ms");
        // The width of the words changes with the digits of the clock.
        let whole = |rect: Rect| rect.with_max_x(rect.left() + (rect.width() / 64.0).ceil() * 64.0);
        let place = |rect: Rect| whole(rect).translate(Vec2::splat(-MARGIN)) * (zoom / 2.0);
        for place in told.map(|node| place(node.rect())) {
            for y in place.top() as u32..place.bottom() as u32 {
                for x in place.left() as u32..(place.right() as u32).min(picture.width()) {
                    picture.put_pixel(x, y, image::Rgb([128; 3]));
                }
            }
        }
        picture
    }
}

/// How to come to a screen.
type Way = fn() -> Screen;

/// Each under its name.
const SCREENS: [(&str, Way); 12] = [
    ("opening", || Screen::on(48)),
    ("why", || Screen::on(48).act("3.05")),
    ("loop", || Screen::looped("Events")),
    ("stored", || {
        let mut screen = Screen::looped("Equations");
        let (_, place) = strip(&screen.window);
        screen.window.click_at(place.lerp_inside(vec2(0.4, 0.75)));
        screen
    }),
    ("beside", || {
        let kept = Screen::looped("Loops").press(Modifiers::NONE, Key::L);
        kept.click("law cosine").act("A | B: compare").act("2.5")
    }),
    ("stability", || Screen::looped("Stability")),
    ("branches", || Screen::looped("Branches")),
    ("map", || Screen::on(32).open("Map")),
    ("ground", || {
        Screen::on(48).click("ground waves").open("Ground")
    }),
    ("lesson", || {
        Screen::on(48)
            .act("lesson first snap")
            .press(Modifiers::NONE, Key::Enter)
    }),
    ("lecture", || {
        Screen::looped("Why").press(Modifiers::NONE, Key::F11)
    }),
    ("gallery", || Screen::on(48).click("Preset")),
];

/// Each pixel the mean of four, in few colours, so that the files are small.
fn halved(picture: &ColorImage) -> RgbImage {
    let [width, height] = picture.size.map(|side| side as u32 / 2);
    RgbImage::from_fn(width, height, |x, y| {
        let corner = [2 * x as usize, 2 * y as usize];
        let four = [[0, 0], [1, 0], [0, 1], [1, 1]];
        let four = four.map(|[i, j]| picture[(corner[0] + i, corner[1] + j)].to_array());
        let mean = |k: usize| four.map(|c| u16::from(c[k])).iter().sum::<u16>() / 4;
        image::Rgb([0, 1, 2].map(|k| (mean(k) / 16 * 17) as u8))
    })
}

fn write(picture: &RgbImage, path: &Path) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
    picture.write_with_encoder(encoder).unwrap();
}

/// Where the mean colours of two pictures differ: the squares, from the upper left corner.
fn differing(a: &RgbImage, b: &RgbImage) -> Vec<[u32; 2]> {
    assert_eq!(a.dimensions(), b.dimensions());
    let (width, height) = a.dimensions();
    let mean = |picture: &RgbImage, [left, top]: [u32; 2], k: usize| {
        let (right, bottom) = ((left + SQUARE).min(width), (top + SQUARE).min(height));
        let square = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let shades = square.map(|(x, y)| f64::from(picture.get_pixel(x, y)[k]));
        shades.sum::<f64>() / f64::from((right - left) * (bottom - top))
    };
    let corners = (0..height).step_by(SQUARE as usize);
    let corners = corners.flat_map(|y| (0..width).step_by(SQUARE as usize).map(move |x| [x, y]));
    let differs = |at: &[u32; 2]| (0..3).any(|k| (mean(a, *at, k) - mean(b, *at, k)).abs() > SHADE);
    corners.filter(differs).collect()
}

fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/window/screens")
}

#[test]
fn the_key_screens_look_as_they_did_when_they_were_looked_at() {
    let renews = std::env::var("TACKSCOPE_SCREENS").is_ok_and(|value| value == "renew");
    let found = Path::new(env!("CARGO_TARGET_TMPDIR")).join("screens");
    std::fs::create_dir_all(&found).unwrap();
    let mut other = Vec::new();
    for (name, lead) in SCREENS {
        let mut screen = lead();
        for size in SIZES {
            for theme in [Theme::Light, Theme::Dark] {
                let picture = screen.picture(size, theme);
                let file = format!("{name}-{}-{theme:?}.png", size[0]).to_lowercase();
                let path = kept().join(&file);
                if renews {
                    write(&picture, &path);
                }
                let before = image::open(&path).map(|before| before.to_rgb8());
                let before = before.unwrap_or_else(|why| panic!("{}: {why}", path.display()));
                let squares = differing(&picture, &before);
                if !squares.is_empty() {
                    write(&picture, &found.join(&file));
                    other.push(format!(
                        "{file}: {} squares, first {:?}",
                        squares.len(),
                        squares[0]
                    ));
                }
            }
        }
    }
    assert!(
        other.is_empty(),
        "{other:#?}; as they are now in {}; if that is right, TACKSCOPE_SCREENS=renew",
        found.display()
    );
}

#[test]
fn what_moves_or_vanishes_is_noticed_and_the_shade_of_an_edge_is_not() {
    let screen = &mut Screen::on(48);
    let before = screen.picture(SIZES[0], Theme::Light);
    assert_eq!(differing(&before, &before), [[0; 2]; 0]);
    // A column of pixels a little darker, as an edge between two pixels would be.
    let mut shaded = before.clone();
    for y in 0..shaded.height() {
        let pixel = shaded.get_pixel_mut(200, y);
        pixel.0 = pixel.0.map(|c| c.saturating_sub(40));
    }
    assert_eq!(differing(&before, &shaded), [[0; 2]; 0]);
    // The panel on the left two of its pixels further down.
    let mut moved = before.clone();
    for y in (32..moved.height()).rev() {
        for x in 0..120 {
            moved.put_pixel(x, y, *before.get_pixel(x, y - 2));
        }
    }
    assert!(differing(&before, &moved).len() > 50);
    // One word is gone.
    let word = screen.window.place_of("Reset");
    let mut without = before.clone();
    for y in (word.top() / 2.0) as u32..(word.bottom() / 2.0) as u32 {
        for x in (word.left() / 2.0) as u32..(word.right() / 2.0) as u32 {
            without.put_pixel(x, y, *before.get_pixel((word.left() / 2.0) as u32 + 1, y));
        }
    }
    assert!(!differing(&before, &without).is_empty());
}

/// Parts of a pixel in which corners are placed, so that triangles which share an edge share no
/// pixel.
const PARTS: f32 = 256.0;

/// The textures of a window, kept while it runs.
#[derive(Clone, Default)]
pub struct Canvas(Rc<RefCell<HashMap<TextureId, (ColorImage, TextureOptions)>>>);

impl TestRenderer for Canvas {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut textures = self.0.borrow_mut();
        for (id, patches) in std::mem::take(&mut delta.set) {
            for patch in patches {
                let ImageData::Color(image) = patch.image;
                let Some([left, top]) = patch.pos else {
                    textures.insert(id, ((*image).clone(), patch.options));
                    continue;
                };
                let (whole, _) = textures.get_mut(&id).expect("a texture before its patch");
                let [width, height] = image.size;
                for y in 0..height {
                    for x in 0..width {
                        whole[(left + x, top + y)] = image[(x, y)];
                    }
                }
            }
        }
        // What is freed may still be a part of this frame.
        delta.free.clear();
    }
}

impl Canvas {
    /// The picture of a frame, `margin` pixels left out at each side.
    pub fn draw(&self, ctx: &Context, output: &FullOutput, margin: f32) -> ColorImage {
        let (zoom, textures) = (output.pixels_per_point, self.0.borrow());
        let whole = (ctx.content_rect() * zoom).shrink(margin);
        let size = whole.size().round();
        let ground = ctx.global_style().visuals.panel_fill;
        let mut picture = ColorImage::filled([size.x as usize, size.y as usize], ground);
        for ClippedPrimitive {
            clip_rect,
            primitive,
        } in ctx.tessellate(output.shapes.clone(), zoom)
        {
            let Primitive::Mesh(mut mesh) = primitive else {
                panic!("the window draws triangles alone");
            };
            let (texture, options) = &textures[&mesh.texture_id];
            let look = |uv: [f32; 2]| sample(texture, options.magnification, uv);
            for vertex in &mut mesh.vertices {
                vertex.pos = vertex.pos * zoom - whole.min.to_vec2();
            }
            let clip = (clip_rect * zoom)
                .intersect(whole)
                .translate(-whole.min.to_vec2());
            fill(&mut picture, &mesh, clip, look);
        }
        picture
    }
}

/// The colour of a texture at a place of it.
fn sample(texture: &ColorImage, filter: TextureFilter, [u, v]: [f32; 2]) -> [f32; 4] {
    let [width, height] = texture.size;
    let texel = |x: f32, y: f32| {
        let x = (x.max(0.0) as usize).min(width - 1);
        let y = (y.max(0.0) as usize).min(height - 1);
        texture[(x, y)].to_array().map(f32::from)
    };
    let (x, y) = (u * width as f32, v * height as f32);
    if filter == TextureFilter::Nearest {
        return texel(x.floor(), y.floor());
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (across, down) = (x - left, y - top);
    let mix = |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
    let upper = mix(texel(left, top), texel(left + 1.0, top), across);
    let lower = mix(texel(left, top + 1.0), texel(left + 1.0, top + 1.0), across);
    mix(upper, lower, down)
}

/// Fills the triangles of a mesh within `clip`.
fn fill(picture: &mut ColorImage, mesh: &Mesh, clip: Rect, look: impl Fn([f32; 2]) -> [f32; 4]) {
    // Pixels whose middles lie inside.
    let first = |edge: f32| (edge.round().max(0.0)) as i64;
    let bounds = [
        first(clip.left()),
        first(clip.top()),
        first(clip.right()),
        first(clip.bottom()),
    ];
    for corners in mesh.indices.chunks_exact(3) {
        let corners = [0, 1, 2].map(|i| mesh.vertices[corners[i] as usize]);
        triangle(picture, corners, bounds, &look);
    }
}

/// Twice the area to the left of the way from a to b, as seen from p.
fn edge(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

fn triangle(
    picture: &mut ColorImage,
    mut corners: [Vertex; 3],
    [left, top, right, bottom]: [i64; 4],
    look: &impl Fn([f32; 2]) -> [f32; 4],
) {
    let place = |v: &Vertex| [v.pos.x, v.pos.y].map(|c| (c * PARTS).round() as i64);
    let mut at = [0, 1, 2].map(|i| place(&corners[i]));
    let mut area = edge(at[0], at[1], at[2]);
    if area < 0 {
        corners.swap(1, 2);
        at.swap(1, 2);
        area = -area;
    }
    if area == 0 {
        return;
    }
    let parts = PARTS as i64;
    let range = |k: usize, low: i64, high: i64| {
        let all = at.map(|p| p[k]);
        let (least, most) = (
            all.into_iter().min().unwrap(),
            all.into_iter().max().unwrap(),
        );
        (least.div_euclid(parts)).max(low)..(most.div_euclid(parts) + 1).min(high)
    };
    // A pixel on an edge belongs to the triangle on one side of it.
    let owns = |a: [i64; 2], b: [i64; 2]| i64::from(b[1] < a[1] || (b[1] == a[1] && b[0] > a[0]));
    let sides = [(1, 2), (2, 0), (0, 1)].map(|(a, b)| (at[a], at[b], 1 - owns(at[a], at[b])));
    let colours = corners.map(|v| v.color.to_array().map(f32::from));
    let plain = corners.iter().all(|v| v.uv == corners[0].uv);
    let flat = plain.then(|| look([corners[0].uv.x, corners[0].uv.y]));
    for y in range(1, top, bottom) {
        for x in range(0, left, right) {
            let middle = [x * parts + parts / 2, y * parts + parts / 2];
            let inside = sides.map(|(a, b, least)| (edge(a, b, middle), least));
            if inside.iter().any(|(side, least)| side < least) {
                continue;
            }
            let share = inside.map(|(side, _)| side as f32 / area as f32);
            let blend = |of: [f32; 3]| of[0] * share[0] + of[1] * share[1] + of[2] * share[2];
            let ink = flat.unwrap_or_else(|| {
                look([
                    blend(corners.map(|v| v.uv.x)),
                    blend(corners.map(|v| v.uv.y)),
                ])
            });
            let ink: [f32; 4] =
                std::array::from_fn(|i| ink[i] * blend(colours.map(|c| c[i])) / 255.0);
            let pixel = &mut picture[(x as usize, y as usize)];
            let under = pixel.to_array().map(f32::from);
            let over: [u8; 4] =
                std::array::from_fn(|i| (ink[i] + under[i] * (1.0 - ink[3] / 255.0)).round() as u8);
            *pixel = Color32::from_rgba_premultiplied(over[0], over[1], over[2], 255);
        }
    }
}
