//! What the examples share.

/// The project's `assets` folder, for [`AssetPlugin::file_path`](bevy::asset::AssetPlugin::file_path): the examples are a package of their own,
/// beside the assets and not above them.
pub fn assets_folder() -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../assets").to_owned()
}
