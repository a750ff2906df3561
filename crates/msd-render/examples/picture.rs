//! You will see `picture.png`: a square sheet over a floor, with its springs coloured by strain.

use msd_core::glam::DVec3;
use msd_core::{
    Corner, Friction, Part, Particle, Plane, Scene, Settings, Simulation, Spring, Surface,
};
use msd_render::{Gpu, Quantity, Style, View, bounds, render_image};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene();
    let simulation = Simulation::<f32>::new(&scene, Settings::default())?;
    let snapshot = simulation.snapshot();
    let style = Style { colour_by: Some(Quantity::Strain), line_width: 4.0, ..Style::default() };
    let mut view = View { style, ..View::default() };
    if let Some(bounds) = bounds(&snapshot) {
        view.camera.frame(bounds, 4.0 / 3.0);
        view.camera.zoom(1.6);
    }
    let gpu = pollster::block_on(Gpu::headless())?;
    let picture = render_image(&gpu, &snapshot, &view, 800, 600)?;
    let (width, height) = (picture.width, picture.height);
    image::save_buffer("picture.png", &picture.rgba, width, height, image::ColorType::Rgba8)?;
    Ok(())
}

fn scene() -> Scene {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let particle = |[x, z]: [f64; 2]| Particle {
        position: DVec3::new(x, 0.3 * x * z, z),
        velocity: DVec3::ZERO,
        mass: 1.0,
    };
    let spring = |ends| Spring { ends, rest_length: 1.0, stiffness: 100.0, damping: 1.0 };
    let corner = |(particle, uv): (usize, [f64; 2])| Corner {
        particle: particle as u32,
        uv: uv.map(|part| part as f32),
    };
    let sheet = Part {
        particles: corners.map(particle).to_vec(),
        springs: [[0, 1], [2, 3], [0, 2], [1, 3]].map(spring).to_vec(),
        bends: Vec::new(),
        volumes: Vec::new(),
        surface: Surface {
            corners: corners.into_iter().enumerate().map(corner).collect(),
            triangles: vec![[0, 2, 1], [1, 2, 3]],
            two_sided: true,
        },
    };
    let friction = Friction::Coulomb(0.5);
    let floor = Plane { normal: DVec3::Y, offset: -0.5, restitution: 0.0, friction };
    let mut scene = Scene { planes: vec![floor], ..Scene::default() };
    scene.add("sheet", sheet);
    scene
}
