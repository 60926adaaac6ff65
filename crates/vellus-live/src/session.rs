//! A scene that is shown, and the values of all controls. The thread of the engine owns it.

mod saved;

use crate::camera::Orbit;
use crate::history::{History, Step, Version};
use crate::request::{Coat, Command, Groom, MAX_SIDE, MIN_SIDE, within};
use crate::state::{LightState, LookState, OtherState, State};
use glam::{Mat3, Mat4, Quat, Vec3};
use saved::rest;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use vellus::Fiber;
use vellus_models::ModelKind;
use vellus_open::{Opened, Options, Staging, Warning};
use vellus_render::Denoise;
use vellus_render::denoise::Denoiser;
use vellus_render::{Curves, Display, Layer, Pick, Settings, Varying, World};
use vellus_render_models::Method;
use vellus_scene::{Light, LightShape, Look, Profile, Scene, Shaping, Strands};

/// What a command asks of the engine.
#[derive(Debug)]
pub enum Effect {
    /// Nothing: the answer is complete.
    None,
    /// The film stays, and its picture is sent again.
    Redraw,
    /// The picture starts again.
    Restart,
    /// The groom is built in the background. With `true`, the picture starts again at once too.
    Groom(bool),
    /// A file of the folder is opened in the background.
    Open(String),
}

/// A scene and the values of all controls.
pub struct Session {
    pub world: World,
    pub orbit: Orbit,
    name: String,
    /// The strands of the scene, and the parameters that vary over the strands shown, before [`Coat`].
    pub source: Arc<Vec<Strands>>,
    own: Vec<Varying>,
    lights: Vec<(String, Light)>,
    /// Everything of the scene but its strands, looks, lights, camera and images.
    rest: Scene,
    /// The images of the scene.
    images: usize,
    up: Vec3,
    /// The point about which lights turn.
    middle: Vec3,
    /// What the picture shows.
    now: Version,
    history: History,
    pub exposure: f32,
    /// The exposure that suits lights that the file does not have.
    metered: f32,
    pub size: [usize; 2],
    crop: Option<[f32; 4]>,
    pub paused: bool,
    pub target: u64,
    pub denoise: bool,
    pub denoiser: Result<Arc<dyn Denoise + Send + Sync>, String>,
    /// What the file has that was left out or replaced.
    warnings: Vec<String>,
}

/// The longer side of the picture at first, which has the shape of the camera's film.
const LONGER: usize = 960;

/// The distance in pixels at which a click still finds a strand.
const REACH: usize = 5;

impl Session {
    /// Opens a scene by name or path.
    pub fn open(path: &Path, small: bool) -> Result<Self, crate::Error> {
        let options = Options { small, instances: true, staging: Some(Staging::new(1.5)), ..Options::default() };
        let opened = vellus_open::open(path, &options)?;
        let name = path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into());
        Session::new(name, opened).map_err(Into::into)
    }

    /// Prepares an opened scene.
    pub fn new(name: String, opened: Opened) -> Result<Self, vellus_scene::Error> {
        let Opened { scene, is_metered, warnings, .. } = opened;
        let mut warnings = Warning::lines(&warnings);
        let source = Arc::new(scene.strands.clone());
        let own = scene.strands.iter().map(|strands| strands.varying.clone()).collect();
        let (low, high) = scene.bounds().unwrap_or_default();
        let (up, middle) = (scene.up(), 0.5 * (low + high));
        let (rest, images) = (rest(&scene), scene.textures.len());
        let lights: Vec<_> = scene.light_group_names().into_iter().zip(scene.lights.iter().cloned()).collect();
        let now = Version {
            looks: scene.looks.iter().map(|look| (look.clone(), Coat::default())).collect(),
            model: Method::from(ModelKind::Vellus),
            azimuth: 0.0,
            changes: vec![(1.0, Vec3::ZERO); lights.len()],
            groom: Groom::default(),
        };
        let world = now.model.world(scene)?;
        warnings.extend(world.unreached());
        let size = world.camera().size(LONGER).map(|side| side.max(MIN_SIDE));
        let denoiser = Denoiser::load().map_err(|error| error.to_string());
        let denoiser = denoiser.map(|denoiser| Arc::new(denoiser) as Arc<dyn Denoise + Send + Sync>);
        let mut session = Session {
            orbit: Orbit::new(world.camera(), middle, up),
            world,
            name,
            source,
            own,
            lights,
            rest,
            images,
            up,
            middle,
            history: History::new(now.clone()),
            now,
            exposure: 0.0,
            metered: 0.0,
            size,
            crop: None,
            paused: false,
            target: 256,
            denoise: denoiser.is_ok(),
            denoiser,
            warnings,
        };
        session.world.set_camera(session.orbit.camera())?;
        if is_metered {
            session.metered = session.world.metered().unwrap_or(0.0);
            session.exposure = session.metered;
        }
        Ok(session)
    }

    /// How the picture is shown.
    pub fn display(&self) -> Display {
        Display { exposure: self.exposure, ..Display::default() }
    }

    /// Applies a command. The session does not change if it is refused.
    pub fn apply(&mut self, command: Command, at: Instant) -> Result<(Value, Effect), String> {
        let control = command.control();
        let answer = self.change(command)?;
        if let Some(control) = control {
            self.history.record(control, &self.now, at);
        }
        Ok(answer)
    }

    fn change(&mut self, command: Command) -> Result<(Value, Effect), String> {
        let effect = match command {
            Command::Orbit { x, y } => self.moved(|orbit| orbit.turn(x, y))?,
            Command::Pan { x, y } => {
                let aspect = self.size[0] as f32 / self.size[1] as f32;
                self.moved(|orbit| orbit.pan(x, y, aspect))?
            }
            Command::Zoom { factor } => self.moved(|orbit| orbit.zoom(factor))?,
            Command::Lens { angle, radius } => self.moved(|orbit| orbit.lens(angle, radius))?,
            Command::Home => self.moved(|orbit| {
                orbit.home();
                Ok(())
            })?,
            Command::Focus { x, y } => {
                let point = self.pick(x, y)?.ok_or("there is nothing to focus on")?.point;
                self.moved(|orbit| {
                    orbit.focus(point);
                    Ok(())
                })?
            }
            Command::Pick { x, y } => return Ok((self.describe(self.pick_strand(x, y)?), Effect::None)),
            Command::Exposure { stops } => {
                self.exposure = within("exposure", stops, -20.0, 20.0)?;
                Effect::Redraw
            }
            Command::Size { width, height } => {
                for side in [width, height] {
                    within("size", side as f32, MIN_SIDE as f32, MAX_SIDE as f32)?;
                }
                self.size = [width, height];
                Effect::Restart
            }
            Command::Crop { area } => {
                if let Some(area) = area {
                    let [left, top, right, bottom] = area.map(|x| x.clamp(0.0, 1.0));
                    if !(right - left > 0.01 && bottom - top > 0.01) {
                        return Err("the crop is too small".to_owned());
                    }
                    self.crop = Some([left, top, right, bottom]);
                } else {
                    self.crop = None;
                }
                Effect::Restart
            }
            Command::Pause { on } => {
                self.paused = on;
                Effect::None
            }
            Command::Target { samples } => {
                self.target = within("samples", samples as f32, 1.0, 65536.0)? as u64;
                Effect::None
            }
            Command::Denoise { on } => {
                if let (true, Err(why)) = (on, &self.denoiser) {
                    return Err(why.clone());
                }
                self.denoise = on;
                Effect::Redraw
            }
            Command::Look { look, fiber } => self.set_fiber(look, fiber)?,
            Command::Coat { look, coat } => {
                coat.check()?;
                let mut looks = self.now.looks.clone();
                looks.get_mut(look).ok_or("the look does not exist")?.1 = coat;
                self.set_looks(looks, Some(look))?
            }
            Command::Model { name } => {
                let kind: ModelKind = name.parse().map_err(|error: vellus_models::Error| error.to_string())?;
                self.set_model(Method::from(kind))?
            }
            Command::Azimuth { degrees } => {
                let old = std::mem::replace(&mut self.now.azimuth, within("degrees", degrees, -3600.0, 3600.0)?);
                self.set_lights().inspect_err(|_| self.now.azimuth = old)?
            }
            Command::Light { light, gain, shift } => {
                let gain = within("gain", gain, 0.0, 1000.0)?;
                let shift = Vec3::from(shift);
                within("shift", shift.length(), 0.0, 1e6)?;
                let change = self.now.changes.get_mut(light).ok_or("the light does not exist")?;
                let old = std::mem::replace(change, (gain, shift));
                self.set_lights().inspect_err(|_| self.now.changes[light] = old)?
            }
            Command::Groom(groom) => {
                groom.check()?;
                if self.source.is_empty() {
                    return Err("this scene has no strands outside of instances".to_owned());
                }
                self.now.groom = groom;
                Effect::Groom(false)
            }
            Command::Undo => self.step(Step::Undo)?,
            Command::Redo => self.step(Step::Redo)?,
            Command::Version { index } => self.step(Step::Show(index))?,
            Command::CopyVersion => self.step(Step::Copy)?,
            Command::Open { file } => Effect::Open(file),
        };
        Ok((Value::Null, effect))
    }

    fn moved(&mut self, change: impl FnOnce(&mut Orbit) -> Result<(), String>) -> Result<Effect, String> {
        let mut orbit = self.orbit;
        change(&mut orbit)?;
        self.world.set_camera(orbit.camera()).map_err(|error| error.to_string())?;
        self.orbit = orbit;
        Ok(Effect::Restart)
    }

    /// Makes a step of the history, and shows the version that it gives.
    fn step(&mut self, step: Step) -> Result<Effect, String> {
        let before = self.history.clone();
        let next = self.history.step(step)?;
        self.show(&next).inspect_err(|_| self.history = before)
    }

    /// Shows a version. What it has in common with the one before stays.
    fn show(&mut self, next: &Version) -> Result<Effect, String> {
        if *next == self.now {
            return Ok(Effect::None);
        }
        if next.model != self.now.model {
            self.set_model(next.model)?;
        }
        let differ = |i: &usize| next.looks[*i] != self.now.looks[*i];
        let changed: Vec<usize> = (0..next.looks.len()).filter(differ).collect();
        match changed[..] {
            [] => {}
            [one] => drop(self.set_looks(next.looks.clone(), Some(one))?),
            _ => drop(self.set_looks(next.looks.clone(), None)?),
        }
        if (next.azimuth, &next.changes) != (self.now.azimuth, &self.now.changes) {
            (self.now.azimuth, self.now.changes) = (next.azimuth, next.changes.clone());
            self.set_lights()?;
        }
        let grown = next.groom != self.now.groom;
        self.now.groom = next.groom;
        Ok(if grown { Effect::Groom(true) } else { Effect::Restart })
    }

    fn set_model(&mut self, model: Method) -> Result<Effect, String> {
        model.apply(&mut self.world).map_err(|error| error.to_string())?;
        self.now.model = model;
        Ok(Effect::Restart)
    }

    /// The changes of the strands.
    pub fn groom(&self) -> Groom {
        self.now.groom
    }

    fn set_fiber(&mut self, index: usize, fiber: Value) -> Result<Effect, String> {
        let builder = vellus_views::builder(&fiber)?;
        let fiber = builder.build().map_err(|error| error.to_string())?;
        let mut looks = self.now.looks.clone();
        let (look, coat) = looks.get_mut(index).ok_or("the look does not exist")?;
        // A new colour replaces the pattern of the scene. Other parameters keep it.
        let colors = |fiber: &Fiber| (fiber.sigma_ca, fiber.reflectance);
        let recolored = colors(&fiber) != colors(&look.fiber);
        coat.pattern &= !recolored;
        if recolored {
            look.textured.retain(|(parameter, _)| !parameter.is_color());
        }
        look.fiber = fiber;
        self.set_looks(looks, Some(index))
    }

    /// Sets the looks. The strands of the look `changed`, or of all looks, get the values that vary.
    fn set_looks(&mut self, looks: Vec<(Look, Coat)>, changed: Option<usize>) -> Result<Effect, String> {
        let sets = self.world.curves().strands().iter().enumerate();
        let sets = sets.filter(|(_, set)| changed.is_none_or(|look| look == set.look));
        let needed = |look: usize| {
            // Without an own colour and with the same coat, the values stay.
            changed.is_none() || looks[look].1 != self.now.looks[look].1 || looks[look].1.tip != 1.0
        };
        let varying = sets
            .filter(|(_, set)| needed(set.look))
            .map(|(i, set)| (i, looks[set.look].1.varying(set, &self.own[i], &looks[set.look].0.fiber)))
            .collect();
        let plain = looks.iter().map(|(look, _)| look.clone()).collect();
        self.world.set_looks(plain, varying).map_err(|error| error.to_string())?;
        self.now.looks = looks;
        Ok(Effect::Restart)
    }

    /// Shows strands that were built in the background.
    pub fn set_curves(&mut self, curves: Curves) -> Result<(), String> {
        let own = curves.strands().iter().map(|set| set.varying.clone()).collect();
        self.world.set_curves(curves).map_err(|error| error.to_string())?;
        self.own = own;
        self.set_looks(self.now.looks.clone(), None).map(|_| ())
    }

    /// The lights after all changes, times a factor.
    fn shown_lights(&self, factor: f32) -> Vec<Light> {
        let turn = Quat::from_axis_angle(self.up, self.now.azimuth.to_radians());
        let around = Mat4::from_translation(self.middle) * Mat4::from_quat(turn) * Mat4::from_translation(-self.middle);
        let side = |profile: Profile| Profile { side: turn * profile.side, ..profile };
        let turned =
            |shaping: Shaping| Shaping { axis: turn * shaping.axis, profile: shaping.profile.map(side), ..shaping };
        let changed = |((_, light), (gain, shift)): (&(String, Light), &(f32, Vec3))| Light {
            shape: change(&light.shape, factor * gain, Mat4::from_translation(*shift) * around),
            shaping: light.shaping.map(turned),
            ..light.clone()
        };
        self.lights.iter().zip(&self.now.changes).map(changed).collect()
    }

    fn set_lights(&mut self) -> Result<Effect, String> {
        let lights = self.shown_lights(1.0);
        if !lights.is_empty() {
            self.world.set_lights(&lights).map_err(|error| error.to_string())?;
        }
        Ok(Effect::Restart)
    }

    /// Width and height of the picture whose pixels are `coarse` times as wide, and the settings that render it.
    pub fn settings(&self, coarse: usize) -> Settings {
        let size = self.size.map(|side| side.div_ceil(coarse).max(1));
        let crop = self.crop.map(|[left, top, right, bottom]| {
            let from = |x: f32, side: usize| ((x * side as f32) as usize).min(side - 1);
            let [x, y] = [from(left, size[0]), from(top, size[1])];
            let to = |x: f32, side: usize, start: usize| ((x * side as f32).ceil() as usize).clamp(start + 1, side);
            [x, y, to(right, size[0], x) - x, to(bottom, size[1], y) - y]
        });
        Settings { crop, ..Settings::new(size) }
    }

    /// The layers of a film.
    pub fn layers(&self) -> Vec<Layer> {
        if self.denoiser.is_ok() { vec![Layer::Albedo, Layer::Normal] } else { Vec::new() }
    }

    fn pick(&self, x: f32, y: f32) -> Result<Option<Pick>, String> {
        let settings = Settings { crop: None, ..self.settings(1) };
        let place = |name: &str, x: f32, side: usize| {
            within(name, x, 0.0, 1.0).map(|x| ((x * side as f32) as usize).min(side - 1))
        };
        Ok(self.world.pick(&settings, [place("x", x, settings.size[0])?, place("y", y, settings.size[1])?]))
    }

    /// As [`Session::pick`]. Where the point shows a mesh between strands, it takes a strand within a few pixels.
    fn pick_strand(&self, x: f32, y: f32) -> Result<Option<Pick>, String> {
        let first = self.pick(x, y)?;
        if first.as_ref().is_some_and(|pick| pick.strand.is_some()) {
            return Ok(first);
        }
        for ring in 1..=REACH {
            for step in 0..8 * ring {
                let (sin, cos) = (step as f32 * std::f32::consts::TAU / (8 * ring) as f32).sin_cos();
                let place =
                    |at: f32, offset: f32, side: usize| (at + offset * ring as f32 / side as f32).clamp(0.0, 1.0);
                let near = self.pick(place(x, cos, self.size[0]), place(y, sin, self.size[1]))?;
                if near.as_ref().is_some_and(|pick| pick.strand.is_some()) {
                    return Ok(near);
                }
            }
        }
        Ok(first)
    }

    fn describe(&self, pick: Option<Pick>) -> Value {
        let Some(pick) = pick else { return json!({ "hit": false }) };
        let mut answer = json!({
            "hit": true, "name": pick.name, "point": pick.point.to_array(), "distance": pick.distance,
        });
        if let Some(strand) = pick.strand {
            answer["strand"] = json!({
                "number": strand.number,
                "index": strand.index,
                "look": strand.look,
                "h": strand.h,
                "theta": strand.theta.to_degrees(),
                "fiber": strand.fiber,
            });
        }
        answer
    }

    /// The fibre of a look, and its name.
    pub fn look(&self, index: usize) -> Option<(&str, &Fiber)> {
        self.now.looks.get(index).map(|(look, _)| (look.name.as_str(), &look.fiber))
    }

    /// The values of all controls.
    pub fn state(&self, revision: u64, busy: Option<String>, files: Vec<String>, note: Option<String>) -> State {
        let patterned = |look: usize| {
            let sets = self.source.iter().filter(|set| set.look == look);
            sets.flat_map(|set| &set.varying).any(|(parameter, _)| parameter.is_color())
        };
        let look = |(i, (look, coat)): (usize, &(Look, Coat))| LookState {
            name: look.name.clone(),
            fiber: serde_json::to_value(look.fiber).unwrap_or_default(),
            patterned: patterned(i),
            coat: *coat,
        };
        let other = self.history.other();
        let [can_undo, can_redo] = self.history.can();
        let light = |((name, light), (gain, shift)): (&(String, Light), &(f32, Vec3))| LightState {
            name: name.clone(),
            kind: light.shape.kind(),
            gain: *gain,
            shift: shift.to_array(),
            movable: !matches!(light.shape, LightShape::Dome { .. } | LightShape::Distant { .. }),
        };
        let strands: usize = self.world.curves().strands().iter().map(Strands::len).sum();
        State {
            kind: "state",
            revision,
            scene: vellus_io::visible(&self.name),
            warnings: self.warnings.iter().map(|warning| vellus_io::visible(warning)).collect(),
            summary: format!("{strands} strands, {}", self.world.summary()),
            looks: self.now.looks.iter().enumerate().map(look).collect(),
            lights: self.lights.iter().zip(&self.now.changes).map(light).collect(),
            version: self.history.shown(),
            other: OtherState {
                fibers: other
                    .looks
                    .iter()
                    .map(|(look, _)| serde_json::to_value(look.fiber).unwrap_or_default())
                    .collect(),
                model: other.model.kind.name(),
            },
            can_undo,
            can_redo,
            model: self.now.model.kind.name(),
            models: ModelKind::ALL.iter().map(|kind| kind.name()).collect(),
            azimuth: self.now.azimuth,
            groom: self.now.groom,
            busy,
            exposure: self.exposure,
            images: self.images,
            size: self.size,
            crop: self.crop,
            paused: self.paused,
            target: self.target,
            denoise: self.denoise,
            no_denoiser: self.denoiser.as_ref().err().cloned(),
            camera: self.orbit.report(),
            files,
            note,
        }
    }
}

/// The shape of a light after a change: its emission times `gain`, and moved. Domes and distant lights only turn.
fn change(shape: &LightShape, gain: f32, motion: Mat4) -> LightShape {
    let scaled = |color: &[f32; 3]| color.map(|c| c * gain);
    let turn = Mat3::from_mat4(motion);
    let mut shape = shape.clone();
    match &mut shape {
        LightShape::Dome { radiance, rotation, .. } => (*radiance, *rotation) = (scaled(radiance), turn * *rotation),
        LightShape::Distant { direction, irradiance, .. } => {
            (*direction, *irradiance) = ((turn * *direction).normalize(), scaled(irradiance));
        }
        LightShape::Rect { to_world, radiance, .. } | LightShape::Disk { to_world, radiance } => {
            (*to_world, *radiance) = (motion * *to_world, scaled(radiance));
        }
        LightShape::Point { position, intensity } => {
            (*position, *intensity) = (motion.transform_point3(*position), scaled(intensity));
        }
        LightShape::Sphere { center, radiance, .. } => {
            (*center, *radiance) = (motion.transform_point3(*center), scaled(radiance));
        }
        LightShape::Cylinder { center, half_axis, radiance, .. } => {
            (*center, *half_axis) = (motion.transform_point3(*center), turn * *half_axis);
            *radiance = scaled(radiance);
        }
    }
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn about z takes x to y. The lamp is a unit away from the middle.
    #[test]
    fn lamps_turn_about_the_middle_and_then_move() {
        let middle = Vec3::new(1.0, 2.0, 3.0);
        let quarter = Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let shift = Mat4::from_translation(Vec3::Z);
        let motion = shift * Mat4::from_translation(middle) * quarter * Mat4::from_translation(-middle);
        let tube =
            LightShape::Cylinder { center: middle + Vec3::X, half_axis: Vec3::X, radius: 0.1, radiance: [1.0; 3] };
        let LightShape::Cylinder { center, half_axis, radiance, .. } = change(&tube, 2.0, motion) else { panic!() };
        assert!(center.abs_diff_eq(middle + Vec3::Y + Vec3::Z, 1e-6) && half_axis.abs_diff_eq(Vec3::Y, 1e-6));
        assert_eq!(radiance, [2.0; 3]);
        let sun = LightShape::Distant { direction: Vec3::X, half_angle: 0.0, irradiance: [1.0; 3] };
        let LightShape::Distant { direction, .. } = change(&sun, 1.0, motion) else { panic!() };
        assert!(direction.abs_diff_eq(Vec3::Y, 1e-6));
    }
}
