//! Densities that are linear between nodes, and how to sample them.

/// A density that is linear between nodes, not normalised.
#[derive(Clone, Debug)]
pub(crate) struct Piecewise {
    values: Vec<f32>,
    /// The integral up to each node.
    cumulative: Vec<f32>,
}

impl Piecewise {
    /// `nodes` are the ascending places of the values.
    pub fn new(nodes: &[f32], values: Vec<f32>) -> Self {
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        for k in 1..nodes.len() {
            sum += 0.5 * f64::from(nodes[k] - nodes[k - 1]) * f64::from(values[k] + values[k - 1]);
            cumulative.push(sum as f32);
        }
        Piecewise { values, cumulative }
    }

    /// The integral over all nodes.
    pub fn total(&self) -> f32 {
        self.cumulative[self.cumulative.len() - 1]
    }

    /// The place whose share of the integral is `u`, in [0, 1].
    pub fn sample(&self, nodes: &[f32], u: f32) -> f32 {
        let target = u * self.total();
        let k = self.cumulative.partition_point(|sum| *sum <= target).clamp(1, nodes.len() - 1) - 1;
        let width = nodes[k + 1] - nodes[k];
        let (a, b) = (self.values[k], self.values[k + 1]);
        // a t + (b − a) t²/2 = rest, in the form that does not cancel.
        let rest = (target - self.cumulative[k]) / width;
        let root = a + (a * a + 2.0 * (b - a) * rest).max(0.0).sqrt();
        nodes[k] + width * (2.0 * rest / root.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_have_their_share_of_the_integral() {
        let nodes = [-1.0, -0.5, 0.5, 1.0];
        let density = Piecewise::new(&nodes, vec![0.0, 2.0, 2.0, 0.0]);
        assert_eq!(density.total(), 3.0);
        for (u, x) in [(0.0, -1.0), (1.0 / 24.0, -0.75), (1.0 / 6.0, -0.5), (0.5, 0.0), (1.0, 1.0)] {
            assert!((density.sample(&nodes, u) - x).abs() < 1e-6, "{u}: {}", density.sample(&nodes, u));
        }
        let empty = Piecewise::new(&nodes, vec![0.0; 4]);
        assert!(empty.sample(&nodes, 0.3).is_finite());
    }
}
