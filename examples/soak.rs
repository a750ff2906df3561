//! Speed and memory of a long run: a row per simulated minute, then how much both changed.
//!
//! `cargo run --release --example soak [SCENE] [SECONDS]`, an hour of `jelly` by default.

use msd::run::Runner;
use std::error::Error;
use std::time::Instant;

/// A minute, seconds.
const MINUTE: f64 = 60.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().unwrap_or_else(|| "jelly".into());
    let seconds: f64 = arguments.next().map_or(Ok(3600.0), |text| text.parse())?;
    let mut runner = Runner::open(&msd::scene::open(&scene)?)?;
    let steps = (MINUTE / runner.settings().step).round() as usize;
    let mut times = Vec::with_capacity(steps);
    let (mut first, mut last, mut memory) = (None, 0.0, [None, None]);
    println!("minute,median_step_ms,resident_bytes,total_energy_j,dissipated_j");
    for minute in 1..=(seconds / MINUTE).ceil() as u64 {
        times.clear();
        for _ in 0..steps {
            let start = Instant::now();
            runner.step()?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        last = median(&mut times);
        let energy = runner.energy();
        if !energy.total().is_finite() {
            return Err(format!("the energy is {} J", energy.total()).into());
        }
        let resident = memory_stats::memory_stats().map(|stats| stats.physical_mem);
        println!(
            "{minute},{last:.6},{},{:.9e},{:.9e}",
            resident.map_or("unknown".into(), |bytes| bytes.to_string()),
            energy.total(),
            energy.dissipated
        );
        // The first minute warms up the machine; its memory does not count as growth.
        memory = [memory[0].or(resident), resident];
        first.get_or_insert(last);
    }
    let ratio = first.map_or(1.0, |first: f64| last / first);
    println!("# the last minute took {ratio:.3} times as long per step as the first");
    if let [Some(first), Some(last)] = memory {
        println!("# resident memory grew by {} bytes since the first", last as i64 - first as i64);
    }
    Ok(())
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
