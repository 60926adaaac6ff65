//! Times the writing and reading of a million strands: `speed write FILE`, `speed read FILE`. Prints seconds.

use std::time::Instant;
use vellus_alembic::{
    Archive, Attribute, CurveBasis, CurveType, Curves, Geometry, Pod, Scope, Values, Writer, attributes,
};

const STRANDS: usize = 1_000_000;
const POINTS: usize = 8;

fn attribute(name: &str, scope: Scope, lanes: usize, count: usize) -> Attribute {
    let (name, values) = (name.to_owned(), Values::Single(vec![0.01; count]));
    Attribute { name, scope, lanes, pod: Pod::F32, interpretation: String::new(), values, indices: None }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, mode, file] = &arguments[..] else { return Err("speed write|read FILE".into()) };
    if mode == "write" {
        let curves = Curves {
            kind: CurveType::Linear,
            periodic: false,
            basis: CurveBasis::None,
            counts: vec![POINTS as u32; STRANDS],
            positions: (0..STRANDS * POINTS).map(|i| [i as f32, 0.5, 0.25]).collect(),
            weights: None,
            velocities: None,
            orders: Vec::new(),
            knots: Vec::new(),
            widths: Some(attribute("width", Scope::Vertex, 1, STRANDS * POINTS)),
            uv: None,
            normals: None,
        };
        let uv = attribute("groom_root_uv", Scope::Uniform, 2, 2 * STRANDS);
        let start = Instant::now();
        let mut writer = Writer::new(std::io::BufWriter::new(std::fs::File::create(file)?))?;
        let mut hair = Geometry::curves(&mut writer, Writer::<std::fs::File>::ROOT, "hair", 0)?;
        hair.add_curves(&mut writer, &curves, &[uv])?;
        writer.finish(&[])?;
        println!("{:.3}", start.elapsed().as_secs_f64());
    } else {
        let start = Instant::now();
        let archive = Archive::open_file(std::fs::File::open(file)?)?;
        let object = &archive.objects[1];
        let curves = Curves::read(&archive, object, 0.0)?;
        let rows: usize =
            attributes(object).iter().map(|p| Attribute::read(&archive, p, 0.0).map_or(0, |a| a.rows())).sum();
        assert_eq!((curves.positions.len(), rows), (STRANDS * POINTS, STRANDS));
        println!("{:.3}", start.elapsed().as_secs_f64());
    }
    Ok(())
}
