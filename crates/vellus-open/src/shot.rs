//! When and with which lens a picture is taken, for headers of files.

use crate::Opened;

impl Opened {
    /// Names of standard attributes of OpenEXR and their values, for a picture of this size of a USD file:
    /// `framesPerSecond` and `imageCounter` (the frame) if the stage has time, and if it has a camera
    /// `pinholeFocalLength`, `sensorOverallDimensions` (in mm, what the picture shows), `aperture` (the f-number) and
    /// `focus` (in metres). `vellus_render` writes them.
    pub fn shot_notes(&self, size: [usize; 2]) -> Vec<(String, String)> {
        let mut notes = Vec::new();
        let mut note = |name: &str, value: String| notes.push((name.to_owned(), value));
        let Some(shot) = self.shot else { return notes };
        if let Some(frame) = shot.frame {
            let [over, under] = rational(shot.frames_per_second);
            note("framesPerSecond", format!("{over}/{under}"));
            if frame == f64::from(frame as i32) {
                note("imageCounter", frame.to_string());
            }
        }
        if let (Some(focal), Some(camera), Some(units)) = (shot.focal_length, self.scene.camera, self.scene.units) {
            let millimeters = 1000.0 * units.meters_per_unit * focal;
            let film = camera.film(size[0] as f32 / size[1] as f32).map(|side| (f64::from(side) * millimeters) as f32);
            note("pinholeFocalLength", (millimeters as f32).to_string());
            note("sensorOverallDimensions", format!("{} {}", film[0], film[1]));
            if camera.lens_radius > 0.0 {
                let diameter = 2.0 * f64::from(camera.lens_radius);
                note("aperture", ((focal / diameter) as f32).to_string());
                note("focus", ((f64::from(camera.focus_distance) * units.meters_per_unit) as f32).to_string());
            }
        }
        notes
    }
}

/// A rate of frames as a fraction: whole numbers, those of NTSC over 1001, and others in thousandths.
fn rational(rate: f64) -> [u32; 2] {
    let over = |under: u32| [(rate * f64::from(under)).round() as u32, under];
    // 23.976 means 24000/1001, which is 10⁻⁶ more.
    let is_close = |[over, under]: &[u32; 2]| (f64::from(*over) / f64::from(*under) / rate - 1.0).abs() < 2e-6;
    let ntsc = Some(over(1001)).filter(|[over, _]| over % 1000 == 0);
    [Some(over(1)), ntsc].into_iter().flatten().find(is_close).unwrap_or_else(|| over(1000))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, open};

    #[test]
    fn rates_are_fractions() {
        let rates = [24.0, 23.976, 29.97, 59.94, 24000.0 / 1001.0, 12.5, 23.98].map(rational);
        let expected =
            [[24, 1], [24000, 1001], [30000, 1001], [60000, 1001], [24000, 1001], [12500, 1000], [23980, 1000]];
        assert_eq!(rates, expected);
    }

    /// A lens of 50 mm and f/2 in a stage in metres, focused at 3 m: lengths of USD's lenses are tenths of a unit.
    #[test]
    fn headers_have_the_frame_and_the_lens() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lens.usda");
        let notes = |metadata: &str, frame| {
            let text = format!(
                "#usda 1.0\n( {metadata} )\ndef BasisCurves \"b\" {{ uniform token type = \"linear\"
                int[] curveVertexCounts = [2] point3f[] points = [(0, 0, 0), (0, 1, 0)] float[] widths = [0.1, 0.1] }}
                def Camera \"c\" {{ float focalLength = 0.5 float horizontalAperture = 0.36
                float verticalAperture = 0.24 float fStop = 2 float focusDistance = 3 }}"
            );
            std::fs::write(&path, text).unwrap();
            let opened = open(&path, &Options { frame, ..Options::default() }).unwrap();
            let all = opened.shot_notes([300, 200]);
            all.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
        };
        let lens = "pinholeFocalLength 50, sensorOverallDimensions 36 24, aperture 2, focus 3";
        assert_eq!(notes("metersPerUnit = 1", None), lens);
        assert_eq!(
            notes("metersPerUnit = 1 timeCodesPerSecond = 25", Some(7.0)),
            format!("framesPerSecond 25/1, imageCounter 7, {lens}")
        );
        assert_eq!(notes("metersPerUnit = 1", Some(0.5)), format!("framesPerSecond 24/1, {lens}"));
    }
}
