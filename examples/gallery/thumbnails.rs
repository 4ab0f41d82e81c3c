//! Thumbnails of the scenes for the list of the gallery: one sheet, which the gallery itself draws (`--thumbnails`), and a file with the scene's name for each
//! tile.

use std::path::Path;

use sinew_draw::{Image, read_png, write_small_png};

/// Size of a tile, pixels.
pub(crate) const TILE: [usize; 2] = [160, 100];
/// Tiles in a row of the sheet.
const COLUMNS: usize = 10;

const SHEET: &[u8] = include_bytes!("thumbnails.png");
const NAMES: &str = include_str!("thumbnails.txt");

/// The sheet stored in the repository.
pub(crate) fn sheet() -> Option<Image> {
    read_png(SHEET).ok()
}

/// The top left corner of a scene's tile on the sheet, column and row in pixels; `None` for a scene without one.
pub(crate) fn place_of(name: &str) -> Option<[usize; 2]> {
    NAMES.lines().position(|line| line == name).map(corner)
}

fn corner(i: usize) -> [usize; 2] {
    [i % COLUMNS * TILE[0], i / COLUMNS * TILE[1]]
}

/// Writes a sheet with the given tiles, and their names beside it as `.txt`. Scenes without a given tile keep the tile of the existing file.
pub(crate) fn write(file: &Path, tiles: &[(&str, Image)]) -> std::io::Result<()> {
    let names = file.with_extension("txt");
    let old = std::fs::read(file).ok().and_then(|bytes| read_png(&bytes).ok());
    let old_names = std::fs::read_to_string(&names).unwrap_or_default();
    let tile = |name: &str| {
        if let Some((_, tile)) = tiles.iter().find(|(its, _)| *its == name) {
            return Some(tile.clone());
        }
        let [left, top] = old_names.lines().position(|line| line == name).map(corner)?;
        let sheet = old.as_ref()?;
        let fits = left + TILE[0] <= sheet.width && top + TILE[1] <= sheet.height;
        fits.then(|| sheet.part([left, top], TILE[0], TILE[1]))
    };
    let all = sinew_scenes::ALL.iter().map(|scene| scene.name);
    let all: Vec<_> = all.filter_map(|name| Some((name, tile(name)?))).collect();
    let rows = all.len().div_ceil(COLUMNS).max(1);
    let mut sheet = Image::new(COLUMNS * TILE[0], rows * TILE[1], [70, 76, 86, 255]);
    let mut list = String::new();
    for (i, (name, tile)) in all.iter().enumerate() {
        sheet.place(tile, corner(i));
        list += name;
        list += "\n";
    }
    write_small_png(file, &sheet)?;
    std::fs::write(names, list)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene without a thumbnail is a grey tile in the list: `gallery --thumbnails examples/gallery/thumbnails.png --scene NAME` draws it.
    #[test]
    fn every_scene_has_its_place_on_the_sheet() {
        let sheet = sheet().expect("a PNG");
        let mut missing = Vec::new();
        for scene in sinew_scenes::ALL {
            let drawn = place_of(scene.name).is_some_and(|[left, top]| {
                let fits = left + TILE[0] <= sheet.width && top + TILE[1] <= sheet.height;
                // More than one colour: the tile is not empty.
                fits && {
                    let tile = sheet.part([left, top], TILE[0], TILE[1]);
                    tile.pixels.iter().any(|pixel| *pixel != tile.pixels[0])
                }
            });
            if !drawn {
                missing.push(scene.name);
            }
        }
        assert!(missing.is_empty(), "no thumbnail: {missing:?}");
        let gone = |name: &&str| sinew_scenes::find(name).is_none();
        assert_eq!(NAMES.lines().find(gone), None, "a thumbnail of a scene that does not exist");
    }

    #[test]
    fn a_sheet_keeps_the_tiles_that_are_not_drawn_anew() {
        let file = std::env::temp_dir().join(format!("sinew_sheet_{}.png", std::process::id()));
        let tile = |color| Image::new(TILE[0], TILE[1], color);
        let (red, blue) = ([200, 30, 30, 255], [30, 30, 200, 255]);
        let [first, second] = [sinew_scenes::ALL[0].name, sinew_scenes::ALL[1].name];
        write(&file, &[(second, tile(red))]).expect("a sheet of one");
        write(&file, &[(first, tile(blue))]).expect("a sheet of two");
        let names = std::fs::read_to_string(file.with_extension("txt")).expect("names");
        assert_eq!(names, format!("{first}\n{second}\n"));
        let sheet = read_png(&std::fs::read(&file).expect("a file")).expect("a PNG");
        let [r, _, b, _] = sheet.at(TILE[0] + 5, 5);
        assert!(r > 150 && b < 80, "the second is still red: {r} {b}");
        let _ = std::fs::remove_file(file.with_extension("txt"));
        let _ = std::fs::remove_file(file);
    }
}
