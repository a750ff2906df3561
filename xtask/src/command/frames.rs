//! Costs of pictures.

use super::Failure;
use msd_core::Snapshot;
use msd_render::{Gpu, Quality, Renderer, Sheet, Style, View, bounds, wgpu};
use msd_run::{Runner, on};
use std::path::PathBuf;
use std::time::Instant;

/// Number of times that each picture is drawn; the least time counts, as other programs only ever
/// add to it.
const TIMES: usize = 12;

/// Prints the time of a picture of each scene, by quality and by contents.
pub fn run_frames(scenes: &[PathBuf], size: &[u32]) -> Result<(), Failure> {
    let gpu = pollster::block_on(Gpu::headless()).map_err(Failure::input)?;
    let &[width, height] = size else { return Err(Failure::input("a size is WIDTH HEIGHT")) };
    let info = gpu.adapter.get_info();
    println!("{} ({:?}), {width}x{height}, ms:", info.name, info.device_type);
    println!("{:<12} {:<5} {:>8} {:>8} {:>11}", "scene", "", "upload", "picture", "no shadows");
    let sheet = Sheet::new(&gpu, width, height).map_err(Failure::input)?;
    for scene in scenes {
        let loaded = msd_scene::open(scene).map_err(Failure::input)?;
        let mut runner = Runner::open(&loaded).map_err(Failure::input)?;
        while runner.time() < 1.0 {
            runner.step().map_err(Failure::input)?;
        }
        for quality in [Quality::Full, Quality::Fast] {
            let mut renderer = Renderer::new(&gpu.device, (Sheet::FORMAT, quality));
            let mut draw = |shadows: bool| {
                on!(&runner, simulation => {
                    time(&gpu, &mut renderer, &sheet, (&simulation.snapshot(), shadows))
                })
            };
            let [upload, picture] = draw(true);
            let [_, plain] = draw(false);
            let name = format!("{quality:?}").to_lowercase();
            let scene = &loaded.name;
            println!("{scene:<12} {name:<5} {upload:>8.1} {picture:>8.1} {plain:>11.1}");
        }
    }
    Ok(())
}

/// The times that a picture takes to upload and to draw, ms.
fn time<R: msd_core::Real>(
    gpu: &Gpu,
    renderer: &mut Renderer,
    sheet: &Sheet,
    (snapshot, shadows): (&Snapshot<'_, R>, bool),
) -> [f64; 2] {
    let size = sheet.size();
    let [width, height] = size.map(|side| side as f32);
    let style = Style { shadows, ..Style::default() };
    let mut view = View { style, ..View::default() };
    if let Some(bounds) = bounds(snapshot) {
        view.camera.frame(bounds, width / height);
    }
    let mut least = [f64::MAX; 2];
    for _ in 0..TIMES {
        let start = Instant::now();
        renderer.prepare(&gpu.device, &gpu.queue, snapshot, &view);
        let uploaded = start.elapsed().as_secs_f64();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.draw(&mut encoder, &sheet.target(), size, [0.0, 0.0, width, height]);
        gpu.queue.submit([encoder.finish()]);
        // Fails where the device was lost, as the next picture does.
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        let whole = start.elapsed().as_secs_f64();
        for (least, time) in least.iter_mut().zip([uploaded, whole - uploaded]) {
            *least = least.min(time * 1e3);
        }
    }
    least
}
