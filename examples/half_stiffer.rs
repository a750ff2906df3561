//! A block that sags less once the lower half of its springs is made ten times stiffer while it
//! runs.

use msd::core::glam::DVec3;
use msd::core::{
    Error, Friction, Interaction, Material, Plane, Scene, Select, Settings, Simulation, shape,
};

fn main() -> Result<(), Error> {
    let material = Material { mass: 0.1, stiffness: 150.0, damping: 2.0 };
    let mut scene = Scene::of("block", shape::block([6, 6, 6], 0.1, material)?);
    let friction = Friction::Coulomb(0.5);
    scene.planes.push(Plane { normal: DVec3::Y, offset: -0.25, restitution: 0.0, friction });
    let mut block =
        Simulation::<f32>::new(&scene, Settings { substeps: 24, ..Settings::default() })?;
    let top = 5 * 36 + 14;
    let half = Select::Range(0, scene.springs.len() / 2);
    for (what, change) in [
        ("as it is", None),
        (
            "half of its springs stiffer",
            Some(Interaction::SetStiffness { springs: half, value: 1500.0 }),
        ),
    ] {
        if let Some(change) = change {
            block.queue(change)?;
        }
        for _ in 0..240 {
            block.step()?;
        }
        let (height, stable) = (block.position(top).y + 0.25, block.stable_substep());
        println!("{what}: {height:.3} m high, stable up to {stable:.1e} s");
    }
    Ok(())
}
