fn main() {
    let p = std::env::args().nth(1).unwrap_or_default();
    let t = std::time::Instant::now();
    println!("{} {:?}", vellus_usd::read(p.as_ref(), &vellus_usd::Options::default()).is_ok(), t.elapsed());
}
