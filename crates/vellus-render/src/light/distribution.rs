//! A piecewise-constant distribution in one dimension, with a guide table.

/// A piecewise-constant density on [0, 1): one interval for each value, sampled in proportion to it.
#[derive(Clone, Debug)]
pub(crate) struct PiecewiseConstant1D {
    /// The start of each interval, and the end of the last one. From 0 to 1.
    sums: Vec<f32>,
    /// A guide table: [0, 1) is divided into as many equal steps as there are intervals. For each step, this is the
    /// interval in which it starts. A search from there is short (Chen and Asau 1974, On Generating Random Variates
    /// from an Empirical Distribution).
    guide: Vec<u32>,
}

impl PiecewiseConstant1D {
    /// Intervals in proportion to values, which must not be negative. Intervals are equal if all values are 0.
    pub fn new(values: impl ExactSizeIterator<Item = f32>) -> Self {
        let n = values.len();
        let mut sums = Vec::with_capacity(n + 1);
        sums.push(0.0f64);
        for v in values {
            sums.push(sums[sums.len() - 1] + f64::from(v));
        }
        let total = sums[n];
        let share = |i: usize| if total > 0.0 { sums[i] / total } else { i as f64 / n as f64 };
        let sums: Vec<f32> = (0..=n).map(|i| share(i) as f32).collect();
        let begin = |i: usize| sums.partition_point(|&s| s <= i as f32 / n as f32).clamp(1, n) - 1;
        let guide = (0..n).map(|i| begin(i) as u32).collect();
        PiecewiseConstant1D { sums, guide }
    }

    /// The start of each interval, and the end of the last one.
    pub fn sums(&self) -> &[f32] {
        &self.sums
    }

    /// The width of an interval: its probability.
    pub fn width(&self, i: usize) -> f32 {
        self.sums[i + 1] - self.sums[i]
    }

    /// The interval that contains a number in [0, 1), and the position in it, in [0, 1).
    pub fn pick(&self, u: f32) -> (usize, f32) {
        let n = self.guide.len();
        let step = ((u * n as f32) as usize).min(n - 1);
        // The step may be rounded up, so start one step before.
        let mut i = self.guide[step.saturating_sub(1)] as usize;
        while i + 1 < n && self.sums[i + 1] <= u {
            i += 1;
        }
        let width = self.width(i);
        (i, if width > 0.0 { ((u - self.sums[i]) / width).clamp(0.0, 0.999_999_94) } else { 0.5 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The guide table finds the same interval as binary search: for equal values, for a few large values among many
    /// zeros, and for one value.
    #[test]
    fn guides_lead_to_the_interval() {
        let numbers: [fn(usize) -> f32; 4] =
            [|_| 1.0, |i| if i % 37 == 5 { 3.0 + i as f32 } else { 0.0 }, |i| 0.9f32.powi(i as i32), |_| 0.0];
        for (number, n) in numbers.into_iter().flat_map(|number| [1, 2, 777].map(|n| (number, n))) {
            let all = PiecewiseConstant1D::new((0..n).map(number));
            let edges = all.sums.iter().flat_map(|s| [s.next_down(), *s, s.next_up()]);
            for u in (0..5000).map(|i| i as f32 / 5000.0).chain(edges).filter(|u| (0.0..1.0).contains(u)) {
                let found = all.pick(u).0;
                assert_eq!(found, all.sums.partition_point(|&s| s <= u).clamp(1, n) - 1, "{n} {u}");
            }
        }
    }
}
