//! Members of collections (UsdCollectionAPI).

use super::expression::{self, Context, Expression};
use super::{Failure, Stage};
use crate::error::Error;
use crate::read::link::LINKS;
use openusd::{sdf, usd};
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

/// The largest number of nested collections. `openusd` is recursive over them.
const MOST_COLLECTIONS: usize = 200;

/// Members of collections, by path.
pub(super) type Members = RefCell<HashMap<String, Member>>;

/// The prims of a collection.
pub(super) enum Member {
    Query(usd::MembershipQuery),
    Expression(Expression),
    /// The collection cannot be read.
    Unknown(String),
}

impl Stage {
    /// Whether a prim is in the collection with this path (`/prim.collection:name`).
    pub fn includes(&self, collection: &str, prim: &str) -> Result<bool, Error> {
        if !self.members.borrow().contains_key(collection) {
            let member = match self.ask(collection, |collection| self.member(collection)) {
                Err(Error::Prim { what, .. }) => Member::Unknown(what),
                member => member?,
            };
            self.members.borrow_mut().insert(collection.to_owned(), member);
        }
        let prim = self.instances.borrow().composed_with(collection, prim);
        Ok(match &self.members.borrow()[collection] {
            Member::Query(query) => query.is_path_included(&sdf::Path::from(prim.as_str())),
            Member::Expression(expression) => expression.has(&prim),
            Member::Unknown(what) => return Err(Error::prim(collection, what)),
        })
    }

    fn member(&self, collection: &str) -> Result<Member, Failure> {
        let Some((owner, name)) = usd::is_collection_api_path(&sdf::Path::from(collection)) else {
            return Ok(Member::Query(usd::MembershipQuery::default()));
        };
        let collection = usd::Collection::new(owner, name);
        self.check_chain(&collection)?;
        // UsdLuxLightAPI overrides the default of includeRoot.
        let own = self.stage.prim(collection.prim().clone()).property_names()?;
        let root = format!("collection:{}:includeRoot", collection.name());
        let has_all = LINKS.contains(&collection.name()) && own.iter().all(|name| name.as_str() != root);
        if !has_all && collection.has_expression(&self.stage)? {
            return Ok(Member::Expression(self.expression(&collection, 0)?));
        }
        let query = collection.compute_membership_query(&self.stage)?;
        if !has_all {
            return Ok(Member::Query(query));
        }
        let mut rules = query.rule_map().clone();
        rules.entry(sdf::Path::abs_root()).or_insert(match collection.expansion_rule(&self.stage)? {
            usd::ExpansionRule::ExplicitOnly => usd::PathRule::ExplicitOnly,
            _ => usd::PathRule::ExpandPrims,
        });
        Ok(Member::Query(usd::MembershipQuery::new(rules)))
    }

    /// The expression of a collection. Nothing if it has none.
    fn expression(&self, collection: &usd::Collection, depth: usize) -> Result<Expression, Failure> {
        let Some(text) = collection.membership_expression(&self.stage)? else { return Ok(Expression::NOTHING) };
        let name = format!("collection:{}:membershipExpression", collection.name());
        let anchor = collection.prim().as_str();
        let stack = self.stage.prim(collection.prim().clone()).attribute(name.as_str()).property_stack()?;
        let source = stack.first().map_or(anchor.to_owned(), |(_, path)| path.prim_path().as_str().to_owned());
        let mut layer = Layer { stage: self, anchor, source: &source };
        let what = |error| Failure(format!("{name} cannot be read: {error}"));
        expression::parse(&text, &mut layer, depth).map_err(what)
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

/// The layer of an expression.
struct Layer<'a> {
    stage: &'a Stage,
    anchor: &'a str,
    /// The path of the prim in its layer, where references and the like can move it.
    source: &'a str,
}

impl Context for Layer<'_> {
    fn collection(&mut self, prim: &str, name: &str, depth: usize) -> Result<Expression, String> {
        let prim = match prim {
            "" => Some(self.anchor.to_owned()),
            absolute if absolute.starts_with('/') => self.mapped(absolute),
            relative => Some(format!("{}/{relative}", self.anchor)),
        };
        let Some(prim) = prim else { return Ok(Expression::NOTHING) };
        let collection = usd::Collection::new(sdf::Path::from(prim.as_str()), name);
        self.stage.expression(&collection, depth).map_err(|failure| failure.0)
    }

    fn mapped(&self, path: &str) -> Option<String> {
        // The names at the end that are the same in the layer and on the stage were not moved.
        let (mut from, mut to) = (self.source, self.anchor);
        while let (Some((a, name)), Some((b, same))) = (from.rsplit_once('/'), to.rsplit_once('/'))
            && name == same
            && !name.is_empty()
        {
            (from, to) = (a, b);
        }
        let from = from.trim_end_matches('/');
        let rest = path.strip_prefix(from).filter(|rest| rest.is_empty() || rest.starts_with('/'))?;
        let mapped = format!("{}{}", to.trim_end_matches('/'), rest.trim_end_matches('/'));
        Some(if mapped.is_empty() { "/".to_owned() } else { mapped })
    }

    fn anchor(&self) -> &str {
        self.anchor
    }
}
