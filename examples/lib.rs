//! Code shared by the examples.

/// The path of the repository's `assets` folder, for [`AssetPlugin::file_path`](bevy::asset::AssetPlugin::file_path): the examples are a package of their own
/// beside that folder, so Bevy's default path does not find it.
pub fn assets_folder() -> String {
    // Cargo sets the variable at run time, which is right even where clones share one target folder. A binary started by hand falls back to the path at compile
    // time.
    let package = std::env::var("CARGO_MANIFEST_DIR");
    let package = package.unwrap_or_else(|_| env!("CARGO_MANIFEST_DIR").to_owned());
    format!("{package}/../assets")
}
