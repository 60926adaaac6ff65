//! The ledger of fields: each property of a prim that is read was asked for, is known to change nothing, or is named.

use crate::error::Error;
use crate::read::context::Reader;
use crate::stage::When;

/// Properties that change nothing in a picture of Vellus, by the reason: names, or namespaces, which end with a colon.
const IGNORED: [(&str, &[&str]); 14] = [
    // The space of the colours below a prim, which is asked for where there are some.
    ("colours", &["colorSpace:"]),
    // Notes of programs and users.
    ("notes", &["userProperties:", "ui:", "info:", "assetInfo:", "semantics:", "constraintTargets:"]),
    // What other renderers and programs need. Where an attribute of theirs is read, it was asked for.
    (
        "other programs",
        &[
            "primvars:",
            "arnold:",
            "ri:",
            "karma:",
            "husk:",
            "houdini:",
            "redshift:",
            "octane:",
            "cycles:",
            "vray:",
            "omni:",
            "maya:",
            "blender:",
            "adsk:",
            "physics:",
            "physx",
            "hydra:",
            "trace:",
            "rman:",
            "rendersettings:",
            "pruning:",
            // Shaders that refer to a coordinate system are not read.
            "coordSys:",
        ],
    ),
    // Bounds and stand-ins, which tell other programs what is there before they read it.
    ("bounds", &["extent", "extentsHint", "proxyPrim", "model:cardGeometry", "model:cardTexture"]),
    // Views of other programs: materials for a preview, colours of handles, stereo, planes near and far.
    (
        "views",
        &["material:binding:preview", "guideColor", "guideRadius", "stereoRole", "clippingRange", "houdini:guidescale"],
    ),
    // Names of properties before USD was published: its schemas do not have them.
    ("old names", &["interpolateBoundary", "faceVaryingInterpolateBoundary"]),
    // How subsets of a mesh are meant: the subsets themselves are read.
    ("subsets", &["subsetFamily:"]),
    // Names of joints for users.
    ("joints", &["jointNames"]),
    // Files and layers of a picture, which are chosen where it is rendered.
    ("products", &["productName", "productType", "orderedVars"]),
    // Operations that `xformOpOrder` does not name.
    ("transforms", &["xformOp:"]),
    // What a shader gives: the connections to it were followed.
    ("outputs", &["outputs:"]),
    // Both sides of a surface are shown.
    ("sides", &["doubleSided"]),
    // Of UsdPreviewSurface: what the light itself does, and details of inputs that have a warning of their own.
    (
        "details",
        &[
            "inputs:occlusion",
            "inputs:opacityThreshold",
            "inputs:opacityMode",
            "inputs:clearcoatRoughness",
            "inputs:specularColor",
        ],
    ),
    // Members of a collection matter where something refers to them, and that is asked for.
    ("collections", &["collection:"]),
];

/// Collections that have an effect by themselves.
const EFFECTIVE: [&str; 3] = ["collection:lightLink:", "collection:shadowLink:", "collection:filterLink:"];

/// Values at which a property has no effect: those that its schema has as fallback.
const FALLBACKS: [(&str, Idle); 37] = [
    ("inputs:diffuse", Idle::Number(1.0)),
    ("inputs:specular", Idle::Number(1.0)),
    ("inputs:shadow:enable", Idle::Number(1.0)),
    ("inputs:shadow:color", Idle::Number(0.0)),
    ("inputs:shadow:distance", Idle::Number(-1.0)),
    ("inputs:shadow:falloff", Idle::Number(-1.0)),
    ("inputs:shadow:falloffGamma", Idle::Number(1.0)),
    ("inputs:colorTemperature", Idle::Any),
    ("inputs:normalize", Idle::Number(0.0)),
    ("inputs:shaping:focusTint", Idle::Number(0.0)),
    ("inputs:shaping:ies:angleScale", Idle::Any),
    ("inputs:shaping:ies:normalize", Idle::Any),
    ("inputs:shaping:cone:angle", Idle::Number(90.0)),
    ("inputs:texture:format", Idle::Any),
    ("treatAsLine", Idle::Number(0.0)),
    ("treatAsPoint", Idle::Any),
    ("light:shaderId", Idle::Any),
    ("light:materialSyncMode", Idle::Word("noMaterialResponse")),
    ("collection:lightLink:includeRoot", Idle::Number(1.0)),
    ("collection:lightLink:expansionRule", Idle::Word("expandPrims")),
    ("collection:shadowLink:includeRoot", Idle::Number(1.0)),
    ("collection:shadowLink:expansionRule", Idle::Word("expandPrims")),
    ("collection:filterLink:includeRoot", Idle::Any),
    ("collection:filterLink:expansionRule", Idle::Any),
    ("exposure:fStop", Idle::Number(1.0)),
    ("exposure:iso", Idle::Number(100.0)),
    ("exposure:responsivity", Idle::Number(1.0)),
    ("exposure:time", Idle::Number(1.0)),
    ("model:drawMode", Idle::Word("default")),
    ("model:applyDrawMode", Idle::Any),
    ("model:drawModeColor", Idle::Any),
    ("orientation", Idle::Word("rightHanded")),
    ("inputs:isRoot", Idle::Any),
    ("inputs:fallback", Idle::Any),
    ("inputs:displacement", Idle::Number(0.0)),
    ("wrap", Idle::Word("nonperiodic")),
    ("materialBindingPurposes", Idle::Words(&["full", "allPurpose"])),
];

/// A value without effect.
enum Idle {
    /// All numbers are equal to this one. True is 1.
    Number(f64),
    /// A token.
    Word(&'static str),
    /// Tokens.
    Words(&'static [&'static str]),
    /// Any value: it only matters together with a property that has a warning of its own.
    Any,
}

/// Adds a warning for each property of the prims that were read, which nobody asked for, and which could be visible.
pub(crate) fn check(reader: &mut Reader) -> Result<(), Error> {
    let mut prims = reader.stage.visited();
    prims.retain(|prim| !reader.left_out.contains(prim));
    for prim in prims {
        let properties = reader.stage.properties(&prim)?;
        for name in properties.unread() {
            // What cannot even be asked about is named, too.
            if !is_ignored(name) && has_effect(reader, &prim, name).unwrap_or(true) {
                reader.warnings.add(&prim, format!("{name} is not read and has no effect"));
            }
        }
    }
    Ok(())
}

fn is_ignored(name: &str) -> bool {
    let matches = |known: &&str| if known.ends_with(':') { name.starts_with(known) } else { name == *known };
    let known = IGNORED.iter().any(|(_, names)| names.iter().any(&matches));
    known && !EFFECTIVE.iter().any(|prefix| name.starts_with(prefix))
}

/// Whether a property has a value other than the one without effect. Attributes that no schema defines have none.
fn has_effect(reader: &Reader, prim: &str, name: &str) -> Result<bool, Error> {
    let stage = reader.stage;
    if stage.is_custom(prim, name)? {
        return Ok(false);
    }
    // A relationship without targets, and an attribute without a value and a connection, or with an empty list.
    let is_empty = stage.numbers(prim, name, When::Open).is_ok_and(|all| all.is_some_and(|all| all.values.is_empty()));
    if is_empty || !stage.has_content(prim, name)? {
        return Ok(false);
    }
    let Some((_, idle)) = FALLBACKS.iter().find(|(known, _)| *known == name) else { return Ok(true) };
    // A value of another type is no fallback.
    Ok(match idle {
        Idle::Any => false,
        Idle::Number(idle) => match stage.flag(prim, name) {
            Ok(Some(flag)) if stage.precise(prim, name, When::Open).is_err() => f64::from(u8::from(flag)) != *idle,
            _ => stage.precise(prim, name, When::Open).ok().flatten().is_none_or(|all| all.iter().any(|x| x != idle)),
        },
        Idle::Word(word) => stage.words(prim, name).ok().flatten().is_none_or(|all| all != [*word]),
        Idle::Words(words) => stage.words(prim, name).ok().flatten().is_none_or(|all| all != *words),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces_and_names_are_told_apart() {
        for ignored in ["userProperties:blender:x", "extent", "primvars:arnold:radius", "collection:hair:includes"] {
            assert!(is_ignored(ignored), "{ignored}");
        }
        for read in ["extentX", "inputs:color", "collection:lightLink:includes", "primvar", "velocities"] {
            assert!(!is_ignored(read), "{read}");
        }
    }
}
