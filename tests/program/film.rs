//! Films: as many pictures as states, in the colours of the map, and nothing left where one is
//! given up.

use ndarray::Array2;
use std::fs::File;
use std::io::BufReader;
use tackscope::plot::colours::Colours;
use tackscope::storage::film::{FilmKind, Shot, write_film};

const COUNT: usize = 5;
const TOP: f64 = 2.0;

/// A gap that rises to the right, and with each picture.
fn shots() -> impl Iterator<Item = Shot> {
    (0..COUNT).map(|k| Shot {
        gap: Array2::from_shape_fn((64, 64), |(_, i)| 0.02 * i as f64 + 0.1 * k as f64),
        place: k as f64 / (COUNT - 1) as f64,
    })
}

/// Red, green and blue where the first picture has its point in this row and column.
fn wanted(row: usize, column: usize) -> [u8; 3] {
    let gap = shots().next().expect("a picture").gap[[row, column]];
    colorous::VIRIDIS.eval_continuous(gap / TOP).as_array()
}

/// Both colours, but for one of the 254 that the file has.
fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    (0..3).all(|k| a[k].abs_diff(b[k]) <= 2)
}

#[test]
fn a_gif_has_every_picture_in_the_colours_of_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    let mut shares = Vec::new();
    let film = (shots(), COUNT);
    write_film(
        &path,
        FilmKind::Gif,
        film,
        (TOP, Colours::default()),
        &mut |share| {
            shares.push(share);
            true
        },
    )
    .unwrap();
    assert_eq!(shares, [0.2, 0.4, 0.6, 0.8, 1.0]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut film = options.read_info(File::open(&path).unwrap()).unwrap();
    let (width, height) = (film.width() as usize, film.height() as usize);
    assert!(width >= 256 && height > width, "{width} {height}");
    let mut pictures = Vec::new();
    while let Some(frame) = film.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 5);
        pictures.push(frame.buffer.to_vec());
    }
    assert_eq!(pictures.len(), COUNT);
    for column in [0, 17, 40, 63] {
        let x = (2 * column + 1) * width / 128;
        let at = 4 * (10 * width + x);
        let seen = [0, 1, 2].map(|k| pictures[0][at + k]);
        assert!(is_near(seen, wanted(0, column)), "{column}: {seen:?}");
    }
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    // The bar's mark goes from the left to the right.
    let bright = |picture: &[u8]| {
        let row = &picture[4 * (height - 2) * width..][..4 * width];
        row.chunks(4).position(|p| p[0] == 255).expect("a mark")
    };
    let marks: Vec<usize> = pictures.iter().map(|picture| bright(picture)).collect();
    assert!(
        marks.is_sorted() && marks[0] < marks[COUNT - 1],
        "{marks:?}"
    );
}

#[test]
fn an_animated_png_has_every_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.png");
    let film = (shots(), COUNT);
    write_film(
        &path,
        FilmKind::Apng,
        film,
        (TOP, Colours::default()),
        &mut |_| true,
    )
    .unwrap();
    let decoder = png::Decoder::new(BufReader::new(File::open(&path).unwrap()));
    let mut film = decoder.read_info().unwrap();
    let told = film.info().animation_control.expect("it is animated");
    assert_eq!((told.num_frames as usize, told.num_plays), (COUNT, 0));
    let mut buffer = vec![0; film.output_buffer_size().unwrap()];
    let mut pictures = Vec::new();
    for _ in 0..COUNT {
        film.next_frame(&mut buffer).unwrap();
        pictures.push(buffer.clone());
    }
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn of_a_film_that_is_given_up_nothing_is_left_and_what_was_there_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.gif");
    std::fs::write(&path, "what was there").unwrap();
    let film = (shots(), COUNT);
    let end = write_film(
        &path,
        FilmKind::Gif,
        film,
        (TOP, Colours::default()),
        &mut |share| share < 0.5,
    );
    assert!(end.unwrap_err().to_string().contains("given up"));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "what was there");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let none = (std::iter::empty::<Shot>(), 0);
    let end = write_film(
        &path,
        FilmKind::Apng,
        none,
        (TOP, Colours::default()),
        &mut |_| true,
    );
    assert!(end.unwrap_err().to_string().contains("nothing to show"));
}
