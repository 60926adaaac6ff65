//! Arithmetic of RGB colours, and the weights of samples.

pub(super) type Rgb = [f32; 3];

pub(super) fn times(a: Rgb, b: Rgb) -> Rgb {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub(super) fn scale(a: Rgb, s: f32) -> Rgb {
    a.map(|x| x * s)
}

pub(super) fn largest(a: Rgb) -> f32 {
    a[0].max(a[1]).max(a[2])
}

/// The multiple importance sampling weight of one of two techniques: power heuristic (Veach 1997).
pub(super) fn weight(own: f32, other: f32) -> f32 {
    if own.is_infinite() {
        return 1.0;
    }
    let (a, b) = (own * own, other * other);
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}
