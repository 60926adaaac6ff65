//! What `vellus` does without a subcommand: the model's answer for a red fox, and a picture of it.

use crate::eval::table;
use crate::fiber_args::FiberArgs;
use crate::plot;
use crate::query::Query;
use anyhow::Result;
use vellus::Bcsdf;

/// Runs it.
pub fn run() -> Result<()> {
    let args = FiberArgs { fiber: "red-fox".to_owned(), set: vec!["sigma_ca=0.2,0.4,0.8".to_owned()] };
    let fiber = args.load()?;
    let (theta_o, h) = (20.0, 0.3);
    let query = Query::new([theta_o, h, -15.0, 150.0])?;
    println!("A red fox's fur fibre, tinted (vellus eval --fiber red-fox --set sigma_ca=0.2,0.4,0.8)\n");
    println!("{}", table(&query, &query.ask(&Bcsdf::new(&fiber)?)));
    for path in plot::lobes(&args, theta_o, h, &[])? {
        println!("wrote {}", path.display());
    }
    println!(
        "\nNext: vellus fiber list · vellus plot profile --fiber all · vellus energy --fiber cat --theta-o 30 --window far · \
         vellus --help"
    );
    Ok(())
}
