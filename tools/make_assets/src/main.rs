//! Writes the project's own assets. They are drawn and modelled by code, so each file has a readable source, a clear licence and the same bytes on every
//! machine; a test checks that the committed files are what this tool writes.

mod gltf;
mod paint;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::{fs, io};

use clap::Parser;

/// Writes the project's textures and models.
#[derive(Parser)]
struct Arguments {
    /// The folder to write into.
    #[arg(default_value = COMMITTED)]
    folder: PathBuf,
}

fn main() -> io::Result<()> {
    let folder = Arguments::parse().folder;
    for asset in ASSETS {
        let path = folder.join(asset.path);
        let bytes = (asset.bytes)();
        write(&path, &bytes)?;
        println!("{:>8} bytes  {}", bytes.len(), path.display());
    }
    Ok(())
}

/// A file under the assets folder, and the function that makes its contents.
struct Asset {
    path: &'static str,
    bytes: fn() -> Vec<u8>,
}

const ASSETS: [Asset; 5] = [
    Asset { path: "textures/flag.png", bytes: || paint::flag().to_png() },
    Asset { path: "textures/crate.png", bytes: || paint::crate_face().to_png() },
    Asset { path: "textures/ball.png", bytes: || paint::ball().to_png() },
    Asset { path: "props/lantern.glb", bytes: gltf::lantern },
    Asset { path: "props/banner.glb", bytes: gltf::banner },
];

/// Folder of the committed files, whatever the working directory is.
const COMMITTED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, bytes)
}
