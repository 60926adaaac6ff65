//! Members of collections (UsdCollectionAPI).

use super::{Failure, Stage};
use crate::error::Error;
use crate::read::link::LINKS;
use openusd::{sdf, usd};
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

/// The largest number of nested collections. `openusd` is recursive over them.
const MOST_COLLECTIONS: usize = 200;

/// Members of collections, by path; `None` if an expression defines them.
pub(super) type Members = RefCell<HashMap<String, Option<usd::MembershipQuery>>>;

impl Stage {
    /// Whether a prim is in the collection with this path (`/prim.collection:name`). `None` if an expression defines
    /// the collection, because `openusd` does not evaluate expressions.
    pub fn includes(&self, collection: &str, prim: &str) -> Result<Option<bool>, Error> {
        if let Some(members) = self.members.borrow().get(collection) {
            let prim = self.instances.borrow().composed_with(collection, prim);
            return Ok(members.as_ref().map(|members| members.is_path_included(&sdf::Path::from(prim.as_str()))));
        }
        let members = self.ask(collection, |collection| {
            let Some((owner, name)) = usd::is_collection_api_path(&sdf::Path::from(collection)) else {
                return Ok(Some(usd::MembershipQuery::default()));
            };
            let collection = usd::Collection::new(owner, name);
            self.check_chain(&collection)?;
            if collection.has_expression(&self.stage)? {
                return Ok(None);
            }
            let query = collection.compute_membership_query(&self.stage)?;
            // UsdLuxLightAPI overrides the default of includeRoot.
            let own = self.stage.prim(collection.prim().clone()).property_names()?;
            let root = format!("collection:{}:includeRoot", collection.name());
            if LINKS.contains(&collection.name()) && own.iter().all(|name| name.as_str() != root) {
                let mut rules = query.rule_map().clone();
                rules.entry(sdf::Path::abs_root()).or_insert(match collection.expansion_rule(&self.stage)? {
                    usd::ExpansionRule::ExplicitOnly => usd::PathRule::ExplicitOnly,
                    _ => usd::PathRule::ExpandPrims,
                });
                return Ok(Some(usd::MembershipQuery::new(rules)));
            }
            Ok(Some(query))
        })?;
        self.members.borrow_mut().insert(collection.to_owned(), members);
        self.includes(collection, prim)
    }

    fn check_chain(&self, collection: &usd::Collection) -> Result<(), Failure> {
        let mut known = HashSet::new();
        let mut rest = vec![collection.clone()];
        while let Some(next) = rest.pop() {
            if known.insert(next.collection_path()?) {
                let included = next.includes(&self.stage)?;
                let chained = included.iter().filter_map(usd::is_collection_api_path);
                rest.extend(chained.map(|(owner, name)| usd::Collection::new(owner, name)));
            }
            if known.len() > MOST_COLLECTIONS {
                return Err(Failure(format!("more than {MOST_COLLECTIONS} collections are inside each other")));
            }
        }
        Ok(())
    }
}
