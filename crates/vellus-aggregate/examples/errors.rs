//! scratch
use vellus::{Fiber, Model, Species, Window, direction};
use vellus_aggregate::simulation::*;
use vellus_aggregate::{Aggregate, Bunch};
fn main() {
    let paths: u64 = std::env::args().nth(1).map_or(200_000, |x| x.parse().unwrap());
    let fibers = [
        ("dog", Fiber::preset(Species::Dog)),
        ("raccoon", Fiber::preset(Species::Raccoon)),
        ("cat white", Fiber::preset(Species::Cat).without_absorption()),
        ("fox", Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8])),
        ("deer", Fiber::preset(Species::Deer)),
        ("human", Fiber::preset(Species::Human)),
        ("hair light", Fiber::hair().with_absorption([0.02, 0.05, 0.1])),
        ("hair dark", Fiber::hair().with_absorption([0.5, 0.8, 1.2])),
    ];
    for (name, fiber) in fibers {
        for tau in [0.1, 1.0, 4.0, 12.0] {
            for theta in [0.0f64, 45.0, 75.0] {
                let t = std::time::Instant::now();
                let agg = Aggregate::new(&fiber, Bunch::new(tau).unwrap()).unwrap();
                let built = t.elapsed();
                let hit = agg.at(direction(theta.to_radians(), 0.0), Window::far());
                let p = Profile::of(&hit);
                let sim = Fibers { fiber, places: Places::Medium(tau), collision: Collision::Far, spread: 0.0 };
                let s = sim.scatter(theta.to_radians(), 5, paths).unwrap();
                let [a, l] = p.difference(&s.profile);
                let e = [p.energy(), s.profile.energy()];
                println!("{name:10} τ {tau:4} θ {theta:2} az {:.1}% along {:.1}%  E {:.4?} {:.4?} coll {:.2} passes {:.4} {:.4} {built:.1?}", 100.0*a, 100.0*l, e[0], e[1], s.collisions, s.passes, agg.bunch().mean_passes());
            }
        }
    }
}
