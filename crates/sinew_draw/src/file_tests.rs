//! Round trips of images through files.

use std::{fs::File, io::BufReader, path::PathBuf};

use super::*;

/// An image in which no two neighbouring pixels are equal.
fn speckled(width: usize, height: usize) -> Image {
    let mut image = Image::new(width, height, [0, 0, 0, 255]);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        *pixel = [i as u8, (i / 7) as u8, (i * 13) as u8, 255];
    }
    image
}

#[test]
fn a_png_reads_back_as_it_was() {
    let image = speckled(40, 30);
    let path = scratch("picture.png");
    write_png(&path, &image).unwrap();
    let mut reader =
        png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (40, 30));
    assert_eq!(bytes, image.pixels.as_flattened());
}

#[test]
fn a_png_of_few_colours_reads_back_as_it_was() {
    let mut image = Image::new(40, 30, [200, 40, 40, 255]);
    image.place(&Image::new(10, 10, [40, 40, 200, 255]), [5, 7]);
    let path = scratch("small.png");
    write_small_png(&path, &image).unwrap();
    let read = read_png(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!((read.width, read.height), (40, 30));
    let apart = |a: &[u8; 4], b: &[u8; 4]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
    let most = read.pixels.iter().zip(&image.pixels).filter_map(|(a, b)| apart(a, b)).max();
    assert!(most.unwrap() <= 4, "a palette may be off by a step or two: {most:?}");
    assert_eq!(read_png(&std::fs::read(&path).unwrap()[..40]).ok(), None);
}

#[test]
fn a_picture_shrinks_by_the_light_of_its_pixels() {
    let mut image = Image::new(4, 2, [255, 255, 255, 255]);
    image.place(&Image::new(1, 2, [0, 0, 0, 255]), [0, 0]);
    let small = image.shrunk(2);
    assert_eq!((small.width, small.height), (2, 1));
    // Half the light of white is 188 in sRGB, not 128.
    assert_eq!(small.pixels, [[188, 188, 188, 255], [255, 255, 255, 255]]);
    assert_eq!(image.part([0, 1], 2, 1).pixels, [[0, 0, 0, 255], [255, 255, 255, 255]]);
}

#[test]
fn a_gif_has_all_its_frames_and_repeats() {
    let mut frames = vec![Image::new(20, 10, [200, 200, 210, 255]); 5];
    for (i, frame) in frames.iter_mut().enumerate().skip(2) {
        frame.pixels[i * 21] = [250, 20, 20, 255];
    }
    let path = scratch("film.gif");
    write_gif(&path, &frames, 4).unwrap();
    let mut decoder = gif::DecodeOptions::new().read_info(File::open(&path).unwrap()).unwrap();
    let mut count = 0;
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 4);
        count += 1;
    }
    assert_eq!(count, 5);
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    assert!(write_gif(&path, &[], 4).is_err());
    assert!(write_gif(&path, &[Image::new(2, 2, [0; 4]), Image::new(3, 2, [0; 4])], 4).is_err());
}

#[test]
fn a_sheet_holds_its_frames() {
    let frames: Vec<_> =
        (0..3).map(|i| (format!("{i} s"), Image::new(60, 40, [10, 20, 30, 255]))).collect();
    let sheet = contact_sheet("A title that is too long for a small page", "below", &frames, 2);
    let dark = sheet.pixels.iter().filter(|p| **p == [10, 20, 30, 255]).count();
    assert!((3 * 2000..3 * 2400).contains(&dark), "three pictures less their corners: {dark}");
    assert!(sheet.width > 120 && sheet.height > 80);
    assert!(contact_sheet("Nothing", "", &[], 3).width > 0);
}

/// A temporary file of this test run.
fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sinew_draw_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}
