//! How meshes scatter: a diffuse base under a rough dielectric coat, or rough metal.
//!
//! The coat is a GGX microfacet surface (Walter et al. 2007) with Smith's joint shadowing, sampled by its visible
//! normals (Heitz 2018), with Schlick's reflectance F. The base is coupled to the coat (Kelemen, Szirmay-Kalos 2001):
//! its light is attenuated by (1 − F(θₒ)) (1 − F(θᵢ)) / (1 − F̄), with F̄ the cosine-weighted mean of F. The division
//! accounts for the light that the coat reflects back to the base. So a white base under a smooth coat scatters all
//! light. Directions point away from the surface, in a frame whose third axis is the normal.

use glam::Vec3;
use std::f32::consts::PI;

/// The scattering at a point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    color: [f32; 3],
    /// Reflectance at normal incidence.
    specular: [f32; 3],
    /// The weight of the base.
    diffuse: f32,
    /// α of GGX.
    alpha: f32,
}

impl Scatter {
    /// Creates the scattering from parameters of UsdPreviewSurface: see [`vellus_scene::Surface`].
    pub fn new(color: [f32; 3], roughness: f32, metallic: f32, ior: f32) -> Self {
        let coat = ((ior - 1.0) / (ior + 1.0)).powi(2);
        Scatter {
            color,
            specular: color.map(|c| coat + (c - coat) * metallic),
            diffuse: 1.0 - metallic,
            alpha: (roughness * roughness).max(1e-3),
        }
    }

    fn has_coat(&self) -> bool {
        self.specular.iter().any(|&s| s > 0.0)
    }

    fn fresnel(&self, cos: f32) -> [f32; 3] {
        let k = (1.0 - cos.clamp(0.0, 1.0)).powi(5);
        if self.has_coat() { self.specular.map(|s| s + (1.0 - s) * k) } else { [0.0; 3] }
    }

    /// (1 − F(θₒ)) (1 − F(θᵢ)) / (1 − F̄). With s at normal incidence and k = (1 − cos θ)⁵, 1 − F = (1 − s) (1 − k) and
    /// F̄ = s + (1 − s) / 21. The factor 1 − s cancels, so that nothing is divided by zero.
    fn through_coat(&self, cos_o: f32, cos_i: f32) -> [f32; 3] {
        if !self.has_coat() {
            return [1.0; 3];
        }
        let through = |cos: f32| 1.0 - (1.0 - cos.clamp(0.0, 1.0)).powi(5);
        self.specular.map(|s| (1.0 - s) * through(cos_o) * through(cos_i) * (21.0 / 20.0))
    }

    /// The probability of sampling the coat.
    fn coat_share(&self, cos_o: f32) -> f32 {
        let mean = |c: [f32; 3]| (c[0] + c[1] + c[2]) / 3.0;
        let coat = mean(self.fresnel(cos_o));
        let base = (1.0 - coat) * self.diffuse * mean(self.color);
        if coat <= 0.0 { 0.0 } else { (coat / (coat + base)).clamp(0.1, 1.0) }
    }

    fn distribution(&self, m: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        let t = (m.x * m.x + m.y * m.y) / a2 + m.z * m.z;
        1.0 / (PI * a2 * t * t)
    }

    fn lambda(&self, w: Vec3) -> f32 {
        let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z).max(1e-12);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// f·cos θᵢ, and the density per solid angle with which [`Scatter::sample`] samples `wi`.
    pub fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> ([f32; 3], f32) {
        let ([base, coat], pdf) = self.eval_parts(wo, wi);
        (std::array::from_fn(|c| base[c] + coat[c]), pdf)
    }

    /// As [`Scatter::eval_pdf`], with f·cos θᵢ of the base and of the coat or metal.
    pub fn eval_parts(&self, wo: Vec3, wi: Vec3) -> ([[f32; 3]; 2], f32) {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return ([[0.0; 3]; 2], 0.0);
        }
        let share = self.coat_share(wo.z);
        let through = self.through_coat(wo.z, wi.z);
        let base = wi.z / PI;
        let diffuse = std::array::from_fn(|c| self.diffuse * self.color[c] * through[c] * base);
        let mut coat = [0.0; 3];
        let mut pdf = (1.0 - share) * base;
        if share > 0.0 {
            let m = (wo + wi).normalize_or(Vec3::Z);
            let d = self.distribution(m);
            let (lo, li) = (self.lambda(wo), self.lambda(wi));
            let reflected = self.fresnel(m.dot(wo));
            let shape = d / (1.0 + lo + li) / (4.0 * wo.z);
            coat = reflected.map(|r| r * shape);
            pdf += share * d / (1.0 + lo) / (4.0 * wo.z);
        }
        ([diffuse, coat], pdf)
    }

    /// Samples `wi`. Returns it with its density, and f·cos θᵢ divided by the density. `None` if it is below the
    /// surface.
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, f32, [f32; 3])> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = if u[2] < self.coat_share(wo.z) {
            let m = self.visible_normal(wo, [u[0], u[1]]);
            m * (2.0 * wo.dot(m)) - wo
        } else {
            let (x, y) = crate::light::sampling::concentric([u[0], u[1]]);
            Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
        };
        let (f, pdf) = self.eval_pdf(wo, wi);
        (pdf > 0.0).then(|| (wi, pdf, f.map(|f| f / pdf)))
    }

    fn visible_normal(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let a = self.alpha;
        let v = Vec3::new(a * wo.x, a * wo.y, wo.z).normalize();
        let across = v.x * v.x + v.y * v.y;
        let t1 = if across > 0.0 { Vec3::new(-v.y, v.x, 0.0) / across.sqrt() } else { Vec3::X };
        let t2 = v.cross(t1);
        let (x, y) = crate::light::sampling::concentric(u);
        let s = 0.5 * (1.0 + v.z);
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * y;
        let n = t1 * x + t2 * y + v * (1.0 - x * x - y * y).max(0.0).sqrt();
        Vec3::new(a * n.x, a * n.y, n.z.max(1e-6)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::sampler::Sampler;

    /// Sampled weights and uniform directions agree. No surface scatters more than it receives. Densities integrate to
    /// 1 if no direction is lost below the surface.
    #[test]
    fn samples_agree_with_eval() {
        for (roughness, metallic, ior) in [(1.0, 0.0, 1.0), (0.4, 0.0, 1.5), (0.6, 1.0, 1.5), (0.3, 0.5, 1.3)] {
            let scatter = Scatter::new([0.9, 0.5, 0.3], roughness, metallic, ior);
            for wo in [Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.6, 0.5, 0.4).normalize()] {
                let n = 1 << 16;
                let (mut drawn, mut uniform, mut pdf) = ([0.0f64; 3], [0.0f64; 3], 0.0f64);
                for i in 0..n {
                    let u = Sampler::new([1, 2], i, 3).next();
                    if let Some((wi, p, weight)) = scatter.sample(wo, [u[0], u[1], u[2]]) {
                        (0..3).for_each(|c| drawn[c] += f64::from(weight[c]) / n as f64);
                        let again = scatter.eval_pdf(wo, wi).1;
                        assert!((again / p - 1.0).abs() < 1e-3);
                    }
                    let (sin, cos) = (std::f32::consts::TAU * u[1]).sin_cos();
                    let s = (1.0 - u[0] * u[0]).sqrt();
                    let (f, p) = scatter.eval_pdf(wo, Vec3::new(s * cos, s * sin, u[0]));
                    (0..3).for_each(|c| uniform[c] += f64::from(f[c] * 2.0 * PI) / n as f64);
                    pdf += f64::from(p * 2.0 * PI) / n as f64;
                }
                for c in 0..3 {
                    // Uniform directions have about 1 % of noise for the sharpest lobe, α = 0.09.
                    assert!((drawn[c] - uniform[c]).abs() < 0.02, "{drawn:?} {uniform:?}");
                    assert!(drawn[c] <= 1.0, "{drawn:?}");
                }
                assert!(pdf < 1.02 && pdf > 0.85, "{pdf}");
            }
        }
    }

    /// The base alone returns color · (1 − F(θₒ)) of the light: the coat loses nothing. The quadrature is a midpoint
    /// rule in cos² θᵢ with 4,096 points, whose error is far below the bound.
    #[test]
    fn white_base_under_coat_loses_nothing() {
        for (metallic, ior) in [(0.0, 1.0), (0.0, 1.5), (0.0, 3.0), (0.5, 1.5), (0.0, 1e6)] {
            let scatter = Scatter::new([1.0, 0.5, 0.1], 0.0, metallic, ior);
            for cos_o in [0.05f32, 0.4, 1.0] {
                let n = 4096;
                let mut sum = [0.0f64; 3];
                for i in 0..n {
                    let cos_i = ((i as f32 + 0.5) / n as f32).sqrt();
                    let through = scatter.through_coat(cos_o, cos_i);
                    (0..3).for_each(|c| sum[c] += f64::from(through[c]) / f64::from(n));
                }
                for (c, reflected) in scatter.fresnel(cos_o).into_iter().enumerate() {
                    let passed = f64::from(1.0 - reflected);
                    assert!((sum[c] - passed).abs() < 1e-4, "{} {passed}", sum[c]);
                }
            }
        }
    }
}
