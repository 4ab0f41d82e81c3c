//! The list of state is complete: every component and resource in the source of `bevy_sinew` is in it, or is listed here with the reason why it is not state.

use std::collections::BTreeSet;
use std::path::Path;

use bevy_sinew::{StateRole, StateTypes};

use crate::support::app;

/// Components and resources that are not state, and why.
const NO_STATE: [(&str, &str); 25] = [
    ("ParticleRow", "scratch: given anew whenever particles come or go"),
    ("ResolvedRows", "scratch: resolved anew where what it is of has changed"),
    ("ResolvedShape", "scratch: found again where what it follows from has changed"),
    ("ResolvedTarget", "scratch: found again where what it follows from has changed"),
    ("PlacedCollider", "scratch: made anew of the collider and its place"),
    ("SinewWorld", "scratch: refilled at the start of every tick"),
    ("TopologyChanged", "set whenever a snapshot is put back"),
    ("Kinds", "which constraints are registered: part of the program"),
    ("StateTypes", "which types are state: part of the program"),
    ("RollbackHistory", "states that were"),
    ("SinewWorkers", "threads, which change no result"),
    ("TickTime", "wall-clock time"),
    ("PhaseSteps", "what is shown of a tick that was taken"),
    ("FixedTick", "scratch: counted anew in each fixed tick"),
    ("PlayedTransform", "what is drawn between two ticks"),
    ("DrawnTransform", "what is drawn between two ticks"),
    ("RelaxWorld", "a command: done and taken off in the next tick"),
    ("MouseDrag", "settings of a tool"),
    ("PointerState", "where the mouse is"),
    ("WatchedContacts", "what a tool looks at"),
    ("Jumps", "scratch: emptied in every tick"),
    ("Toggled", "scratch: emptied in every tick, and filled again from what is restored"),
    ("LeftAt", "scratch: follows from what is disabled"),
    ("JustBuilt", "scratch: emptied in the tick that filled it"),
    ("Breakables", "scratch: listed anew where what it follows from has changed"),
];

/// State of plugins that these apps do not add.
const ELSEWHERE: [&str; 1] = ["GrabConstraint"];

/// The name of a type without its path and its parameters.
fn short(name: &str) -> &str {
    let name = name.split('<').next().unwrap_or(name);
    name.rsplit("::").next().unwrap_or(name)
}

/// Collects the names of components and resources declared in the files of a folder, tests excluded.
fn declared(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            declared(&path, found);
            continue;
        }
        if path.extension().is_none_or(|end| end != "rs") || path.ends_with("tests.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(&text);
        let mut derives = false;
        for line in code.lines() {
            if let Some(list) = line.strip_prefix("#[derive(") {
                let mut words = list.split(|c: char| !c.is_alphanumeric());
                derives = words.any(|word| word == "Component" || word == "Resource");
            }
            let words: Vec<&str> =
                line.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
            let Some(kind) = words.iter().position(|word| ["struct", "enum"].contains(word)) else {
                continue;
            };
            let is_code = !line.trim_start().starts_with("//");
            if derives && is_code {
                found.extend(words.get(kind + 1).map(ToString::to_string));
                derives = false;
            }
        }
    }
}

#[test]
fn every_component_and_resource_in_the_source_is_listed_as_state_or_not() {
    let app = app();
    let types = app.world().resource::<StateTypes>();
    let listed: BTreeSet<String> = types.iter().map(|of| short(of.name).to_string()).collect();
    let none: BTreeSet<String> = NO_STATE.iter().map(|(name, _)| name.to_string()).collect();
    let elsewhere: BTreeSet<String> = ELSEWHERE.iter().map(ToString::to_string).collect();

    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/bevy_sinew/src");
    let mut found = BTreeSet::new();
    declared(&source, &mut found);
    assert!(found.len() > 90, "the source is not read any more: {found:?}");

    let missing: Vec<_> =
        found.iter().filter(|name| !listed.contains(*name) && !none.contains(*name)).collect();
    let missing: Vec<_> = missing.into_iter().filter(|name| !elsewhere.contains(*name)).collect();
    assert!(missing.is_empty(), "add them to `state/list.rs`, or to the list above: {missing:?}");
    let stale: Vec<_> = none.iter().filter(|name| !found.contains(*name)).collect();
    assert!(stale.is_empty(), "named as no state, and not there: {stale:?}");
    let both: Vec<_> = none.intersection(&listed).collect();
    assert!(both.is_empty(), "both state and none: {both:?}");
}

#[test]
fn each_type_of_state_is_listed_once_and_reflected() {
    let app = app();
    let types: Vec<_> = app.world().resource::<StateTypes>().iter().collect();
    let names: BTreeSet<_> = types.iter().map(|of| of.name).collect();
    assert_eq!(names.len(), types.len());
    for of in &types {
        assert!(of.reflected || of.role == StateRole::Local, "{of:?}");
    }
}
