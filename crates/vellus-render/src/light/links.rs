//! Light linking: classes of things that the same lights reach, and the things that cast shadows in each light.

use std::collections::{HashMap, HashSet};
use vellus_scene::{Light, Link, Objects};

/// The links of all lights. Things are sets of strands first, then meshes.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    /// The class of each thing.
    class: Vec<u32>,
    /// For each class, whether each light reaches its things. All lights reach those of the first class.
    pub reaches: Vec<Vec<bool>>,
    /// For each light, the index of the things that cast shadows; `None` if all do.
    casters: Vec<Option<usize>>,
    /// Whether each thing casts shadows.
    casts: Vec<Vec<bool>>,
    /// The gains of each light: diffuse and specular.
    gains: Vec<Option<[f32; 2]>>,
}

impl Links {
    /// Prepares the links of lights. `names` are those of all things.
    pub fn new(all: &[Light], names: &[String]) -> Self {
        let lights = all.len();
        let linked = |(i, light): (usize, &'_ Light)| Some((i, light.link.clone()?));
        let links: Vec<(usize, Link)> = all.iter().enumerate().filter_map(linked).collect();
        let mut reaches = vec![vec![true; lights]];
        let mut class = vec![0u32; names.len()];
        let linked: Vec<(usize, Vec<bool>)> =
            links.iter().map(|(light, link)| (*light, members(&link.lit, names))).collect();
        let mut known: HashMap<Vec<bool>, u32> = HashMap::from([(vec![true; linked.len()], 0)]);
        for (thing, class) in class.iter_mut().enumerate() {
            let lit: Vec<bool> = linked.iter().map(|(_, members)| members[thing]).collect();
            *class = *known.entry(lit).or_insert_with_key(|lit| {
                let mut row = vec![true; lights];
                linked.iter().zip(lit).for_each(|((light, _), lit)| row[*light] = *lit);
                reaches.push(row);
                reaches.len() as u32 - 1
            });
        }
        let (mut casters, mut casts, mut gains) = (vec![None; lights], Vec::new(), vec![None; lights]);
        let mut equal: HashMap<&Objects, usize> = HashMap::new();
        for (light, link) in &links {
            if link.casters != Objects::ALL {
                casters[*light] = Some(*equal.entry(&link.casters).or_insert_with(|| {
                    casts.push(members(&link.casters, names));
                    casts.len() - 1
                }));
            }
            gains[*light] = Some([link.diffuse, link.specular]).filter(|gains| *gains != [1.0; 2]);
        }
        Links { class, reaches, casters, casts, gains }
    }

    /// The class of a thing.
    pub fn class(&self, thing: usize) -> usize {
        self.class[thing] as usize
    }

    /// The classes of all things.
    pub fn classes(&self) -> &[u32] {
        &self.class
    }

    /// Whether each thing casts shadows in a light. `None` if all do.
    pub fn casters(&self, light: usize) -> Option<&[bool]> {
        self.casters[light].map(|index| &self.casts[index][..])
    }

    /// The gains of a light: diffuse and specular. `None` if they change nothing.
    pub fn gains(&self, light: usize) -> Option<[f32; 2]> {
        self.gains[light]
    }

    /// Whether any light has gains.
    pub fn any_gains(&self) -> bool {
        self.gains.iter().any(Option::is_some)
    }
}

/// Whether each of some names is among the objects.
fn members(objects: &Objects, names: &[String]) -> Vec<bool> {
    let (listed, is_member) = match objects {
        Objects::Except(names) => (names, false),
        Objects::Only(names) => (names, true),
    };
    let listed: HashSet<&String> = listed.iter().collect();
    names.iter().map(|name| listed.contains(name) == is_member).collect()
}
