//! Parameters of an instance as a device reads them.

use crate::shader::{Kind, MOST_PLANES};
use bytemuck::{Pod, Zeroable};
use msd_core::glam::Vec3A;
use msd_core::laws::PlaneLaw;
use msd_core::{Model, Simulation};
use std::ops::Range;

/// The same as in `step.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    gravity: [f32; 4],
    force: [f32; 4],
    h: f32,
    half: f32,
    quarter: f32,
    sixth: f32,
    drag: f32,
    lag: f32,
    extent: u32,
    speed: u32,
    count: u32,
    planes: u32,
    grabs: u32,
    substeps: u32,
    first: u32,
    laws_at: u32,
    grabs_at: u32,
    flags_at: u32,
    bends_at: u32,
    unused: [u32; 3],
    list: [[[f32; 4]; 2]; MOST_PLANES],
}

/// Where an instance is in the buffers.
#[derive(Clone, Debug)]
pub struct Place {
    /// Its particles.
    pub particles: Range<usize>,
    pub laws_at: u32,
    /// 0 if it has no bends.
    pub bends_at: u32,
    pub grabs_at: u32,
    pub flags_at: u32,
}

/// The parameters of a simulation at a place, for a method.
pub fn params(simulation: &Simulation<f32>, kind: Kind, place: &Place) -> Params {
    let (model, settings) = (simulation.model(), simulation.settings());
    let h = settings.substep() as f32;
    // As the guard of the core.
    let crossing = 2.0 * f64::from(model.extent()) / settings.substep();
    let wide = |vector: Vec3A| [vector.x, vector.y, vector.z, 0.0];
    Params {
        gravity: wide(model.gravity()),
        force: wide(model.force()),
        h,
        half: h * 0.5,
        quarter: h * 0.5 * 0.5,
        sixth: h / 6.0,
        drag: model.drag(),
        lag: h * kind.lag(),
        extent: model.extent().to_bits(),
        speed: (crossing as f32).min(f32::MAX).to_bits(),
        count: model.particle_count() as u32,
        planes: model.planes().len() as u32,
        grabs: model.grabs().len() as u32,
        substeps: settings.substeps,
        first: place.particles.start as u32,
        laws_at: place.laws_at,
        grabs_at: place.grabs_at,
        flags_at: place.flags_at,
        bends_at: place.bends_at,
        unused: [0; 3],
        list: planes(model),
    }
}

fn planes(model: &Model<f32>) -> [[[f32; 4]; 2]; MOST_PLANES] {
    let mut planes = [[[0.0; 4]; 2]; MOST_PLANES];
    for (to, plane) in planes.iter_mut().zip(model.planes()) {
        let PlaneLaw { normal: [x, y, z], offset, restitution, friction, loss } = plane.into();
        *to = [[x, y, z, offset], [restitution, friction, loss, 0.0]];
    }
    planes
}
