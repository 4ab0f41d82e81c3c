//! Embeds the pictures of a chapter as text.

use std::fs;
use std::path::Path;

/// One line for each picture in the chapter; `chapter` is a string literal, including its quotes.
pub(crate) fn definitions(chapter: &str) -> Result<String, String> {
    // Cargo sets this for the crate that is being compiled.
    let root = std::env::var("CARGO_MANIFEST_DIR").map_err(|fault| fault.to_string())?;
    let chapter = Path::new(&root).join("src/guide").join(chapter.trim_matches('"'));
    let read = |path: &Path| fs::read(path).map_err(|fault| format!("{}: {fault}", path.display()));
    let text = String::from_utf8_lossy(&read(&chapter)?).into_owned();
    let mut lines = String::new();
    for line in text.lines().filter(|line| line.starts_with('[')) {
        let Some((name, file)) = line.split_once("]: ") else { continue };
        if file.contains("://") {
            continue;
        }
        let kind = match file.rsplit_once('.') {
            Some((_, "jpg")) => "jpeg",
            Some((_, "png")) => "png",
            _ => return Err(format!("{file} is neither JPEG nor PNG")),
        };
        let picture = read(&chapter.with_file_name(file))?;
        lines += &format!("{name}]: data:image/{kind};base64,{}\n", base64(&picture));
    }
    // An empty line, so that the chapter's heading stays one.
    Ok(lines + "\n")
}

/// Base64 encoding.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * i)) as usize & 63] as char;
            text.push(if i <= three.len() { letter } else { '=' });
        }
    }
    text
}
