//! Draws what 64 real fibres scatter beside their aggregate:
//! `cargo run --release -p vellus-aggregate --features simulation --example figure -- FILE.png [PATHS]`.

use plotters::coord::Shift;
use plotters::prelude::*;
use vellus::{Fiber, Lobe, Lobes, Model, Sample, Scattering, Species, Window, direction, glam::Vec3};
use vellus_aggregate::simulation::{CELLS, Collision, Fibers, Places, Profile};
use vellus_aggregate::{Aggregate, AggregateHit, Bunch};
use vellus_plot::canvas::{LOBE_COLORS, Mark, font, legend, titled};
use vellus_plot::{Draw, save};

const COUNT: u32 = 64;
/// The share of the section that the fibres fill.
const FILL: f64 = 0.06;
const THETA_O: f64 = 30.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let file = arguments.next().ok_or("expected the name of the picture")?;
    let paths = arguments.next().map_or(Ok(2_000_000), |text| text.to_string_lossy().parse())?;
    let fibers = [
        ("dog (light, with medulla)", Fiber::preset(Species::Dog)),
        ("dark hair (without medulla)", Fiber::hair().with_absorption([0.5, 0.8, 1.2])),
    ];
    let panels = fibers.map(|(name, fiber)| Panel::new(name, fiber, paths)).into_iter().collect::<Result<_, _>>()?;
    save(&Picture(panels), &[file.into()])?;
    Ok(())
}

/// Profiles of one fibre.
struct Panel {
    name: &'static str,
    bunch: Profile,
    aggregate: Profile,
    single: Profile,
}

/// The single scattering of an aggregate.
struct Single<'a>(AggregateHit<'a>);

impl Scattering for Single<'_> {
    fn energy(&self) -> Lobes {
        self.0.energy()
    }

    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        let (mut lobes, pdf) = self.0.eval_pdf(wi);
        lobes[Lobe::Rest] = [0.0; 3];
        (lobes, pdf)
    }

    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        self.0.sample(u)
    }
}

impl Panel {
    fn new(name: &'static str, fiber: Fiber, paths: u64) -> Result<Self, vellus_aggregate::Error> {
        let theta = THETA_O.to_radians();
        let places = Places::Separate(COUNT, FILL);
        let fibers = Fibers { fiber, places, collision: Collision::Near, spread: 0.0 };
        let bunch = Bunch::separate(COUNT, (FILL / f64::from(COUNT)).sqrt(), 1.0)?;
        let aggregate = Aggregate::new(&fiber, bunch)?;
        let hit = aggregate.at(direction(theta, 0.0), Window::far());
        Ok(Panel {
            name,
            bunch: fibers.scatter(theta, 1, paths)?.profile,
            aggregate: Profile::of(&hit),
            single: Profile::of(&Single(hit)),
        })
    }
}

struct Picture(Vec<Panel>);

/// The green channel of all cells, per radian.
fn points(cells: &[[f64; 3]; CELLS], first: f64) -> Vec<(f64, f64)> {
    let width = 180.0 / CELLS as f64;
    cells.iter().enumerate().map(|(k, rgb)| (first + (k as f64 + 0.5) * width, rgb[1] / width.to_radians())).collect()
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (1200, 900)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> vellus_plot::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let [bunch, aggregate, single] = [4, 0, 2].map(|k| LOBE_COLORS[k]);
        let title = format!("{COUNT} fibres that fill {:.0} % of the section, θ_o = {THETA_O}°", 100.0 * FILL);
        let area = titled(area, &title, 24.0)?;
        let entries = [
            ("fibres, photon by photon".to_owned(), Mark::Circle(bunch.filled())),
            ("aggregate".to_owned(), Mark::Line(aggregate.stroke_width(4))),
            ("its single scattering".to_owned(), Mark::Line(single.stroke_width(2))),
        ];
        let area = legend(&area, &entries)?;
        let cells = area.split_evenly((self.0.len(), 2));
        for (panel, row) in self.0.iter().zip(cells.chunks(2)) {
            let profiles = [&panel.bunch, &panel.aggregate, &panel.single];
            let sides = [
                ("|φ|, degrees from ω_o", 0.0, profiles.map(|profile| &profile.azimuth)),
                ("θ_i, degrees", -90.0, profiles.map(|profile| &profile.inclination)),
            ];
            for (cell, (label, first, profiles)) in row.iter().zip(sides) {
                let curves = profiles.map(|cells| points(cells, first));
                let top = curves.iter().flatten().map(|p| p.1).fold(0.0, f64::max);
                let mut chart = ChartBuilder::on(cell);
                chart.margin(12).x_label_area_size(50).y_label_area_size(70);
                chart.caption(panel.name, font(19.0));
                let mut chart = chart.build_cartesian_2d(first..first + 180.0, 0.0..1.08 * top)?;
                chart
                    .configure_mesh()
                    .x_desc(label)
                    .y_desc("light per radian")
                    .x_label_formatter(&|x| format!("{x:.0}"))
                    .label_style(font(15.0))
                    .axis_desc_style(font(17.0))
                    .light_line_style(TRANSPARENT)
                    .bold_line_style(BLACK.mix(0.15))
                    .draw()?;
                let [photons, all, once] = curves;
                chart.draw_series(LineSeries::new(once, single.stroke_width(2)))?;
                chart.draw_series(LineSeries::new(all, aggregate.stroke_width(3)))?;
                chart.draw_series(photons.into_iter().map(|p| Circle::new(p, 4, bunch.filled())))?;
            }
        }
        Ok(())
    }
}
