use vellus_medulla::check::*; use vellus::*;
fn main(){ let a:Vec<String>=std::env::args().collect(); let d=TableData::from_bytes(&std::fs::read(&a[1]).unwrap()).unwrap(); let n:u64=a[2].parse().unwrap(); let ph:u64=a[3].parse().unwrap();
 let mut all=vec![]; for i in 0..n { all.push(check_azimuthal(&d,ph,7,i)); all.extend(check_longitudinal(&d,ph,7,i)); }
 for k in TableKind::ALL { let v:Vec<_>=all.iter().filter(|p|p.kind==k).collect(); println!("{} L1 {:?} noise {:?}",k.name(),summary(v.iter().map(|p|p.l1).collect()),summary(v.iter().map(|p|p.noise).collect())); 
  let den:Vec<f64>=v.iter().map(|p|(p.l1*p.l1-p.noise*p.noise).max(0.0).sqrt()).collect(); println!("   minus noise {:?}",summary(den));
  let mut w=v.clone(); w.sort_by(|a,b|b.l1.total_cmp(&a.l1)); for p in w.iter().take(4) { println!("   worst {:?}",p); } }
 println!("path {:?}",summary(all.iter().filter_map(|p|p.mean_path.map(f64::abs)).collect())); }
