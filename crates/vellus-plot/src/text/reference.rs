//! Energies of light in the whole fibre, beside those of the model.

use super::{Format, align, header, number};
use serde_json::{Map, json};
use vellus::{Lobe, ScatterExit};
use vellus_reference::simulate::energies::{Energies, Fate};

/// A simulation of the whole fibre, and the model.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Inclination of ω_o, degrees.
    pub theta_o: f64,
    /// The offset of the hit. `None` is the average over the whole width.
    pub h: Option<f64>,
    /// Number of photons.
    pub photons: u64,
    /// Seed of the simulation.
    pub seed: u64,
    /// How scattered light leaves the model's fibre.
    pub exit: ScatterExit,
    /// Energies of the simulation.
    pub simulated: Energies,
    /// Energies of the model's lobes, see [`vellus_models::energies`].
    pub model: [[f64; 3]; 6],
}

/// Key, mean, standard error, and the energy of the model.
type Line = (&'static str, [f64; 3], [f64; 3], Option<[f64; 3]>);

impl Reference {
    fn lines(&self) -> Vec<Line> {
        let model =
            |lobes: &[Lobe]| Some([0, 1, 2].map(|c| lobes.iter().map(|&l| self.model[l as usize][c]).sum::<f64>()));
        // `rest` contains higher orders of both kinds. It counts as unscattered, unless the cuticle reflects scattered
        // light: it then consists mostly of that light.
        let model_of = |fate: Fate| match fate {
            Fate::R => model(&[Lobe::R]),
            Fate::Tt => model(&[Lobe::Tt]),
            Fate::Trt => model(&[Lobe::Trt]),
            Fate::Higher if self.exit == ScatterExit::Open => model(&[Lobe::Rest]),
            Fate::Scattered if self.exit == ScatterExit::Open => model(&[Lobe::Tts, Lobe::Trts]),
            Fate::Scattered => model(&[Lobe::Tts, Lobe::Trts, Lobe::Rest]),
            Fate::Higher => None,
            Fate::Guided => None,
        };
        let simulated = &self.simulated;
        let line = |&f: &Fate| (f.key(), simulated.mean[f as usize], simulated.error[f as usize], model_of(f));
        let mut lines: Vec<Line> = Fate::ALL.iter().map(line).collect();
        lines.push(("total", simulated.total[0], simulated.total[1], model(&Lobe::ALL)));
        lines
    }
}

/// Energies of the simulation, their standard errors, and energies of the model.
pub fn reference(reference: &Reference, format: Format) -> String {
    let lines = reference.lines();
    let &Reference { theta_o, h, photons, seed, .. } = reference;
    match format {
        Format::Table => format!("energy of light from θ_o {theta_o}°, {photons} photons\n{}", table(&lines)),
        Format::Csv => {
            let mut text = "fate,mean.r,mean.g,mean.b,error.r,error.g,error.b\n".to_owned();
            for (key, mean, error, _) in &lines {
                let values: Vec<String> = mean.iter().chain(error).map(f64::to_string).collect();
                text += &format!("{key},{}\n", values.join(","));
            }
            text
        }
        Format::Json | Format::Jsonl => {
            let fate = |(key, mean, error, model): &Line| {
                ((*key).to_owned(), json!({"mean": mean, "standard_error": error, "model": model}))
            };
            let fates: Map<_, _> = lines.iter().map(fate).collect();
            let h = h.map_or(json!("whole width"), |h| json!(h));
            format!("{}\n", json!({"theta_o": theta_o, "h": h, "photons": photons, "seed": seed, "energies": fates}))
        }
    }
}

fn table(lines: &[Line]) -> String {
    let mut rows = vec![header(["", "reference", "± 1 s.e.", "model", "model/reference"])];
    // Three rows for each line, if the channels differ.
    let grey = lines.iter().all(|(_, mean, _, _)| mean[0] == mean[1] && mean[1] == mean[2]);
    for (key, mean, error, model) in lines {
        for c in 0..if grey { 1 } else { 3 } {
            let name = if grey { (*key).to_owned() } else { format!("{key} {}", ["red", "green", "blue"][c]) };
            let ratio = model.filter(|_| mean[c] > 0.0).map(|m| format!("{:.4}", m[c] / mean[c]));
            let model = model.map(|m| number(m[c]));
            rows.push(vec![
                name,
                number(mean[c]),
                number(error[c]),
                model.unwrap_or_default(),
                ratio.unwrap_or_default(),
            ]);
        }
    }
    align(&rows)
}
