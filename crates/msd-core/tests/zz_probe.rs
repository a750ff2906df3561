use msd_core::glam::{DMat3, DVec3};
use msd_core::*;
const G: f64 = 9.82;
fn frame() -> (DVec3, DVec3) { let n = DVec3::new(0.3,0.8,-0.5).normalize(); let o = DVec3::new(0.9,0.1,0.2); (n, (o - n*o.dot(n)).normalize()) }
fn standing(size:[usize;3], degrees:f64, k:f64, c:f64)->Scene{
    let (n,d)=frame();
    let m=Material{mass:0.1,stiffness:k,damping:c};
    let mut part=shape::block(size,0.5,m).unwrap();
    let low=part.particles.iter().map(|p|p.position.y).fold(f64::MAX,f64::min);
    part.place(DMat3::IDENTITY,DVec3::Y*-low);
    part.place(DMat3::from_cols(d,n,d.cross(n)),DVec3::ZERO);
    let mut s=Scene::of("b",part);
    let (si,co)=degrees.to_radians().sin_cos();
    s.world.gravity=(d*si-n*co)*G;
    s.planes=vec![Plane{normal:n,offset:0.0,restitution:0.5,friction:Friction::Coulomb(0.5)}];
    s
}
fn series<R:Real>(name:&str,s:&Scene,i:Integrator,tol:f64){
    let mut sim=Simulation::<R>::new(s,Settings{integrator:i,tolerance:tol,..Settings::default()}).unwrap();
    let mut last=sim.state();
    print!("{name} {i} {}: ",R::NAME);
    let mut t=0.0;
    for until in [5.,10.,20.,40.,80.,160.,320.,600.]{
        while t<until { sim.step().unwrap(); t+=1.0/60.0; }
        let now=sim.state();
        let d=now.positions.iter().zip(&last.positions).map(|(a,b)|(a.to_f64()-b.to_f64()).length()).fold(0.0,f64::max);
        let e=sim.energy();
        print!("{until}:{d:.1e}(K{:.0e},tot{:.6},c{:.2e}/{:.2e}) ",e.kinetic,e.total(),sim.contacts().taken,sim.contacts().added);
        last=now;
    }
    println!();
}
#[test] fn probe(){
    let which=std::env::var("P").unwrap_or_default();
    use Integrator::*;
    if which.contains('c'){ for (k,c) in [(400.,1.),(800.,2.5),(3000.,2.5)] { series::<f64>(&format!("col{k}"),&standing([8,3,3],4.0,k,c),SymplecticEuler,1e-6); } }
    if which.contains('b'){ for i in [ExplicitEuler,SymplecticEuler,VelocityVerlet,Rk4,Xpbd]{ series::<f32>("block24",&standing([3,3,3],24.0,400.,1.),i,1e-6); series::<f64>("block24",&standing([3,3,3],24.0,400.,1.),i,1e-6);} }
    if which.contains('l'){ for i in [ExplicitEuler,VelocityVerlet,Xpbd]{ series::<f32>("level",&standing([3,3,3],0.0,400.,1.),i,1e-6);} }
    if which.contains('d'){ for tol in [1e-4,1e-6,1e-9]{ series::<f64>(&format!("dp {tol:e}"),&standing([3,3,3],26.0,400.,1.),DormandPrince,tol); series::<f64>(&format!("dp {tol:e}"),&standing([3,3,3],24.0,400.,1.),DormandPrince,tol);} }
}
#[test] fn dpfind(){
    if !std::env::var("P").unwrap_or_default().contains('f') { return }
    for spacing in [0.1,0.25,1.0] { for k in [100.0,1000.0,10000.] { for c in [0.5,5.,50.0] { for m in [0.1,1.0] {
    let mat=Material{mass:m,stiffness:k,damping:c};
    let mut part=shape::block([3,3,3],spacing,mat).unwrap();
    let low=part.particles.iter().map(|p|p.position.y).fold(f64::MAX,f64::min);
    part.place(DMat3::IDENTITY,DVec3::Y*-low);
    let mut s=Scene::of("b",part);
    let (si,co)=26f64.to_radians().sin_cos();
    s.world.gravity=DVec3::new(si,-co,0.0)*G;
    s.planes=vec![Plane{normal:DVec3::Y,offset:0.0,restitution:0.5,friction:Friction::Coulomb(0.5)}];
    print!("spacing {spacing} k {k} c {c} m {m}:");
    for e in [0.5, 0.0] { for tol in [1e-4,1e-6] { s.planes[0].restitution=e;
        let t0=std::time::Instant::now();
        let mut sim=Simulation::<f64>::new(&s,Settings{integrator:Integrator::DormandPrince,tolerance:tol,..Settings::default()}).unwrap();
        let mut ok=true;
        for _ in 0..600 { if sim.step().is_err() || t0.elapsed().as_secs_f64()>3. {ok=false;break;} }
        let a=sim.centre_of_mass(0..27);
        for _ in 0..300 { if !ok||sim.step().is_err() || t0.elapsed().as_secs_f64()>4. {ok=false;break;} }
        let b=sim.centre_of_mass(0..27);
        print!(" e{e} tol{tol:e}: {:.2e} m/s {}", (b-a).length()/5.0, if ok {""} else {"!"});
    } }
    println!();
    }}}}
}
#[test] fn jelly(){
    if !std::env::var("P").unwrap_or_default().contains('j') { return }
    let mat=Material{mass:1.0,stiffness:2200.,damping:0.1};
    let mut part=shape::block([10,10,10],1.0,mat).unwrap();
    part.set_motion(DVec3::new(1.,2.,0.),DVec3::new(0.,1.,2.).normalize()*-7.0);
    part.place(DMat3::IDENTITY,DVec3::Y*5.0);
    let mut s=Scene::of("jelly",part);
    s.world.gravity=DVec3::Y*-9.82;
    s.planes=vec![Plane{normal:DVec3::Y,offset:-5.0,restitution:1.0,friction:Friction::TangentialLoss(0.3)},Plane{normal:DVec3::Z,offset:-125.,restitution:1.0,friction:Friction::TangentialLoss(0.3)}];
    for (i,sub) in [(Integrator::VelocityVerlet,8),(Integrator::VelocityVerlet,16),(Integrator::VelocityVerlet,64),(Integrator::SymplecticEuler,8),(Integrator::Rk4,8),(Integrator::Xpbd,8),(Integrator::BackwardEuler,8),(Integrator::DormandPrince,8)]{
    let t0=std::time::Instant::now();
    let mut sim=Simulation::<f32>::new(&s,Settings{integrator:i,substeps:sub,..Settings::default()}).unwrap();
    print!("jelly {i} {sub}: E0 {:.1} ", sim.energy().total());
    for n in 1..=3600 { sim.step().unwrap(); if n%600==0 || n==60 || n==180 { let e=sim.energy(); let c=sim.contacts(); print!("[{}s K{:.2} el{:.1} g{:.1} diss{:.0} tot{:.1} c{:.0}/{:.0} n{}] ",n/60,e.kinetic,e.elastic,e.gravitational,e.dissipated,e.total(),c.taken,c.added,c.count); } if t0.elapsed().as_secs_f64()>120.{break;} }
    println!();
    }
}
