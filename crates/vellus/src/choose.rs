//! Chooses one of several items in proportion to their weights.

use std::ops::ControlFlow;

/// A chosen item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice<T> {
    /// The item.
    pub item: T,
    /// Its weight, above 0.
    pub weight: f32,
    /// The target minus the weights before this item. It is in [0, `weight`), or just outside by rounding.
    pub rest: f32,
}

impl<T> Choice<T> {
    /// [`Choice::rest`] divided by the weight. If the target is uniform, this is a new uniform number. It is in [0, 1),
    /// or just outside by rounding.
    #[inline(always)]
    pub fn fraction(&self) -> f32 {
        self.rest / self.weight
    }
}

/// Selects an item. `target` is in [0, sum of all weights), which the weights divide in the order of the items. `None`
/// if no weight is above 0.
///
/// An item without weight is never chosen. If rounding puts the target beyond the sum, the last item with a weight is
/// chosen.
#[inline(always)]
pub fn choose<T>(items: impl IntoIterator<Item = (T, f32)>, target: f32) -> Option<Choice<T>> {
    let (mut rest, mut chosen) = (target, None);
    // A closure instead of a loop: the compiler then turns nested iterators into nested loops.
    let _ = items.into_iter().try_for_each(|(item, weight)| {
        if weight > 0.0 {
            chosen = Some(Choice { item, weight, rest });
            if rest < weight {
                return ControlFlow::Break(());
            }
        }
        rest -= weight;
        ControlFlow::Continue(())
    });
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_chosen_by_weight_and_never_without() {
        let items = [('a', 0.0), ('b', 0.25), ('c', 0.0), ('d', 0.5), ('e', 0.0)];
        let at = |target: f32| choose(items, target).map(|choice| (choice.item, choice.fraction()));
        assert_eq!(at(0.0), Some(('b', 0.0)));
        assert_eq!(at(0.125), Some(('b', 0.5)));
        assert_eq!(at(0.25), Some(('d', 0.0)));
        assert_eq!(at(0.5), Some(('d', 0.5)));
        assert_eq!(at(0.75), Some(('d', 1.0)));
        assert_eq!(choose([('a', 0.0)], 0.0), None);
    }
}
