//! What the examples share.

/// The project's `assets` folder, for [`AssetPlugin::file_path`](bevy::asset::AssetPlugin::file_path): the examples are a package of their own,
/// beside the assets and not above them.
pub fn assets_folder() -> String {
    // As cargo says when it runs us, which holds where a target folder is shared by clones; and as it was when this was compiled, for whoever
    // starts the binary by hand.
    let package = std::env::var("CARGO_MANIFEST_DIR");
    let package = package.unwrap_or_else(|_| env!("CARGO_MANIFEST_DIR").to_owned());
    format!("{package}/../assets")
}
