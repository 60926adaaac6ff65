//! Reads the settings of a picture (UsdRenderSettings, and its first UsdRenderProduct).

use crate::error::Error;
use crate::read::context::Reader;
use crate::stage::When;
use crate::warning::Fault;
use vellus_scene::Fit;

/// The largest side of a picture, in pixels.
const MAX_SIDE: f64 = 32_768.0;

/// What a stage says about its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width and height in pixels, each in [1, 32768]. `None` if the stage does not say it.
    pub size: Option<[usize; 2]>,
    /// The part of the picture to render: left, bottom, right and top, from 0 to 1 over the picture.
    pub window: [f32; 4],
}

impl RenderSettings {
    /// The part of a picture of this size to render: left column, top row, width and height. `None` for all of it. A
    /// pixel belongs to the part if its middle is in the window.
    pub fn crop(&self, size: [usize; 2]) -> Option<[usize; 4]> {
        let [left, bottom, right, top] = self.window;
        let range = |from: f32, to: f32, side: usize| {
            let pixel = |x: f32| (x * side as f32 - 0.5).ceil().clamp(0.0, side as f32) as usize;
            (pixel(from), pixel(to))
        };
        let ((x, x_end), (y, y_end)) = (range(left, right, size[0]), range(1.0 - top, 1.0 - bottom, size[1]));
        let part = [x, y, x_end.saturating_sub(x), y_end.saturating_sub(y)];
        (part[2] > 0 && part[3] > 0 && part != [0, 0, size[0], size[1]]).then_some(part)
    }
}

/// All that is read of the settings.
pub(crate) struct Settings {
    pub picture: Option<RenderSettings>,
    /// The path of the camera.
    pub camera: Option<String>,
    /// What pictures of another shape than the film show.
    pub fit: Fit,
    /// Whether the shutter closes when it opens.
    pub is_instantaneous: bool,
    /// Whether the lens is a pinhole.
    pub is_pinhole: bool,
}

/// The prim of the settings: that of the stage's metadata, or the only one.
fn find(reader: &mut Reader, paths: &[String]) -> Result<Option<String>, Error> {
    let Reader { stage, warnings, .. } = reader;
    if let Some(path) = stage.settings_path() {
        let is_there = paths.contains(&path) && stage.type_name(&path)? == "RenderSettings";
        if !is_there {
            warnings.add("/", format!("renderSettingsPrimPath is {path}, which is no RenderSettings: it is ignored"));
        }
        return Ok(is_there.then_some(path));
    }
    let mut all = Vec::new();
    for path in paths {
        if stage.type_name(path)? == "RenderSettings" {
            all.push(path);
        }
    }
    match &all[..] {
        [] => Ok(None),
        [only] => Ok(Some((*only).clone())),
        several => {
            let what = "the stage has several RenderSettings and no renderSettingsPrimPath: none is used";
            several.iter().for_each(|path| warnings.add(path, what));
            Ok(None)
        }
    }
}

/// Reads the settings of a stage, or their defaults.
pub(crate) fn read(reader: &mut Reader, paths: &[String]) -> Result<Settings, Error> {
    let none = Settings { picture: None, camera: None, fit: Fit::Expand, is_instantaneous: false, is_pinhole: false };
    let Some(prim) = find(reader, paths)? else { return Ok(none) };
    match read_from(reader, paths, &prim) {
        Ok(settings) => Ok(settings),
        Err(error) => {
            reader.fault(Fault::Prim, &prim, error, "the picture has its default settings")?;
            Ok(none)
        }
    }
}

fn read_from(reader: &mut Reader, paths: &[String], prim: &String) -> Result<Settings, Error> {
    let products = reader.prim(prim)?.targets("products")?;
    let Reader { stage, warnings, .. } = reader;
    if products.len() > 1 {
        warnings.add(prim, "it has several products: the picture is that of the first, with the layers of --layers");
    }
    // A product overrides what it has of its own.
    let known = |path: &&String| paths.contains(path);
    let prims: Vec<&String> = products.iter().take(1).filter(known).chain([prim]).collect();
    prims.iter().try_for_each(|prim| stage.visit(prim))?;
    let owner = |name: &str| -> Result<&String, Error> {
        let mut owner = None;
        for prim in &prims {
            // That of the settings counts as read too.
            if stage.has_property(prim, name)? && owner.is_none() {
                owner = Some(*prim);
            }
        }
        Ok(owner.unwrap_or(prim))
    };
    let number = |name: &str| stage.precise(owner(name)?, name, When::Open);
    let flag = |name: &str| Ok::<_, Error>(stage.flag(owner(name)?, name)? == Some(true));
    let camera = stage.targets(owner("camera")?, "camera")?.into_iter().next();
    let is_instantaneous = [flag("instantaneousShutter")?, flag("disableMotionBlur")?].contains(&true);
    let is_pinhole = flag("disableDepthOfField")?;
    let size = match number("resolution")?.as_deref() {
        None => None,
        Some(&[w, h]) if [w, h].iter().all(|x| (1.0..=MAX_SIDE).contains(x)) => Some([w as usize, h as usize]),
        Some(other) => {
            warnings.add(prim, format!("resolution is {other:?}: each must be in [1, {MAX_SIDE}]; it is ignored"));
            None
        }
    };
    let whole = [0.0, 0.0, 1.0, 1.0];
    let window = match number("dataWindowNDC")?.as_deref() {
        None => whole,
        Some(&[left, bottom, right, top])
            if left < right && bottom < top && left < 1.0 && bottom < 1.0 && right > 0.0 && top > 0.0 =>
        {
            let window = [left, bottom, right, top].map(|x| x.clamp(0.0, 1.0) as f32);
            if [left, bottom, right, top].iter().any(|x| !(0.0..=1.0).contains(x)) {
                warnings.add(prim, "dataWindowNDC reaches beyond the picture: nothing is rendered there");
            }
            window
        }
        Some(other) => {
            warnings.add(prim, format!("dataWindowNDC is {other:?}, which is not within the picture: it is ignored"));
            whole
        }
    };
    let picture = Some(RenderSettings { size, window });
    let words = stage.words(owner("aspectRatioConformPolicy")?, "aspectRatioConformPolicy")?.unwrap_or_default();
    let fit = match words.first().map_or("expandAperture", String::as_str) {
        "expandAperture" => Fit::Expand,
        "cropAperture" => Fit::Crop,
        "adjustApertureWidth" => Fit::AdjustWidth,
        "adjustApertureHeight" => Fit::AdjustHeight,
        other => {
            let what = format!("aspectRatioConformPolicy is {other}, which is not supported: expandAperture is used");
            warnings.add(prim, what);
            Fit::Expand
        }
    };
    if number("pixelAspectRatio")?.is_some_and(|ratio| ratio != [1.0]) {
        warnings.add(prim, "pixelAspectRatio is ignored: pixels are square");
    }
    let purposes = stage.words(owner("includedPurposes")?, "includedPurposes")?.unwrap_or_default();
    if purposes.iter().any(|purpose| purpose == "guide" || purpose == "proxy") {
        warnings.add(prim, "includedPurposes is ignored: guides and proxies are not shown");
    }
    Ok(Settings { picture, camera, fit, is_instantaneous, is_pinhole })
}
