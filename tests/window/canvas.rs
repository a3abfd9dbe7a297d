//! What the window draws, as pixels: the toolkit's triangles filled on the processor, the same on
//! every machine, with no display and no graphics.

use egui::epaint::{ClippedPrimitive, Mesh, Primitive, Vertex};
use egui::{
    Color32, ColorImage, Context, FullOutput, ImageData, Rect, TextureFilter, TextureId,
    TextureOptions, TexturesDelta,
};
use egui_kittest::TestRenderer;
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

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
