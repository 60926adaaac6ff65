use vellus_medulla::reference::*; use vellus::*;
fn main(){ for s in Species::ALL { let f=Fiber::preset(s); for t in [0.0f64,60.0] { let st=std::time::Instant::now(); let e=energies(&f,t.to_radians(),Offsets::Whole,200_000,1,&|_|()).unwrap(); 
 let b=Bcsdf::new(&f).unwrap(); let wo=glam::Vec3::new(t.to_radians().sin() as f32,t.to_radians().cos() as f32,0.); let n=20000; let mut m=[0.0f64;6]; for i in 0..n { let h=2.0*(i as f32+0.5)/n as f32-1.0; let a=b.at(wo,Window::near(h)).energy(); for p in 0..6 { m[p]+=a.0[p][0] as f64/n as f64; } }
 println!("{s} {t}: {:?} total {:.4} | model {:?} total {:.4} {:?}",e.mean.map(|x|(x[0]*1e4).round()/1e4),e.total[0][0],m.map(|x|(x*1e4).round()/1e4),m.iter().sum::<f64>(),st.elapsed()); } } }
