//! The options of `vellus render` in a plan.
//!
//! A plan is a file that anybody may have written. Only options that choose a picture are accepted, never one that
//! chooses an output or opens a connection.

use crate::Error;

/// Options of `vellus render` that a plan may contain, after `--`.
pub const PICTURE_OPTIONS: [&str; 40] = [
    "--small",
    "--fiber",
    "--set",
    "--override",
    "--width",
    "--strands",
    "--camera",
    "--shutter",
    "--strict",
    "--view",
    "--light",
    "--background",
    "--body",
    "--model",
    "--eta-m",
    "--size",
    "--crop",
    "--device",
    "--mode",
    "--filter",
    "--max-depth",
    "--clamp-indirect",
    "--radiance-cache",
    "--min-pixel-width",
    "--lod",
    "--seed",
    "--threads",
    "--exposure",
    "--tone",
    "--reflectance-of",
    "--tip-color",
    "--tips",
    "--ramp",
    "--belly",
    "--mix",
    "--wet",
    "--coat",
    "--layers",
    "--denoise",
    "--float",
];

/// Options of `vellus render` that the plan itself determines, or that would make results depend on time.
pub const PER_PLAN: [&str; 11] = [
    "--output",
    "--spp",
    "--time",
    "--noise",
    "--samples",
    "--frame",
    "--frames",
    "--resume",
    "--checkpoint",
    "--tev",
    "--help",
];

/// Stands for the folder of the plan, at the beginning of an argument.
pub const FOLDER: &str = "{dir}";

/// Checks the scene and the options of a plan.
///
/// # Errors
/// [`Error::Options`] names the first one that a plan must not contain.
pub fn check(scene: &str, options: &[String]) -> Result<(), Error> {
    if scene.is_empty() || scene.starts_with('-') || scene.contains(FOLDER) {
        return Err(Error::Options(format!("'{scene}' is not the name of a scene")));
    }
    for option in options {
        let name = option.split('=').next().unwrap_or_default();
        // -30,10 is a value.
        let is_name = option.starts_with('-') && !option[1..].starts_with(|c: char| c.is_ascii_digit() || c == '.');
        if is_name && !PICTURE_OPTIONS.contains(&name) || option.contains(FOLDER) {
            let known = PICTURE_OPTIONS.join(", ");
            return Err(Error::Options(format!("a plan cannot contain the option {option} (it can contain {known})")));
        }
    }
    Ok(())
}

/// The options of a render, and those of the merge: the latter choose how the film becomes a picture.
pub fn divide(options: &[String]) -> (Vec<String>, Vec<String>) {
    let (mut render, mut merge) = (Vec::new(), Vec::new());
    let mut rest = options.iter();
    while let Some(option) = rest.next() {
        match option.as_str() {
            "--denoise" | "--float" => merge.push(option.clone()),
            // `--exposure auto` is measured by the render and used by the merge.
            "--exposure" | "--tone" => {
                let both: Vec<String> = [option].into_iter().chain(rest.next()).cloned().collect();
                render.extend(both.iter().cloned());
                merge.extend(both);
            }
            other if other.starts_with("--exposure=") || other.starts_with("--tone=") => {
                render.push(option.clone());
                merge.push(option.clone());
            }
            _ => render.push(option.clone()),
        }
    }
    (render, merge)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn options_that_choose_outputs_are_refused() {
        assert!(check("cat", &words("--size 64x48 --view -30,10 --shutter -1:0 --set=kappa=0.5 --eta-m .5")).is_ok());
        for bad in ["-o x.exr", "-o/x.exr", "--output=x.exr", "--tev host", "--spp 4", "--camera --tev", "{dir}/x", "-"]
        {
            assert!(matches!(check("cat", &words(bad)), Err(Error::Options(_))), "{bad}");
        }
        for bad in ["", "-x", "--help", "{dir}/../x.usda"] {
            assert!(check(bad, &[]).is_err(), "{bad}");
        }
    }

    #[test]
    fn merges_get_the_options_of_pictures() {
        let (render, merge) = divide(&words("--float --size 9x9 --exposure -1 --seed 3 --denoise --exposure=2"));
        assert_eq!(render, words("--size 9x9 --exposure -1 --seed 3 --exposure=2"));
        assert_eq!(merge, words("--float --exposure -1 --denoise --exposure=2"));
    }
}
