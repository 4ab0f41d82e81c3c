//! The derive macro of `bevy_sinew`, which re-exports it, and the pictures of its guide. A crate of its own, because procedural macros must be. It has no
//! dependencies: parsing an enum without fields by hand takes less time than compiling a parser for all of Rust.

mod pictures;

use proc_macro::{Delimiter, Spacing, TokenStream, TokenTree};

/// Maximum number of layers: one bit each in a 32-bit mask.
const MAX_LAYERS: usize = 32;

/// Implements `bevy_sinew::CollisionLayer`: the variants are layers 0, 1, 2, … in the order of their declaration.
///
/// # Errors
/// Compilation fails for anything but an enum, for a generic enum, for variants with fields or discriminants, and unless there are 1 to 32 variants.
#[proc_macro_derive(CollisionLayer, attributes(default))]
pub fn collision_layer(input: TokenStream) -> TokenStream {
    let code = match layers(input) {
        Ok((name, variants)) => implementation(&name, &variants),
        Err(what) => format!("::core::compile_error!({what:?});"),
    };
    code.parse().unwrap_or_default()
}

/// The name of the enum, and those of its variants.
fn layers(input: TokenStream) -> Result<(String, Vec<String>), &'static str> {
    let mut tokens = input.into_iter();
    // Attributes and visibility precede the keyword.
    tokens
        .find(|token| matches!(token, TokenTree::Ident(word) if word.to_string() == "enum"))
        .ok_or("a collision layer is a variant of an enum")?;
    let Some(TokenTree::Ident(name)) = tokens.next() else {
        return Err("an enum has a name");
    };
    let Some(TokenTree::Group(body)) = tokens.next() else {
        return Err("an enum of collision layers has no parameters");
    };
    if body.delimiter() != Delimiter::Brace {
        return Err("an enum has variants");
    }
    let variants = variants(body.stream())?;
    if variants.is_empty() || variants.len() > MAX_LAYERS {
        return Err("there are 1 to 32 collision layers");
    }
    Ok((name.to_string(), variants))
}

fn variants(body: TokenStream) -> Result<Vec<String>, &'static str> {
    let mut names = Vec::new();
    let mut tokens = body.into_iter();
    while let Some(token) = tokens.next() {
        match token {
            // An attribute: `#` and a group.
            TokenTree::Punct(mark) if mark.as_char() == '#' && mark.spacing() == Spacing::Alone => {
                tokens.next();
            }
            TokenTree::Ident(name) => {
                names.push(name.to_string());
                match tokens.next() {
                    None => {}
                    Some(TokenTree::Punct(mark)) if mark.as_char() == ',' => {}
                    Some(_) => {
                        return Err("a collision layer has neither fields nor a number of its own");
                    }
                }
            }
            _ => return Err("a collision layer is a variant of an enum"),
        }
    }
    Ok(names)
}

fn implementation(name: &str, variants: &[String]) -> String {
    let arms = variants.iter().enumerate();
    let arms: String =
        arms.map(|(number, variant)| format!("Self::{variant} => {number},")).collect();
    format!(
        "impl ::bevy_sinew::CollisionLayer for {name} {{ fn number(&self) -> u32 {{ match self {{ {arms} }} }} }}"
    )
}

/// The pictures of a chapter, embedded for rustdoc, which copies no files: for each line `[name]: folder/file.jpg` of a Markdown file in `src/guide`, the same
/// line with the picture as a `data:` address. Insert the result before the chapter: of two definitions Markdown uses the first. Where the chapter is read as a
/// file, on a page of the repository or as mdBook, its own definitions apply.
///
/// # Errors
/// Compilation fails for a missing chapter or picture, and for a picture that is neither JPEG nor PNG.
#[doc(hidden)]
#[proc_macro]
pub fn pictures(input: TokenStream) -> TokenStream {
    let code = match pictures::definitions(&input.to_string()) {
        Ok(text) => format!("{text:?}"),
        Err(what) => format!("::core::compile_error!({what:?})"),
    };
    code.parse().unwrap_or_default()
}
