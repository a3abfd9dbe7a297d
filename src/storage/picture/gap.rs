//! The gap field as an image: viridis, contact dark.

use super::write_png;
use crate::storage::Failure;
use image::{Rgb, RgbImage};
use ndarray::Array2;
use std::path::Path;

/// Least width and height of the image, in pixels.
const SIDE_MIN: usize = 256;

/// Contrast below this share of the largest gap is not shown: it is the tolerance of the solver,
/// not a pattern.
const CONTRAST_MIN: f64 = 1e-3;

/// Smallest and largest gap of a picture's colours.
pub type Scale = (f64, f64);

/// The scale that shows all these gaps in the same colours.
pub fn common_scale<'a>(gaps: impl IntoIterator<Item = &'a Array2<f64>>) -> Scale {
    let finite = gaps
        .into_iter()
        .flat_map(|gap| gap.iter().copied())
        .filter(|g| g.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), g| {
        (low.min(g), high.max(g))
    })
}

/// Writes the gap as a PNG in colours of its own: smallest gap dark, largest bright; y points up.
///
/// # Errors
/// A file that cannot be written.
pub fn write_gap_png(path: &Path, gap: &Array2<f64>) -> Result<(), Failure> {
    write_gap_png_scaled(path, gap, common_scale([gap]))
}

/// Writes the gap as a PNG in the colours of `scale`, so that several pictures can be compared.
///
/// # Errors
/// A file that cannot be written.
pub fn write_gap_png_scaled(path: &Path, gap: &Array2<f64>, scale: Scale) -> Result<(), Failure> {
    write_png(path, &gap_image(gap, scale))
}

/// The image of [`write_gap_png_scaled`]: each point a square of equal pixels, at least 256 pixels
/// a side. A line cell becomes a band; values that are not finite are red.
pub fn gap_image(gap: &Array2<f64>, (low, high): Scale) -> RgbImage {
    let (rows, columns) = gap.dim();
    let across = SIDE_MIN.div_ceil(columns.max(1)) as u32;
    let up = if rows == 1 {
        (across * columns as u32).div_ceil(4)
    } else {
        across
    };
    let points = gap_pixels(gap, (low, high));
    RgbImage::from_fn(columns as u32 * across, rows as u32 * up, |x, y| {
        *points.get_pixel(x / across, y / up)
    })
}

/// The same with one pixel for each point.
pub(in crate::storage) fn gap_pixels(gap: &Array2<f64>, (low, high): Scale) -> RgbImage {
    let (rows, columns) = gap.dim();
    // Without contrast there is no pattern to show: dark, as contact is.
    let span = if high - low > CONTRAST_MIN * low.abs().max(high.abs()) {
        high - low
    } else {
        f64::INFINITY
    };
    RgbImage::from_fn(columns as u32, rows as u32, |x, y| {
        let g = gap[[rows - 1 - y as usize, x as usize]];
        if !g.is_finite() {
            return Rgb([255, 0, 0]);
        }
        let colour = colorous::VIRIDIS.eval_continuous(((g - low) / span).clamp(0.0, 1.0));
        Rgb([colour.r, colour.g, colour.b])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    fn own_colours(gap: &Array2<f64>) -> RgbImage {
        gap_image(gap, common_scale([gap]))
    }

    #[test]
    fn contact_is_dark_and_y_points_up() {
        let image = own_colours(&array![[0.0, 1.0], [2.0, 3.0]]);
        assert_eq!(image.dimensions(), (256, 256));
        let brightness = |x, y| {
            image
                .get_pixel(x, y)
                .0
                .iter()
                .map(|c| u32::from(*c))
                .sum::<u32>()
        };
        assert!(
            brightness(0, 255) < brightness(255, 0),
            "the smallest gap, first row, is the darkest and lies at the bottom"
        );
    }

    #[test]
    fn line_cells_uniform_gaps_and_nan_make_pictures_too() {
        assert_eq!(own_colours(&Array2::zeros((1, 64))).dimensions(), (256, 64));
        assert_eq!(
            own_colours(&Array2::zeros((300, 300))).dimensions(),
            (300, 300)
        );
        assert_eq!(
            own_colours(&array![[f64::NAN, 1.0]]).get_pixel(0, 0),
            &Rgb([255, 0, 0])
        );
    }
}
