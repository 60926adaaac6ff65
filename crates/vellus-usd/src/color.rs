//! Colour spaces by their names in MaterialX and OpenUSD, and their conversion to linear Rec. 709.

use glam::{DMat3, DVec3};
use vellus_io::excerpt;

/// How the numbers of a colour are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ColorSpace {
    gamut: Gamut,
    curve: Curve,
}

/// Primaries and a white point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Gamut {
    /// ITU-R BT.709, which is also that of sRGB (IEC 61966-2-1).
    Rec709,
    /// ITU-R BT.2020.
    Rec2020,
    /// SMPTE RP 431-2 with the white of daylight: Display P3.
    P3,
    /// Adobe RGB (1998).
    Adobe,
    /// SMPTE ST 2065-1: ACES.
    Ap0,
    /// ACEScg (S-2014-004).
    Ap1,
    /// CIE XYZ, whose white is daylight.
    Xyz,
}

/// A function from the numbers of a file to linear ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Curve {
    Linear,
    /// IEC 61966-2-1.
    Srgb,
    Gamma18,
    Gamma22,
    /// The display of ITU-R BT.1886.
    Gamma24,
    /// 563/256, of Adobe RGB.
    Adobe,
}

/// Names in MaterialX (the standard library of 1.39, and older documents), in OpenUSD (`GfColorSpaceNames`, and the
/// shorter names before 25.05), and of UsdUVTexture.
const NAMES: [(&str, Gamut, Curve); 37] = [
    ("none", Gamut::Rec709, Curve::Linear),
    ("raw", Gamut::Rec709, Curve::Linear),
    ("data", Gamut::Rec709, Curve::Linear),
    ("identity", Gamut::Rec709, Curve::Linear),
    ("lin_rec709", Gamut::Rec709, Curve::Linear),
    ("lin_rec709_scene", Gamut::Rec709, Curve::Linear),
    ("lin_srgb", Gamut::Rec709, Curve::Linear),
    ("srgb_texture", Gamut::Rec709, Curve::Srgb),
    ("srgb_rec709_scene", Gamut::Rec709, Curve::Srgb),
    ("sRGB", Gamut::Rec709, Curve::Srgb),
    ("gamma18", Gamut::Rec709, Curve::Gamma18),
    ("g18_rec709", Gamut::Rec709, Curve::Gamma18),
    ("g18_rec709_scene", Gamut::Rec709, Curve::Gamma18),
    ("gamma22", Gamut::Rec709, Curve::Gamma22),
    ("g22_rec709", Gamut::Rec709, Curve::Gamma22),
    ("g22_rec709_scene", Gamut::Rec709, Curve::Gamma22),
    ("gamma24", Gamut::Rec709, Curve::Gamma24),
    ("rec709_display", Gamut::Rec709, Curve::Gamma24),
    ("acescg", Gamut::Ap1, Curve::Linear),
    ("lin_ap1", Gamut::Ap1, Curve::Linear),
    ("lin_ap1_scene", Gamut::Ap1, Curve::Linear),
    ("g22_ap1", Gamut::Ap1, Curve::Gamma22),
    ("g22_ap1_scene", Gamut::Ap1, Curve::Gamma22),
    ("srgb_ap1_scene", Gamut::Ap1, Curve::Srgb),
    ("lin_ap0", Gamut::Ap0, Curve::Linear),
    ("lin_ap0_scene", Gamut::Ap0, Curve::Linear),
    ("adobergb", Gamut::Adobe, Curve::Adobe),
    ("g22_adobergb_scene", Gamut::Adobe, Curve::Adobe),
    ("lin_adobergb", Gamut::Adobe, Curve::Linear),
    ("lin_adobergb_scene", Gamut::Adobe, Curve::Linear),
    ("srgb_displayp3", Gamut::P3, Curve::Srgb),
    ("srgb_p3d65_scene", Gamut::P3, Curve::Srgb),
    ("lin_displayp3", Gamut::P3, Curve::Linear),
    ("lin_p3d65_scene", Gamut::P3, Curve::Linear),
    ("lin_rec2020", Gamut::Rec2020, Curve::Linear),
    ("lin_rec2020_scene", Gamut::Rec2020, Curve::Linear),
    ("lin_ciexyzd65_scene", Gamut::Xyz, Curve::Linear),
];

/// The white point of daylight at 6500 K (CIE, ISO 11664-2).
const DAYLIGHT: [f64; 2] = [0.3127, 0.3290];

/// The colour of a black body at a temperature in kelvin, with the luminance 1, in linear Rec. 709. Temperatures are
/// held in [1000, 15000], the range of the approximation (Krystek 1985, An algorithm to calculate correlated colour
/// temperature). Colours outside of Rec. 709, below 1900 K, lose their negative blue.
pub(crate) fn blackbody(kelvin: f64) -> [f64; 3] {
    let t = kelvin.clamp(1000.0, 15_000.0);
    let u = (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
        / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t);
    let v = (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
        / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t);
    // From the uniform scale of 1960 to XYZ.
    let [x, y] = [3.0 * u, 2.0 * v].map(|n| n / (2.0 * u - 8.0 * v + 4.0));
    let to_xyz = Gamut::Rec709.to_xyz();
    let color = (to_xyz.inverse() * DVec3::new(x / y, 1.0, (1.0 - x - y) / y)).max(DVec3::ZERO);
    (color / (to_xyz * color).y).into()
}

/// The white point of ACES.
const ACES: [f64; 2] = [0.32168, 0.33767];

impl ColorSpace {
    /// Linear numbers of Rec. 709, or plain numbers.
    pub const LINEAR: ColorSpace = ColorSpace { gamut: Gamut::Rec709, curve: Curve::Linear };

    /// The sRGB curve, with the primaries of Rec. 709.
    pub const SRGB: ColorSpace = ColorSpace { gamut: Gamut::Rec709, curve: Curve::Srgb };

    /// The space with a name.
    pub fn named(name: &str) -> Option<Self> {
        let found = NAMES.iter().find(|(known, ..)| *known == name)?;
        Some(ColorSpace { gamut: found.1, curve: found.2 })
    }

    /// The linear value of a channel.
    pub fn decode(self, x: f64) -> f64 {
        self.curve.decode(x)
    }

    /// The matrix from linear numbers to Rec. 709, if they differ.
    pub fn to_rec709(self) -> Option<DMat3> {
        (self.gamut != Gamut::Rec709).then(|| {
            // A colour with the white of its space becomes one with the white of Rec. 709.
            Gamut::Rec709.to_xyz().inverse() * adaptation(self.gamut.white(), DAYLIGHT) * self.gamut.to_xyz()
        })
    }

    /// The function of a colour that gives it in linear Rec. 709. Channels are negative where the colour is outside of
    /// that space.
    pub fn converter(self) -> impl Fn([f64; 3]) -> [f64; 3] {
        let matrix = self.to_rec709();
        move |color| {
            let linear = color.map(|x| self.decode(x));
            matrix.map_or(linear, |matrix| (matrix * DVec3::from(linear)).into())
        }
    }
}

impl Curve {
    /// Negative numbers mirror positive ones, so that they stay negative and are noticed.
    fn decode(self, x: f64) -> f64 {
        let power = |exponent: f64| x.abs().powf(exponent).copysign(x);
        match self {
            Curve::Linear => x,
            Curve::Srgb if x.abs() <= 0.04045 => x / 12.92,
            Curve::Srgb => ((x.abs() + 0.055) / 1.055).powf(2.4).copysign(x),
            Curve::Gamma18 => power(1.8),
            Curve::Gamma22 => power(2.2),
            Curve::Gamma24 => power(2.4),
            Curve::Adobe => power(563.0 / 256.0),
        }
    }
}

impl Gamut {
    fn white(self) -> [f64; 2] {
        if matches!(self, Gamut::Ap0 | Gamut::Ap1) { ACES } else { DAYLIGHT }
    }

    /// The matrix from linear RGB to XYZ, in which white has Y = 1 (SMPTE RP 177).
    fn to_xyz(self) -> DMat3 {
        let primaries = match self {
            Gamut::Rec709 => [[0.640, 0.330], [0.300, 0.600], [0.150, 0.060]],
            Gamut::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
            Gamut::P3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]],
            Gamut::Adobe => [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06]],
            Gamut::Ap0 => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770]],
            Gamut::Ap1 => [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]],
            Gamut::Xyz => return DMat3::IDENTITY,
        };
        let [r, g, b] = primaries.map(|[x, y]| DVec3::new(x, y, 1.0 - x - y));
        let columns = DMat3::from_cols(r, g, b);
        columns * DMat3::from_diagonal(columns.inverse() * xyz(self.white()))
    }
}

/// The colour with a chromaticity and Y = 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Bradford's matrix from one white point to another, for colours in XYZ.
fn adaptation(from: [f64; 2], to: [f64; 2]) -> DMat3 {
    // The columns of the matrix to cone responses (Lam 1985).
    let cones = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    cones.inverse() * DMat3::from_diagonal((cones * xyz(to)) / (cones * xyz(from))) * cones
}

/// What to say about a name that [`ColorSpace::named`] does not know.
pub(crate) fn unknown(name: &str) -> String {
    format!("the colour space {} is not supported", excerpt(name.as_bytes(), 60))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published matrices, row by row: the MaterialX standard library (whose matrix of Display P3 is transposed, so
    /// that one and XYZ are of CSS Color 4), ITU-R BT.2087 (four digits), and OpenColorIO's ACES2065-1 to Rec. 709.
    #[test]
    fn matrices_are_those_that_others_published() {
        let published = [
            (
                "lin_ap1",
                [
                    [1.705050992658, -0.621792120657, -0.083258872001],
                    [-0.130256417507, 1.140804736575, -0.010548319068],
                    [-0.024003356805, -0.128968976065, 1.15297233287],
                ],
                1e-6,
            ),
            (
                "lin_adobergb",
                [[1.39835574, -0.398355744, 0.0], [0.0, 1.0, 0.0], [0.0, -0.0429289893, 1.04292899]],
                1e-6,
            ),
            (
                "lin_displayp3",
                [
                    [1.22494017628056, -0.22494017628056, 0.0],
                    [-0.0420569547096882, 1.04205695470969, 0.0],
                    [-0.0196375545903344, -0.0786360455506319, 1.09827360014097],
                ],
                1e-6,
            ),
            (
                "lin_rec2020",
                [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]],
                5.1e-5,
            ),
            (
                "lin_ap0",
                [
                    [2.52168618674388, -1.13413098823972, -0.387555198504164],
                    [-0.276479914229922, 1.37271908766826, -0.0962391734383399],
                    [-0.0153780649660342, -0.152975335867399, 1.16835340083343],
                ],
                1e-6,
            ),
            (
                "lin_ciexyzd65_scene",
                [
                    [3.2409699419045226, -1.537383177570094, -0.4986107602930034],
                    [-0.9692436362808796, 1.8759675015077202, 0.04155505740717559],
                    [0.05563007969699366, -0.20397695888897652, 1.0569715142428786],
                ],
                1e-6,
            ),
        ];
        for (name, rows, tolerance) in published {
            let matrix = ColorSpace::named(name).unwrap().to_rec709().unwrap();
            for (i, row) in rows.into_iter().enumerate() {
                let error = (matrix.row(i) - DVec3::from(row)).abs().max_element();
                assert!(error < tolerance, "{name} {i}: {} {row:?}", matrix.row(i));
            }
        }
    }

    #[test]
    fn curves_give_the_values_of_hand_calculation() {
        let linear = |name: &str, x: f64| ColorSpace::named(name).unwrap().converter()([x; 3]);
        for (name, expected) in [
            // ((0.5 + 0.055) / 1.055)^2.4
            ("srgb_texture", 0.2140411),
            ("gamma18", 0.2871746),
            ("gamma22", 0.2176376),
            ("rec709_display", 0.1894646),
            ("adobergb", 0.2177555),
            // White stays white in all spaces, and so does grey.
            ("g22_ap1", 0.2176376),
            ("srgb_displayp3", 0.2140411),
            ("acescg", 0.5),
            ("none", 0.5),
        ] {
            for channel in linear(name, 0.5) {
                assert!((channel - expected).abs() < 1e-7, "{name} {channel}");
            }
            assert!(linear(name, -0.5)[0] < 0.0);
        }
        // The two parts of the curve of sRGB.
        assert_eq!(linear("sRGB", 0.04)[0], 0.04 / 12.92);
        assert!(ColorSpace::named("Color3").is_none() && ColorSpace::named("auto").is_none());
        for (i, (name, ..)) in NAMES.iter().enumerate() {
            assert!(NAMES[..i].iter().all(|(other, ..)| other != name), "{name} is twice in the list");
        }
    }
}
