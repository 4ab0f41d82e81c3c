//! More sweeps for light body colliders that carry heavy ones.
//!
//! Gauss and Seidel's way hands a load down from body to body. Of a mass `M` that lies on a mass `m` on the ground, each sweep brings `m/M` of what
//! is missing to the ground, and gives the rest back. Overlap makes up for a part of it: what is in too deep by `δ` is pushed by `m δ/h²` from below,
//! so with one sweep the two come to rest where `δ = M g h²/m`, which is 3 mm for 100 kg on 1 kg at 600 substeps a second, and for 1000 kg more than
//! is recovered in a substep: the light one is pressed into the ground. With `n` sweeps it is an `n`-th of that. So they are swept about as often as
//! the ratio is; and not those alone, but all that the light one lies on and is lighter than its load by as much. Body colliders that share particles
//! with others (bones) are as heavy as their joints make them, and are left alone.

use super::contacts::Contact;

/// How often manifolds are pressed in a substep, by their level: as often as the ratio of masses, or the next power of two, where that is more than
/// [`RATIO`].
pub(super) const SWEEPS: [u32; 4] = [1, 8, 16, 32];
/// From which ratio on. A heap of crates of different sizes has less in it, and rests as it is.
const RATIO: f32 = 8.0;
/// How far down a load is followed, body colliders.
const DEPTH: usize = 16;

/// Says of each manifold how often it is to be pressed. `mass` is that of a body collider, kg, or none of what shares particles or is held; `loads`
/// is scratch.
pub(super) fn set_levels(
    contacts: &mut [Contact],
    body_colliders: usize,
    mass: impl Fn(u32) -> Option<f32>,
    loads: &mut Vec<f32>,
) {
    loads.clear();
    let mut any = false;
    for one in contacts.iter().filter(|one| one.geometry.is_none()) {
        let (Some(a), Some(b)) = (mass(one.a), mass(one.b)) else { continue };
        if a.max(b) < RATIO * a.min(b) {
            continue;
        }
        if !any {
            loads.resize(body_colliders, 0.0);
            any = true;
        }
        let light = if a < b { one.a } else { one.b };
        let load = &mut loads[light as usize];
        *load = load.max(a.max(b));
    }
    if !any {
        return;
    }
    for _ in 0..DEPTH {
        let mut changed = false;
        for one in contacts.iter().filter(|one| one.geometry.is_none()) {
            for (from, to) in [(one.a, one.b), (one.b, one.a)] {
                let (load, Some(mass)) = (loads[from as usize], mass(to)) else { continue };
                if load >= RATIO * mass && load > loads[to as usize] {
                    loads[to as usize] = load;
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    for one in contacts {
        let ratio = |solid: u32| {
            let load = loads.get(solid as usize).copied().unwrap_or(0.0);
            mass(solid).map_or(0.0, |mass| load / mass)
        };
        let other = if one.geometry.is_none() { ratio(one.b) } else { 0.0 };
        let ratio = ratio(one.a).max(other);
        if ratio >= RATIO {
            let enough = SWEEPS.iter().position(|&sweeps| sweeps as f32 >= ratio);
            one.level = enough.unwrap_or(SWEEPS.len() - 1);
        }
    }
}
