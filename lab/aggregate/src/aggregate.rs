//! The scattering of a bunch: an implementation of the trait of all models.

use crate::bunch::Bunch;
use crate::chain::Collision;
use crate::error::Error;
use crate::grid::{Grid, position};
use crate::hit::AggregateHit;
use crate::member::{INCLINATIONS, Member, Roughness};
use crate::node::{Node, Source};
use crate::once::leaves_after_one;
use crate::orders::Orders;
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use vellus::{Bcsdf, Fiber, Model, Window, WindowSupport};

/// One thick fibre that stands for a bunch of fibres.
///
/// It describes light that collides at least once. A hit test lets the other light pass: [`Bunch::passes`]. So without
/// absorption its energy is 1. It is a far field: an average over the width of the bunch, with offsets in proportion to
/// the probability to collide. [The crate](crate) has its errors.
///
/// [`Aggregate::new`] takes about 13 ms and 600 KB. Make one for each look, not for each hit.
#[derive(Clone, Debug)]
pub struct Aggregate {
    member: Fiber,
    bunch: Bunch,
    orders: &'static Orders,
    nodes: Vec<Node>,
    pub(crate) grid: Grid,
}

impl Aggregate {
    /// The aggregate of a bunch with members like `member`.
    ///
    /// # Errors
    /// [`Error::Fiber`] if a parameter of the member is out of range.
    pub fn new(member: &Fiber, bunch: Bunch) -> Result<Self, Error> {
        Ok(Self::with_orders(member, bunch, Orders::shipped()?)?)
    }

    fn with_orders(member: &Fiber, bunch: Bunch, orders: &'static Orders) -> Result<Self, vellus::Error> {
        let members = Member::all(&Bcsdf::new(member)?);
        let roughness = Roughness { beta_m: f64::from(member.beta_m), spread: bunch.spread() };
        let grid = Grid::new();
        let source = Source {
            fiber: member,
            collision: &Collision::new(&members, roughness),
            members: &members,
            once: &leaves_after_one(bunch.tau(), bunch.carried()),
            orders,
            tau: bunch.tau_inside(),
            roughness,
            grid: &grid,
        };
        let nodes = (0..INCLINATIONS).map(|k| Node::new(&source, k)).collect();
        Ok(Aggregate { member: *member, bunch, orders, nodes, grid })
    }

    /// The member fibre.
    pub fn member(&self) -> &Fiber {
        &self.member
    }

    /// The bunch.
    pub fn bunch(&self) -> Bunch {
        self.bunch
    }

    /// The tables before and after the inclination of ω_o, and their shares.
    #[inline]
    pub(crate) fn nodes(&self, sin_o: f32, cos_o: f32) -> [(&Node, f32); 2] {
        let (k, share) = position(sin_o.abs().atan2(cos_o), FRAC_PI_2, INCLINATIONS);
        [(&self.nodes[k], 1.0 - share), (&self.nodes[k + 1], share)]
    }
}

impl Model for Aggregate {
    type Hit<'a> = AggregateHit<'a>;

    /// The window is ignored.
    #[inline]
    fn at(&self, wo: Vec3, _: Window) -> AggregateHit<'_> {
        AggregateHit::new(self, wo)
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Far
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, vellus::Error> {
        Self::with_orders(fiber, self.bunch, self.orders)
    }
}
