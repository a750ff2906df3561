//! Hashes of runs without an operating system, on another processor.
//!
//! Prints the lines of `crates/msd-run/tests/hashes.txt` of the scenes that it carries;
//! `scripts/check.sh bare` compares them.
#![no_std]
#![no_main]

extern crate alloc;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use embedded_alloc::LlffHeap;
use msd_core::{Error, Integrator, Real, Scene, Settings, Simulation, state_hash};
use panic_semihosting as _;

/// Memory for rows and columns, bytes.
const HEAP_BYTES: usize = 1 << 20;

#[global_allocator]
static HEAP: LlffHeap = LlffHeap::empty();

/// Scenes and how they are stepped, written by the test `same_bits` of msd-run.
const SCENES: [(&str, &[u8]); 3] = [
    ("chain", include_bytes!("../scenes/chain.postcard")),
    ("rough", include_bytes!("../scenes/rough.postcard")),
    ("square", include_bytes!("../scenes/square.postcard")),
];

#[entry]
fn main() -> ! {
    // SAFETY: called once, before anything is allocated.
    unsafe {
        embedded_alloc::init!(HEAP, HEAP_BYTES);
    }
    for (name, bytes) in SCENES {
        let (scene, settings): (Scene, Settings) = postcard::from_bytes(bytes).expect("a scene");
        for integrator in Integrator::ALL {
            let settings = Settings { integrator, ..settings };
            print_hash::<f32>(name, &scene, settings);
            // This processor has no double precision: it takes ten times as long.
            if name == "chain" {
                print_hash::<f64>(name, &scene, settings);
            }
        }
    }
    loop {
        debug::exit(debug::EXIT_SUCCESS);
    }
}

fn print_hash<R: Real>(name: &str, scene: &Scene, settings: Settings) {
    let hash = run::<R>(scene, settings).expect("a run that stays in the world");
    hprintln!("{} {} {} {:016x}", name, settings.integrator, R::NAME, hash);
}

/// The hash after ten seconds.
fn run<R: Real>(scene: &Scene, settings: Settings) -> Result<u64, Error> {
    let mut simulation = Simulation::<R>::new(scene, settings)?;
    for _ in 0..600 {
        simulation.step()?;
    }
    Ok(state_hash(&simulation.state()))
}
