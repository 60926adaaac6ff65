use vellus_medulla::build::*;
use std::io::Write;
fn main(){ let a:Vec<String>=std::env::args().collect(); let mut q= if a[1]=="smoke" {Quality::smoke()} else {Quality::shipping()}; if let Some(p)=a.get(3){q.photons=p.parse().unwrap();}
 let t=std::time::Instant::now();
 let slabs:Vec<_>=q.slabs().into_iter().map(|s|{ let f=format!("/tmp/slabs/{}-{:?}-{}.bin",q.photons,s.kind,s.tau); if let Ok(b)=std::fs::read(&f){ return b.chunks(4).map(|c|f32::from_le_bytes(c.try_into().unwrap())).collect::<Vec<_>>();} let v=q.simulate(s); eprintln!("{s:?} {:?}",t.elapsed()); if a[1]!="smoke" { std::fs::File::create(&f).unwrap().write_all(&v.iter().flat_map(|x|x.to_le_bytes()).collect::<Vec<_>>()).unwrap(); } v}).collect();
 eprintln!("sim {:?}",t.elapsed());
 let d=q.assemble(&slabs,&||{}); eprintln!("compress {:?}",t.elapsed());
 let b=d.to_bytes().unwrap(); eprintln!("{} bytes",b.len()); std::fs::write(&a[2],b).unwrap(); }
