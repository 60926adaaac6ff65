//! Says why a stage has nothing to render.

use crate::error::Invalid;
use crate::read::xform::Place;
use crate::read::{GROUPS, LIGHTS, UNSEEN, UNSUPPORTED, is_drawn};
use crate::stage::Stage;

/// The largest number of kinds of prims that are named.
const MOST_KINDS: usize = 6;

/// The largest number of roots that are named.
const MOST_ROOTS: usize = 3;

/// Which prims a stage has, and why they are not in a picture: one sentence.
pub(crate) fn reason(stage: &Stage, places: &[Place]) -> Result<String, Invalid> {
    // One kind more than are named: then there are others.
    let tally = |all: &mut Vec<(String, usize)>, what: String| match all.iter().position(|(known, _)| *known == what) {
        Some(i) => all[i].1 += 1,
        None if all.len() > MOST_KINDS => {}
        None => all.push((what, 1)),
    };
    let (mut drawn, mut others) = (Vec::new(), Vec::new());
    for place in places {
        match why(place) {
            Some(why) => tally(&mut drawn, format!("{} ({why})", place.type_name)),
            None if GROUPS.contains(&place.type_name.as_str()) => {}
            None => tally(&mut others, place.type_name.clone()),
        }
    }
    let mut parts = match (&drawn[..], &others[..]) {
        ([], []) if places.is_empty() => vec!["it has no prims that are defined and active".to_owned()],
        ([], []) => vec!["it has only groups without content".to_owned()],
        ([], others) => vec![format!("it has no strands and meshes, only {}", list(others))],
        (drawn, _) => vec![format!("it has {}", list(drawn))],
    };
    let roots = stage.undefined_roots()?;
    for (specifier, meaning) in [
        ("over", "only changes what another layer defines"),
        ("class", "only for prims that inherit it"),
        ("inactive", "not a part of the stage"),
    ] {
        let mut names: Vec<&str> = roots.iter().filter(|(_, of)| *of == specifier).map(|(name, _)| &name[..]).collect();
        let count = names.len();
        names.truncate(MOST_ROOTS);
        if count > 0 {
            let more = if count > MOST_ROOTS { format!(" and {} more", count - MOST_ROOTS) } else { String::new() };
            parts.push(format!("{}{more} ({specifier}: {meaning})", names.join(", ")));
        }
    }
    if let Some(missing) = stage.missing_default()? {
        parts.push(format!("its defaultPrim {missing} does not exist"));
    }
    Ok(parts.join("; "))
}

/// Why a prim is not in the picture, or `None` if no renderer would show it.
fn why(place: &Place) -> Option<String> {
    let kind = place.type_name.as_str();
    let is_known = is_drawn(kind) || kind == "PointInstancer";
    let is_unseen = GROUPS.contains(&kind) || LIGHTS.contains(&kind) || UNSEEN.contains(&kind);
    if !is_known && (is_unseen || kind == "GeomSubset" || kind.starts_with("Physics")) {
        return None;
    }
    Some(if UNSUPPORTED.contains(&kind) {
        "not supported".to_owned()
    } else if !is_known {
        "not known".to_owned()
    } else if let Some(hidden) = place.hidden() {
        hidden
    } else if place.swallowed {
        "prototype of a PointInstancer".to_owned()
    } else {
        "empty or left out".to_owned()
    })
}

/// Kinds of prims and their numbers.
fn list(kinds: &[(String, usize)]) -> String {
    let mut named: Vec<String> = kinds.iter().take(MOST_KINDS).map(|(kind, count)| format!("{count} {kind}")).collect();
    if kinds.len() > MOST_KINDS {
        named.push("others".to_owned());
    }
    named.join(", ")
}
