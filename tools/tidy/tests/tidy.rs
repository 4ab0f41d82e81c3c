//! The rules of the repository as tests: those that a reviewer would have to remember and no compiler lint checks.
//!
//! Each test lists all violations at once, each as `file:line: what to do`. A rule that prevents a good change is changed here, with its reason, rather than
//! worked around. `CONTRIBUTING.md` explains the reasons for the rules.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Longest allowed file, lines: about as much as a reader keeps in mind.
const MOST_LINES: usize = 800;

/// The only folder in which `unsafe` is allowed.
const LANES: &str = "crates/sinew/src/lanes/";

/// Folders of code that computes results, which must be the same bits on every machine.
const STATE: [&str; 2] = ["crates/sinew/src/", "crates/bevy_sinew/src/"];

/// Methods of `f32`, `f64` and `glam` that call the platform's maths library, or that the compiler may round in more than one way.
const PLATFORM_MATHS: [&str; 45] = [
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sin_cos",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "exp",
    "exp2",
    "exp_m1",
    "ln",
    "ln_1p",
    "log",
    "log2",
    "log10",
    "powf",
    "powi",
    "cbrt",
    "hypot",
    "mul_add",
    "slerp",
    "rotate_towards",
    "angle_between",
    "angle_to",
    "to_axis_angle",
    "to_scaled_axis",
    "to_euler",
    "from_axis_angle",
    "from_scaled_axis",
    "from_rotation_x",
    "from_rotation_y",
    "from_rotation_z",
    "from_euler",
    "from_angle",
    "from_rotation_axis",
    "rotate_x",
    "rotate_y",
    "rotate_z",
];

/// Collections without a fixed iteration order.
const UNORDERED: [&str; 6] =
    ["HashMap", "HashSet", "EntityHashMap", "EntityHashSet", "TypeIdMap", "TypeIdSet"];

/// Exceptions: file, word, and the reason why it is harmless there.
const ALLOWED: [(&str, &str, &str); 7] = [
    (
        "crates/bevy_sinew/src/rows.rs",
        "EntityHashMap",
        "only looked up by entity; the order in which `retain` iterates has no effect",
    ),
    (
        "crates/bevy_sinew/src/show/ease.rs",
        "slerp",
        "used only for drawing between ticks, which is never read back",
    ),
    ("crates/bevy_sinew/src/breaking.rs", "EntityHashSet", "only tested for an entity"),
    ("crates/bevy_sinew/src/state/values.rs", "EntityHashMap", "only looked up by entity"),
    ("crates/bevy_sinew/src/state/snapshot.rs", "EntityHashMap", "only looked up by entity"),
    (
        "crates/bevy_sinew/src/state/restore.rs",
        "EntityHashMap",
        "only looked up by entity; Bevy's own maps of entities have this type",
    ),
    (
        "crates/bevy_sinew/src/state/rollback.rs",
        "EntityHashMap",
        "iterated only to build another map, which is looked up by entity",
    ),
];

/// A text file of the repository.
struct File {
    /// Path from the root, with `/`.
    path: String,
    text: String,
}

impl File {
    fn is_rust(&self) -> bool {
        self.path.ends_with(".rs")
    }

    /// Lines of [bare] code with their numbers, without code that is compiled for tests only.
    ///
    /// Relies on rustfmt's layout: an item ends with `}` at the indentation of its attribute.
    fn code(&self) -> Vec<(usize, String)> {
        let mut code = Vec::new();
        let mut lines = (1..).zip(self.text.lines());
        while let Some((number, line)) = lines.next() {
            if line.trim_start() == "#[cfg(test)]" {
                let indent = &line[..line.len() - line.trim_start().len()];
                let closes = |l: &str| {
                    l.strip_prefix(indent)
                        .is_some_and(|l| l == "}" || l.ends_with(';') && !l.starts_with(' '))
                };
                let _ = lines.by_ref().find(|(_, l)| closes(l));
            } else {
                code.push((number, bare(line)));
            }
        }
        code
    }

    /// Whether the whole file is a test module.
    fn is_test(&self) -> bool {
        self.path.contains("/tests/") || self.path.ends_with("tests.rs")
    }
}

fn root() -> PathBuf {
    // Read when the test runs: a target folder may be shared by clones, and cargo does not rebuild for that.
    let package = std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo says where it is");
    PathBuf::from(package).join("../..").canonicalize().expect("the repository has a root")
}

/// Finds all text files below a folder, without generated ones.
fn files(folder: &Path, found: &mut Vec<File>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .expect("a folder can be read")
        .flatten()
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let generated = ["target", ".git", "gallery_out", "corpus", "artifacts", "coverage"];
        // In a worktree `.git` is a file.
        if generated.contains(&name.as_str()) {
            continue;
        }
        if path.is_dir() {
            files(&path, found);
        } else if let Ok(text) = fs::read_to_string(&path) {
            let path = path.strip_prefix(root()).expect("it is below the root");
            found.push(File { path: path.to_string_lossy().replace('\\', "/"), text });
        }
    }
}

fn repository() -> Vec<File> {
    let mut found = Vec::new();
    files(&root(), &mut found);
    assert!(found.len() > 50, "the walk did not find the repository");
    found
}

/// A line of code without its comment and without the contents of its strings.
fn bare(line: &str) -> String {
    let (mut code, mut quoted, mut before) = (String::new(), false, ' ');
    for c in line.chars() {
        let quote = c == '"' && before != '\\' && before != '\'';
        if !quoted && (before, c) == ('/', '/') {
            code.pop();
            break;
        }
        if quote {
            quoted = !quoted;
        } else if !quoted {
            code.push(c);
        }
        before = if (before, c) == ('\\', '\\') { ' ' } else { c };
    }
    code
}

/// The words of a line: runs of letters, digits and `_`.
fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !(c.is_alphanumeric() || c == '_'))
}

fn assert_none(offences: &[String]) {
    assert!(offences.is_empty(), "\n{}\n", offences.join("\n"));
}

#[test]
fn every_file_opens_with_why_it_is_there() {
    let silent = repository().into_iter().filter(|f| f.is_rust() && !f.text.starts_with("//! "));
    assert_none(
        &silent
            .map(|f| format!("{}:1: start the file with `//! ` and its purpose", f.path))
            .collect::<Vec<_>>(),
    );
}

#[test]
fn no_file_is_too_long() {
    let lines = |f: File| (f.text.lines().count(), f);
    let long =
        repository().into_iter().filter(File::is_rust).map(lines).filter(|(n, _)| *n > MOST_LINES);
    assert_none(
        &long
            .map(|(n, f)| {
                format!(
                    "{}:{MOST_LINES}: {n} lines; split it by topic, at most {MOST_LINES}",
                    f.path
                )
            })
            .collect::<Vec<_>>(),
    );
}

#[test]
fn unsafe_stays_in_the_lanes() {
    let mut offences = Vec::new();
    for file in repository().iter().filter(|f| f.is_rust() && !f.path.starts_with(LANES)) {
        for (number, line) in (1..).zip(file.text.lines()) {
            let code = bare(line);
            let keyword = words(&code).any(|word| word == "unsafe");
            let lifted = ["allow(", "expect("].iter().any(|by| code.contains(by))
                && code.contains("unsafe_code");
            if keyword || lifted {
                offences.push(format!("{}:{number}: `unsafe` belongs in {LANES}", file.path));
            }
        }
    }
    assert_none(&offences);
}

/// Violations by words of a list in the code that computes results.
fn state_without(
    list: &[&str],
    is_offence: impl Fn(&str, &str) -> bool,
    advice: &str,
) -> Vec<String> {
    let mut offences = Vec::new();
    let makes_results = |f: &&File| f.is_rust() && STATE.iter().any(|s| f.path.starts_with(s));
    for file in repository().iter().filter(makes_results).filter(|f| !f.is_test()) {
        for (number, line) in file.code() {
            for word in list.iter().filter(|word| is_offence(&line, word)) {
                if !ALLOWED.iter().any(|(path, allowed, _)| *path == file.path && allowed == word) {
                    offences.push(format!("{}:{number}: `{word}`: {advice}", file.path));
                }
            }
        }
    }
    offences
}

/// Whether a line calls a method or an associated function of that name; calls of `libm` are allowed.
fn calls(line: &str, name: &str) -> bool {
    let by = |by: &str| {
        let call = format!("{by}{name}(");
        line.match_indices(&call).any(|(at, _)| !line[..at].ends_with("libm"))
    };
    by(".") || by("::")
}

#[test]
fn results_do_not_depend_on_the_platforms_maths() {
    let advice = "differs from one machine to the next; use `libm::` (or plain + - × ÷ √)";
    assert_none(&state_without(&PLATFORM_MATHS, calls, advice));
    let fused = ["fmadd", "fmsub", "fnmadd", "vfma", "rsqrt", "rcp_ps", "rcp14"];
    let advice = "rounds differently from the scalar operation; use + - × ÷ √";
    assert_none(&state_without(&fused, |line, word| line.contains(word), advice));
}

#[test]
fn results_do_not_depend_on_the_order_of_a_hash() {
    let named = |line: &str, name: &str| words(line).any(|word| word == name);
    let advice = "has no fixed iteration order; use a `Vec`, a `BTreeMap`, or sort, or add it to ALLOWED \
                  with a reason if nothing iterates over it";
    assert_none(&state_without(&UNORDERED, named, advice));
}

#[test]
fn modules_of_a_crate_know_each_other_one_way() {
    let mut offences = Vec::new();
    for package in
        ["sinew", "bevy_sinew", "sinew_panel", "sinew_scenes", "sinew_report", "sinew_bench"]
    {
        let arrows = arrows(&format!("crates/{package}/src/"));
        assert!(!arrows.is_empty(), "{package} has no modules: was it moved?");
        for from in arrows.keys() {
            if let Some(way) = way_back(&arrows, from) {
                let steps = way
                    .windows(2)
                    .map(|pair| format!("{} (in {})", pair[1], arrows[pair[0]][pair[1]]));
                offences.push(format!(
                    "crates/{package}: `{from}` depends on itself: {from} > {}; move what both use into a module below them",
                    steps.collect::<Vec<_>>().join(" > ")
                ));
            }
        }
    }
    assert_none(&offences);
}

/// The top-level modules of a crate, with the modules that each names and one file that does. Tests are exempt.
fn arrows(folder: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut arrows = BTreeMap::<_, BTreeMap<_, _>>::new();
    let repository = repository();
    let own = repository.iter().filter(|f| f.is_rust() && !f.is_test());
    for (file, inner) in own.filter_map(|f| Some((f, f.path.strip_prefix(folder)?))) {
        let module = inner.split('/').next().unwrap_or_default().trim_end_matches(".rs");
        if ["lib", "main"].contains(&module) {
            continue;
        }
        let code: Vec<String> = file.code().into_iter().map(|(_, line)| line).collect();
        let code = code.join("\n");
        for (at, _) in code.match_indices("crate::") {
            let named = &code[at + "crate::".len()..];
            let list = named.strip_prefix('{').and_then(|list| list.split('}').next());
            let named = list.map_or(vec![named], |list| list.split(',').collect());
            for name in named.iter().filter_map(|name| words(name.trim_start()).next()) {
                let is_module =
                    name.starts_with(|c: char| c.is_ascii_lowercase()) && name != module;
                if is_module {
                    arrows
                        .entry(module.to_string())
                        .or_default()
                        .entry(name.to_string())
                        .or_insert_with(|| file.path.clone());
                }
            }
        }
    }
    arrows
}

/// The shortest cycle from a module to itself, if there is one.
fn way_back<'a>(
    arrows: &'a BTreeMap<String, BTreeMap<String, String>>,
    from: &'a str,
) -> Option<Vec<&'a str>> {
    let (mut ways, mut seen) = (vec![vec![from]], BTreeSet::new());
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            for next in arrows.get(way[way.len() - 1]).into_iter().flat_map(BTreeMap::keys) {
                let mut on = way.clone();
                on.push(next.as_str());
                if next == from {
                    return Some(on);
                }
                if seen.insert(next.as_str()) {
                    longer.push(on);
                }
            }
        }
        ways = longer;
    }
    None
}

#[test]
fn nothing_names_the_machine_it_was_written_on() {
    // Concatenated, so that this file does not contain them.
    let places = [
        concat!("/wo", "rk/"),
        concat!("/ro", "ot/"),
        concat!("/ho", "me/"),
        concat!("/Us", "ers/"),
    ];
    let mut offences = Vec::new();
    for file in repository() {
        for (number, line) in (1..).zip(file.text.lines()) {
            if let Some(place) = places.iter().find(|place| names(line, place)) {
                offences.push(format!(
                    "{}:{number}: `{place}` is a folder of one machine; use a path from the root of the repository",
                    file.path
                ));
            }
        }
    }
    assert_none(&offences);
}

/// Whether a line has an absolute path that starts with `place`, rather than one in the middle of an address or of a relative path.
fn names(line: &str, place: &str) -> bool {
    let before = |at: usize| line[..at].chars().next_back();
    let part = |c: char| c.is_alphanumeric() || "._-~})/".contains(c);
    line.match_indices(place).any(|(at, _)| !before(at).is_some_and(part))
}

#[test]
fn everything_comes_from_the_public_registry() {
    const PUBLIC: &str = r#"source = "registry+https://github.com/rust-lang/crates.io-index""#;
    let mut offences = Vec::new();
    for file in repository() {
        for (number, line) in (1..).zip(file.text.lines()) {
            let foreign = file.path.ends_with("Cargo.lock")
                && line.starts_with("source = ")
                && line != PUBLIC;
            let redirected = file.path.ends_with(".toml")
                && ["replace-with", "registry = ", "index = \"", "git = \""]
                    .iter()
                    .any(|key| line.contains(key));
            if foreign || redirected {
                offences.push(format!(
                    "{}:{number}: every crate comes from crates.io; keep mirrors in a config of your own",
                    file.path
                ));
            }
        }
    }
    assert_none(&offences);
}

#[test]
fn every_package_follows_the_workspace() {
    let mut offences = Vec::new();
    for file in repository() {
        // The fuzzer has a workspace of its own, so that nothing else requires a nightly compiler; and so has the code beside Avian, which requires another
        // version of Bevy.
        let apart = ["fuzz/", "tests/beside-avian/"].iter().any(|own| file.path.starts_with(own));
        if !file.path.ends_with("/Cargo.toml") || apart {
            continue;
        }
        let mut say = |what: &str| offences.push(format!("{}:1: {what}", file.path));
        if !file.text.contains("[lints]\nworkspace = true") {
            say("add `[lints]` with `workspace = true`");
        }
        if !file.text.contains("\ndescription = \"") {
            say("add a `description`: one sentence");
        }
        let mut section = "";
        for line in file.text.lines() {
            if line.starts_with('[') {
                section = line;
            }
            let literal = line.contains("version = \"") || line.contains(" = \"");
            if section.ends_with("dependencies]") && literal && !line.starts_with('#') {
                say(&format!(
                    "`{line}`: versions belong in the root's Cargo.toml; use `workspace = true`"
                ));
            }
        }
    }
    assert_none(&offences);
}

#[test]
fn links_in_the_documents_lead_somewhere() {
    let mut offences = Vec::new();
    for file in repository().iter().filter(|f| f.path.ends_with(".md")) {
        let folder = root().join(&file.path);
        let folder = folder.parent().expect("a file is in a folder");
        for (number, line) in (1..).zip(file.text.lines()) {
            let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
            // Reference-style links: images of the guide have a name, and below the text a line with the file.
            let named = line.strip_prefix('[').and_then(|line| line.split_once("]: "));
            let targets = targets.chain(named.map(|(_, target)| target));
            for target in targets.filter(|t| !t.contains("://") && !t.starts_with('#')) {
                let path = target.split(['#', ' ']).next().unwrap_or_default();
                if !folder.join(path).exists() {
                    offences.push(format!("{}:{number}: there is no `{target}`", file.path));
                }
            }
        }
    }
    assert_none(&offences);
}

/// The file that a line includes, or the path of its module: the quoted text after the macro or attribute.
fn included(line: &str) -> Option<&str> {
    let by = ["include!(\"", "include_str!(\"", "include_bytes!(\"", "#[path = \""];
    let from = by.iter().find_map(|by| line.find(by).map(|at| at + by.len()))?;
    line[from..].split('"').next()
}

/// A package contains its own folder only.
#[test]
fn what_a_crate_includes_lies_within_it() {
    let mut offences = Vec::new();
    for file in repository().iter().filter(|f| f.is_rust() && f.path.starts_with("crates/")) {
        // Below `crates/NAME`.
        let depth = file.path.matches('/').count() - 2;
        for (number, line) in (1..).zip(file.text.lines()) {
            if let Some(path) = included(line).filter(|path| path.matches("../").count() > depth) {
                offences.push(format!("{}:{number}: `{path}` is not in the package", file.path));
            }
        }
    }
    assert_none(&offences);
}

/// A rule that no longer finds anything would pass for ever, so this checks what each must find.
#[test]
fn the_rules_find_what_they_are_for() {
    let file = |path: &str, text: &str| File { path: path.into(), text: text.into() };
    let code = "let a = x.sin(); // y.cos()\n#[cfg(test)]\nmod tests {\n    fn f() {}\n}\nlet b = \"z.tan()\";\n";
    let file = file("crates/sinew/src/a.rs", code);
    let left: Vec<_> =
        file.code().into_iter().map(|(n, line)| format!("{n} {}", line.trim())).collect();
    assert_eq!(left, ["1 let a = x.sin();", "6 let b = ;"]);
    assert!(calls("q = f32::powf(x, 2.0)", "powf") && calls("v.mul_add(a, b)", "mul_add"));
    assert!(!calls("libm::sin(x)", "sin") && !calls("x.sinew()", "sin") && !calls("sin(x)", "sin"));
    assert_eq!(included("#[doc = include_str!(\"../a.md\")]"), Some("../a.md"));
    let home = concat!("/ho", "me/");
    assert!(names(&format!("see {home}me"), home) && !names(&format!("https://a.b{home}"), home));
    let arrows = |pairs: &[(&str, &str)]| {
        let mut all = BTreeMap::<_, BTreeMap<_, _>>::new();
        for (from, to) in pairs {
            all.entry((*from).into()).or_default().insert((*to).into(), String::new());
        }
        all
    };
    assert_eq!(way_back(&arrows(&[("a", "b"), ("b", "c"), ("a", "c")]), "a"), None);
    let round = arrows(&[("a", "b"), ("b", "c"), ("c", "a")]);
    assert_eq!(way_back(&round, "b"), Some(vec!["b", "c", "a", "b"]));
}
