//! Coats of the ten species: markings by their written descriptions.

use crate::markings::Markings;
use vellus::Species;

/// A species; colours from root to tip ([`Ramp`](crate::Ramp)); the belly; other strands ([`Mix`](crate::Mix)).
///
/// The patterns are those of the accounts in *Mammalian Species* (red fox: no. 537, bobcat: 563, raccoon: 119,
/// white-tailed deer in summer: 388, springbok: 753) and of wild mice, rabbits and tabby cats, whose hair is agouti
/// (Silvers 1979, The Coat Colors of Mice). The dog is a yellow one, and the human has brown hair. We know of no
/// published measurement of these colours, so they are choices of ours, as the names of colours are.
#[rustfmt::skip]
const COATS: [(Species, &str, &str, &str); 10] = [
    (Species::Bobcat, "slate buff@35% hazel@70% sable", "0.68,0.66,0.60", "sable:10%"),
    (Species::Cat, "slate fawn@40% hazel@70% sable", "buff", "sable:15%"),
    (Species::Deer, "hazel chestnut@40% chestnut", "0.68,0.66,0.60", "sable:5%"),
    (Species::Dog, "cream buff@40% buff", "cream", "cream:20%"),
    (Species::Mouse, "slate slate@50% fawn@70% fawn@85% sable", "buff", "sable:15%"),
    (Species::Rabbit, "slate slate@40% buff@60% buff@80% sable", "0.68,0.66,0.60", "sable:15%"),
    (Species::Raccoon, "mouse mouse@45% silver@65% slate@85% sable", "silver", "sable:20%"),
    (Species::RedFox, "slate fox@40% fox", "0.68,0.66,0.60", "sable:6%"),
    (Species::Springbok, "buff fox@50% fox", "0.68,0.66,0.60", "cream:10%"),
    (Species::Human, "sable chestnut@60% chestnut", "", ""),
];

impl Markings {
    /// The markings of a typical coat of a species. They are no measurement.
    pub fn of(species: Species) -> Self {
        let row = COATS.iter().find(|(of, ..)| *of == species);
        let Some((_, ramp, belly, mix)) = row else { return Markings::default() };
        Markings {
            ramp: ramp.parse().ok(),
            belly: crate::color::reflectance(belly).ok(),
            tips: None,
            mix: mix.parse().ok().into_iter().collect(),
        }
    }

    /// These markings, and those of `base` where there are none here.
    #[must_use]
    pub fn or(self, base: Markings) -> Self {
        Markings {
            ramp: self.ramp.or(base.ramp),
            belly: self.belly.or(base.belly),
            tips: self.tips.or(base.tips),
            mix: if self.mix.is_empty() { base.mix } else { self.mix },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_species_has_a_coat() {
        for (species, (_, _, belly, mix)) in Species::ALL.into_iter().zip(COATS) {
            let coat = Markings::of(species);
            assert!(coat.ramp.is_some(), "{species}");
            assert_eq!((coat.belly.is_some(), coat.mix.len()), (!belly.is_empty(), usize::from(!mix.is_empty())));
            // What somebody asks for replaces the coat's.
            let own = Markings { belly: Some([0.5; 3]), ..Markings::default() };
            assert_eq!(own.or(coat.clone()), Markings { belly: Some([0.5; 3]), ..coat });
        }
    }
}
