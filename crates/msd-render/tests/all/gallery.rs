//! A gallery of pictures, written for the eye: not a test by itself.
//!
//! `MSD_GALLERY=pictures cargo test -p msd-render --test all -- --ignored gallery`

use crate::scenes::{
    Still, block, floor, particle, pin, plane, rope, scene_of, sheet, spring, surface,
};
use glam::{DMat3, DVec3};
use msd_core::{Grab, Part, Scene, Vector};
use msd_render::{Camera, Gpu, Offscreen, Quality, Quantity, Renderer, Style, View, bounds, wgpu};

const SIZE: [u32; 2] = [1280, 720];

fn write(gpu: &Gpu, name: &str, scene: &Scene, change: impl Fn(&mut View)) {
    let directory = std::env::var("MSD_GALLERY").unwrap_or_else(|_| "pictures".to_owned());
    std::fs::create_dir_all(&directory).unwrap();
    let still = Still::<f32>::new(scene);
    let mut snapshot = still.snapshot();
    let grab = Grab {
        particle: 0,
        target: Vector::of(snapshot.position(0).to_f64() + DVec3::new(-1.5, 1.0, 0.5)),
        stiffness: 1.0,
        damping: 1.0,
        max_force: 1.0,
    };
    let grabs = [grab];
    if name.contains("grab") {
        snapshot.grabs = &grabs;
    }
    let mut view = View::default();
    view.camera.frame(bounds(&snapshot).unwrap(), SIZE[0] as f32 / SIZE[1] as f32);
    change(&mut view);
    let mut offscreen = Offscreen::new(gpu, SIZE[0], SIZE[1]).unwrap();
    offscreen.render(&snapshot, &view).unwrap();
    let mut times: Vec<f64> = Vec::new();
    let mut image = None;
    for _ in 0..10 {
        let start = std::time::Instant::now();
        image = Some(offscreen.render(&snapshot, &view).unwrap());
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    println!("{name}: median {:.1} ms, least {:.1} ms", times[5], times[0]);
    let image = image.unwrap();
    let path = format!("{directory}/{name}.png");
    image::RgbaImage::from_raw(image.width, image.height, image.rgba).unwrap().save(path).unwrap();
}

/// The bunny of the lab, scaled to about 6 m.
fn bunny() -> Part {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../msd-scene/meshes/bunny.obj");
    let text = std::fs::read_to_string(path).unwrap();
    let mut part = Part::default();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let kind = words.next();
        let fields: Vec<&str> = words.collect();
        if kind == Some("v") {
            let at: Vec<f64> = fields.iter().map(|field| field.parse().unwrap()).collect();
            part.particles.push(particle(at[0], at[1], at[2]));
        } else if kind == Some("f") {
            let index = |f: &&str| f.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
            let corners: Vec<u32> = fields.iter().map(index).collect();
            triangles.push([corners[0], corners[1], corners[2]]);
        }
    }
    for [a, b, c] in &triangles {
        for [a, b] in [[*a, *b], [*b, *c], [*c, *a]] {
            if a < b {
                let [from, to] = [a, b].map(|end| part.particles[end as usize].position);
                part.springs.push(spring(a as usize, b as usize, from.distance(to)));
            }
        }
    }
    let uvs = vec![[0.0, 0.0]; part.particles.len()];
    part.surface = surface(&uvs, triangles, false);
    part
}

/// A cloth that hangs from two corners, in folds.
fn curtain() -> Part {
    let mut part = sheet(31, 30.0);
    for particle in &mut part.particles {
        let DVec3 { x, z, .. } = particle.position;
        let down = (z + 15.0) / 30.0;
        let fold = (x * 0.7).sin() * (0.4 + 1.4 * down) + 0.5 * (x * 1.7 + down * 3.0).cos();
        let sag = 0.012 * (225.0 - x * x);
        particle.position = DVec3::new(x * (1.0 - 0.10 * down), 15.0 - 27.0 * down - sag, fold);
    }
    part
}

#[test]
#[ignore = "writes pictures for the eye"]
fn gallery() {
    let gpu = pollster::block_on(Gpu::headless()).unwrap();
    println!("{:?}", gpu.adapter.get_info().name);
    let mut cube = block(10);
    cube.place(DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(0.35), DVec3::Y * 5.0);
    let jelly = scene_of(cube, &[floor(-5.0)]);
    write(&gpu, "jelly", &jelly, |_| {});
    write(&gpu, "jelly-grab-particles-wire", &jelly, |view| {
        view.style.particles = true;
        view.style.wireframe = true;
    });
    write(&gpu, "jelly-noshadow", &jelly, |view| view.style.shadows = false);
    let mut squeezed = jelly.clone();
    for (index, particle) in squeezed.particles.iter_mut().enumerate() {
        particle.position.y = particle.position.y.max(-5.0) * (1.0 + 0.02 * (index as f64).sin());
    }
    write(&gpu, "jelly-springs", &squeezed, |view| {
        view.style.surfaces = false;
        view.style.colour_by = Some(Quantity::Strain);
        view.style.particles = true;
    });
    let low = bunny().particles.iter().map(|p| p.position.y).fold(f64::MAX, f64::min);
    let hare = scene_of(bunny(), &[floor(low)]);
    write(&gpu, "bunny", &hare, |view| view.camera.yaw = 0.3);
    write(&gpu, "bunny-wire", &hare, |view| view.style.wireframe = true);
    let mut cloth = scene_of(curtain(), &[floor(-14.0)]);
    cloth.pins = vec![pin(0), pin(30)];
    write(&gpu, "cloth", &cloth, |view| view.camera.yaw = 0.5);
    write(&gpu, "cloth-springs", &cloth, |view| view.style.colour_by = Some(Quantity::Strain));
    let mut ropes = scene_of(rope(30, 0.5), &[floor(-5.0), plane(DVec3::new(1.0, 2.0, 0.0), -3.5)]);
    ropes.pins = vec![pin(0), pin(29)];
    write(&gpu, "rope-grab", &ropes, |_| {});
    write(&gpu, "rope-springs", &ropes, |view| {
        view.style.colour_by = Some(Quantity::Strain);
        view.style.particles = true;
    });
    write(&gpu, "below", &jelly, |view| view.camera.pitch = -0.6);
    let many: Vec<Scene> = (0..1).map(|_| many()).collect();
    write(&gpu, "many", &many[0], |view| {
        view.camera = Camera { pitch: 0.25, ..view.camera };
        view.style = Style { colour_by: None, ..view.style };
    });
}

#[test]
#[ignore = "measures time"]
fn costs() {
    let gpu = pollster::block_on(Gpu::headless()).unwrap();
    let low = bunny().particles.iter().map(|p| p.position.y).fold(f64::MAX, f64::min);
    let hare = scene_of(bunny(), &[floor(low)]);
    let still = Still::<f32>::new(&hare);
    let snapshot = still.snapshot();
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let mut renderer = Renderer::new(&gpu.device, (format, Quality::Full));
    for _ in 0..5 {
        let start = std::time::Instant::now();
        renderer.prepare(&gpu.device, &gpu.queue, &snapshot, &View::default());
        println!("cost-prepare: {:.2} ms", start.elapsed().as_secs_f64() * 1e3);
    }
    let mut view = View::default();
    view.camera.frame(bounds(&snapshot).unwrap(), 16.0 / 9.0);
    for (name, planes, surfaces, shadows, viewport) in [
        ("empty", true, true, true, [0.0; 4]),
        ("sky", false, false, false, [0.0, 0.0, 1280.0, 720.0]),
        ("planes", true, false, false, [0.0, 0.0, 1280.0, 720.0]),
        ("planes+shadows", true, false, true, [0.0, 0.0, 1280.0, 720.0]),
        ("surfaces", false, true, false, [0.0, 0.0, 1280.0, 720.0]),
        ("surfaces+shadows", false, true, true, [0.0, 0.0, 1280.0, 720.0]),
        ("all", true, true, true, [0.0, 0.0, 1280.0, 720.0]),
    ] {
        view.style = Style { planes, surfaces, shadows, ..view.style };
        renderer.prepare(&gpu.device, &gpu.queue, &snapshot, &view);
        println!("cost {name}: {:.1} ms", frame_time(&gpu, &mut renderer, viewport));
    }
}

#[test]
#[ignore = "takes seconds and 200 MB"]
fn a_million_springs() {
    let gpu = pollster::block_on(Gpu::headless()).unwrap();
    let mut scene = scene_of(sheet(708, 70.0), &[floor(-20.0)]);
    for (index, particle) in scene.particles.iter_mut().enumerate() {
        particle.position.y = (index as f64 * 0.013).sin();
    }
    println!("{} springs", scene.springs.len());
    let still = Still::<f32>::new(&scene);
    let snapshot = still.snapshot();
    let mut view = View::default();
    view.camera.frame(bounds(&snapshot).unwrap(), 4.0 / 3.0);
    view.style =
        Style { colour_by: Some(Quantity::Strain), surfaces: false, shadows: false, ..view.style };
    let start = std::time::Instant::now();
    msd_render::render_image(&gpu, &snapshot, &view, 320, 240).unwrap();
    println!("{:.1} s", start.elapsed().as_secs_f64());
}

/// The least time of a picture without reading it back, ms: other programs only ever add to it.
fn frame_time(gpu: &Gpu, renderer: &mut Renderer, viewport: [f32; 4]) -> f64 {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let mut least = f64::MAX;
    for _ in 0..15 {
        let start = std::time::Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.draw(&mut encoder, &target, SIZE, viewport);
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        least = least.min(start.elapsed().as_secs_f64() * 1e3);
    }
    least
}

/// Several bodies, for the palette.
fn many() -> Scene {
    let mut scene = Scene { planes: vec![floor(0.0)], ..Scene::default() };
    for index in 0..8 {
        let mut part = block(4);
        let turn = DMat3::from_rotation_y(index as f64 * 0.7);
        let column = (index % 4) as f64;
        part.place(turn, DVec3::new(column * 5.5, 1.5, (index / 4) as f64 * 6.0));
        scene.add(format!("{index}"), part);
    }
    scene
}
