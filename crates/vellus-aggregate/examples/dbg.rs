//! scratch
use vellus::{Bcsdf, Fiber, Model, Species, Window, direction};
use vellus_aggregate::simulation::*;
use vellus_aggregate::{Aggregate, Bunch};
fn main() {
    let fiber = Fiber::preset(Species::Dog);
    let agg = Aggregate::new(&fiber, Bunch::new(0.1).unwrap()).unwrap();
    let b = Bcsdf::new(&fiber).unwrap();
    let wo = direction(0.78, 0.0);
    let p = Profile::of(&agg.at(wo, Window::far()));
    let q = Profile::of(&b.at(wo, Window::far()));
    let sim = Fibers { fiber, places: Places::Medium(0.1), collision: Collision::Far, spread: 0.0 };
    let s = sim.scatter(0.78, 5, 400_000).unwrap();
    for k in 0..36 { println!("{:3} {:.5} {:.5} {:.5}", k*5-90, p.inclination[k][0], q.inclination[k][0], s.profile.inclination[k][0]); }
    for phi in [0.0,0.5,1.0,2.0,3.14] { let h=b.at(wo, Window::far()); println!("{:?}", (-8..9).map(|t| { let f=h.eval(direction(t as f64*0.19, phi)).0; f[3][0]+f[4][0]}).collect::<Vec<_>>()); }
}
