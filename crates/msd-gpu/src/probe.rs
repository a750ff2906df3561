//! The bits of a device: whether they are those of the processor, and in which manner.
//!
//! Roots and reciprocals are checked for every mantissa, on the device. Every law is checked on
//! many inputs against the processor: laws, not operations, as a compiler may keep each operation
//! and still reorder several.

use crate::device::Device;
use crate::error::GpuError;
use crate::rests::{Rests, map};
use crate::shader::symbol::{Parameter, Spelling};
use crate::shader::{Choice, LAWS, Manner, Roots, Written, laws, programs, routines};
use std::fmt;
use wgpu::BufferUsages;

/// Inputs on which each law is checked.
const ROWS: usize = 1 << 17;
/// Inputs that the processor works on between two looks at the clock.
const PIECE: usize = 1 << 10;

/// The verdict on the bits of a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// It computes the bits of the processor in this manner.
    SameBits(Manner),
    /// It computes other bits in every manner. The fields are those of the manner with the fewest
    /// wrong inputs.
    Differs {
        /// The name of the first law that differs.
        law: &'static str,
        /// The number of inputs with other bits, of 131 072.
        wrong: usize,
    },
}

impl Verdict {
    /// The manner in which the device has the bits of the processor, if there is one.
    pub fn manner(&self) -> Option<Manner> {
        match self {
            Verdict::SameBits(manner) => Some(*manner),
            Verdict::Differs { .. } => None,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Verdict::SameBits(Manner { spelling, roots }) => {
                let spelling = format!("{spelling:?}").to_lowercase();
                let roots = format!("{roots:?}").to_lowercase();
                write!(f, "same bits as the processor ({spelling} sums, {roots} roots)")
            }
            Verdict::Differs { law, wrong } => {
                write!(f, "other bits than the processor in {wrong} of {ROWS} inputs of `{law}`")
            }
        }
    }
}

/// The manners in which a probe tries to compute the bits of the processor, the fastest first.
pub fn manners() -> impl Iterator<Item = Manner> {
    let of_roots =
        |roots| [Spelling::Exact, Spelling::Hidden].map(|spelling| Manner { spelling, roots });
    Roots::ALL.into_iter().flat_map(of_roots)
}

/// The WGSL that a verdict depends on: the programs of probes, and those of steps in one manner.
pub fn sources() -> String {
    let of_probes = LAWS.iter().map(|law| program_of(law, ""));
    let of_laws = manners().map(laws);
    let manner = Manner { spelling: Spelling::Exact, roots: Roots::Native };
    let of_steps = Choice::all().map(|choice| programs(choice, manner));
    of_probes.chain([EXHAUST.to_owned()]).chain(of_laws).chain(of_steps).collect()
}

/// Finds the manner in which a device computes the bits of the processor. It takes about a second
/// on a software adapter. A page of a browser responds meanwhile: the probe often rests.
///
/// # Errors
/// [`GpuError::Refused`] or [`GpuError::Lost`].
pub async fn probe(device: &Device) -> Result<Verdict, GpuError> {
    let exact_roots = find_roots(device).await?;
    let mut least: Option<(&'static str, usize)> = None;
    for manner in manners().filter(|manner| exact_roots.contains(&manner.roots)) {
        let Some(wrong) = first_wrong(device, &laws(manner)).await? else {
            return Ok(Verdict::SameBits(manner));
        };
        if least.is_none_or(|least| wrong.1 < least.1) {
            least = Some(wrong);
        }
    }
    let (law, wrong) = least.unwrap_or(("root", ROWS));
    Ok(Verdict::Differs { law, wrong })
}

/// The first law with other bits than those of the processor, in a program with all laws, and the
/// number of its inputs that differ.
async fn first_wrong(
    device: &Device,
    program: &str,
) -> Result<Option<(&'static str, usize)>, GpuError> {
    for law in &LAWS {
        let mut rests = Rests::new();
        let inputs = inputs(law, &mut rests).await;
        let outputs = run(device, &program_of(law, program), &inputs, law.outputs() * ROWS).await?;
        let rows = inputs.chunks(law.inputs() * PIECE);
        let mut wrong = 0;
        for (inputs, outputs) in rows.zip(outputs.chunks(law.outputs() * PIECE)) {
            rests.rest_if_due().await;
            wrong += count_wrong(law, inputs, outputs);
        }
        log::debug!("{}: {wrong} of {ROWS} inputs differ", law.name);
        if wrong != 0 {
            return Ok(Some((law.name, wrong)));
        }
    }
    Ok(None)
}

/// Inputs and outputs of which a law differs from that on the processor. Subnormal numbers count as
/// zero: devices may flush them.
fn count_wrong(law: &Written, inputs: &[f32], outputs: &[f32]) -> usize {
    let is_same = |a: f32, b: f32| {
        let are_small = a.abs() < f32::MIN_POSITIVE && b.abs() < f32::MIN_POSITIVE;
        a.to_bits() == b.to_bits() || are_small || a.is_nan() && b.is_nan()
    };
    let rows = inputs.chunks(law.inputs()).zip(outputs.chunks(law.outputs()));
    let differs = |(inputs, outputs): &(&[f32], &[f32])| {
        let wanted = (law.compute)(inputs);
        !wanted.as_flattened().iter().zip(*outputs).all(|(&a, &b)| is_same(a, b))
    };
    rows.filter(differs).count()
}

/// A program that computes a law for each row of inputs.
fn program_of(law: &Written, laws: &str) -> String {
    let (inputs, outputs) = (law.inputs(), law.outputs());
    let mut at = 0;
    let mut read = |count: usize| {
        let numbers = (at..at + count).map(|n| format!("inputs[row * {inputs}u + {n}u]"));
        at += count;
        numbers.collect::<Vec<_>>().join(", ")
    };
    let arguments: Vec<String> = law
        .parameters
        .iter()
        .map(|parameter| match parameter {
            Parameter::Number(_) => read(1),
            Parameter::Vector(_) => format!("vec3<f32>({})", read(3)),
        })
        .collect();
    let vector = |at: usize| if outputs == 3 { "y".into() } else { format!("y[{at}]") };
    let axes = ["x", "y", "z"];
    let store = |n: usize| {
        format!("    outputs[row * {outputs}u + {n}u] = {}.{};\n", vector(n / 3), axes[n % 3])
    };
    let stores: String = (0..outputs).map(store).collect();
    format!(
        "{laws}@group(0) @binding(1) var<storage, read> inputs: array<f32>;\n\
         @group(0) @binding(2) var<storage, read_write> outputs: array<f32>;\n\
         @compute @workgroup_size(64)\n\
         fn main(@builtin(global_invocation_id) id: vec3<u32>) {{\n    let row = id.x;\n    \
         let y = {}({});\n{stores}}}\n",
        law.name,
        arguments.join(", ")
    )
}

/// A number of a fixed sequence (Knuth's generator of 64 bits).
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 32) as u32
    }

    /// A float of either sign with an exponent in a range.
    fn float(&mut self, low: i32, high: i32) -> f32 {
        let exponent = low + (self.next() % (high - low + 1) as u32) as i32 + 127;
        f32::from_bits((self.next() & 0x807f_ffff) | (exponent as u32) << 23)
    }
}

/// Inputs of a law: numbers of many sizes, ends of springs near each other and at one place, points
/// on planes, a little inside and far, with and without friction and restitution.
async fn inputs(law: &Written, rests: &mut Rests) -> Vec<f32> {
    let mut sequence = Sequence(7);
    let mut inputs = vec![0.0; law.inputs() * ROWS];
    for rows in inputs.chunks_mut(law.inputs() * PIECE) {
        rests.rest_if_due().await;
        for row in rows.chunks_mut(law.inputs()) {
            row.iter_mut().for_each(|number| *number = sequence.float(-8, 3));
            shape_row(law, row, &mut sequence);
        }
    }
    inputs
}

fn shape_row(law: &Written, row: &mut [f32], sequence: &mut Sequence) {
    let place = |name: &str| law.place(name);
    let kind = sequence.next();
    for name in ["w", "stiffness", "h", "lag", "length", "substep", "mass", "drag"] {
        if let Some(at) = place(name) {
            let size = if matches!(name, "w" | "stiffness") { 100.0 } else { 0.01 };
            row[at] = if kind >> 8 & 15 == 0 && name == "w" { 0.0 } else { row[at].abs() * size };
        }
    }
    if let Some(at) = place("material") {
        row[at..at + 3].iter_mut().for_each(|number| *number = number.abs() * 10.0);
    }
    if let (Some(x), Some(p)) = (place("x"), place("p")) {
        for axis in 0..3 {
            let way = match kind % 8 {
                0..4 => sequence.float(-14, -3),
                4 => 0.0,
                5 => sequence.float(-45, -30),
                _ => continue,
            };
            row[p + axis] = row[x + axis] + way;
        }
        // All ends of a bend at one place, which gives it no direction.
        if let (Some(b), Some(c), 4) = (place("b"), place("c"), kind % 8) {
            row.copy_within(x..x + 3, b);
            row.copy_within(x..x + 3, c);
        }
    }
    // A bend of three particles has a weight of zero.
    if let (Some(w), 0) = (place("w3"), kind >> 12 & 3) {
        row[w] = 0.0;
    }
    let Some(n) = place("n") else { return };
    let square: f64 = (0..3).map(|axis| f64::from(row[n + axis]).powi(2)).sum();
    for axis in 0..3 {
        row[n + axis] = (f64::from(row[n + axis]) / square.sqrt()) as f32;
    }
    let law_at = place("law").expect("a plane has a law");
    for (axis, bit) in [1, 2, 4].into_iter().enumerate() {
        let number = &mut row[law_at + axis];
        *number = if kind & bit == 0 { 0.0 } else { number.abs().min(1.0) };
    }
    if let Some(x) = place("x") {
        let along: f32 = (0..3).map(|axis| row[n + axis] * row[x + axis]).sum();
        row[n + 3] = along
            + match kind >> 4 & 3 {
                0 => 0.0,
                1 => sequence.float(-26, -20),
                2 => sequence.float(-16, -6).abs(),
                _ => row[n + 3],
            };
    }
    if let (Some(v), 0) = (place("v"), kind & 8) {
        row[v..v + 3].iter_mut().for_each(|number| *number *= 1e-3);
    }
}

/// Counts wrong roots and reciprocals over all mantissas, by integers.
const EXHAUST: &str = r"
@group(0) @binding(1) var<storage, read> inputs: array<f32>;
@group(0) @binding(2) var<storage, read_write> wrong: array<atomic<u32>>;

fn is_root(q: f32, root: f32) -> bool {
    let s = (bitcast<u32>(root) & 0x7fffffu) | 0x800000u;
    let n = (bitcast<u32>(q) & 0x7fffffu) | 0x800000u;
    let shift = (bitcast<u32>(q) >> 23u) + 150u - 2u * (bitcast<u32>(root) >> 23u);
    // Near enough for 32 bits to do.
    if shift < 21u || shift > 25u || abs(root * root - q) > q * 1e-6f {
        return false;
    }
    let r = i32(s * s - (n << shift));
    return r < i32(select(s, s >> 1u, s == 0x800000u)) && r >= -i32(s);
}
fn is_inverse(x: f32, y: f32) -> bool {
    let m = (bitcast<u32>(x) & 0x7fffffu) | 0x800000u;
    let n = (bitcast<u32>(y) & 0x7fffffu) | 0x800000u;
    if abs(x * y - 1f) > 1e-6f {
        return false;
    }
    if m == 0x800000u {
        return n == 0x800000u;
    }
    return abs(2 * i32(n * m)) < i32(m);
}
fn count(is_right: bool, at: u32) {
    if !is_right {
        atomicAdd(&wrong[at], 1u);
    }
}
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var k = 0u; k < 128u; k++) {
        let i = id.x * 128u + k;
        let q = bitcast<f32>(0x3f800000u + i) * inputs[0];
        count(is_root(q, root_native(q)), 0u);
        count(is_root(q, root_fused(q)), 1u);
        count(is_root(q, root_whole(q)), 2u);
        if i < 0x800000u {
            count(is_inverse(q, inverse_native(q)), 0u);
            count(is_inverse(q, inverse_fused(q)), 1u);
            count(is_inverse(q, inverse_whole(q)), 2u);
        }
    }
}
";

/// The routines whose roots and reciprocals are all rounded correctly.
async fn find_roots(device: &Device) -> Result<Vec<Roots>, GpuError> {
    let program = [routines(), EXHAUST].concat();
    let wrong = run(device, &program, &[1.0], 3).await?;
    let wrong: Vec<u32> = wrong.into_iter().map(f32::to_bits).collect();
    log::debug!("wrong roots and reciprocals, native, fused and whole: {wrong:?}");
    Ok(Roots::ALL
        .into_iter()
        .zip(wrong)
        .filter(|(_, wrong)| *wrong == 0)
        .map(|row| row.0)
        .collect())
}

/// Runs a program over the rows of its inputs and returns so many numbers of its output.
async fn run(
    device: &Device,
    program: &str,
    inputs: &[f32],
    count: usize,
) -> Result<Vec<f32>, GpuError> {
    let (staging, mapped) = device
        .checked(|| {
            let pipeline = device.pipeline(program);
            let inputs = device.storage("inputs of a law", inputs)?;
            let outputs = device.storage("outputs of a law", &vec![0f32; count])?;
            let bytes = 4 * count as u64;
            let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
            let staging = device.empty("read-back of a law", bytes, usage)?;
            let layout = pipeline.get_bind_group_layout(0);
            let group = device.group(&layout, &[device.exact(), &inputs, &outputs]);
            let mut encoder = device.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups((ROWS / 64) as u32, 1, 1);
            }
            encoder.copy_buffer_to_buffer(&outputs, 0, &staging, 0, bytes);
            device.queue.submit([encoder.finish()]);
            let mapped = map(&staging);
            Ok((staging, mapped))
        })
        .await?;
    device.poll(wgpu::PollType::wait_indefinitely());
    // After a reset of the driver nothing is mapped any more.
    device.check_lost()?;
    mapped.await;
    device.check_lost()?;
    let bytes = staging.get_mapped_range(..).map_err(|reason| GpuError::Refused {
        adapter: device.name(),
        reason: reason.to_string(),
    })?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device() -> Option<Device> {
        match pollster::block_on(Device::open("")) {
            Ok(device) => Some(device),
            Err(error) => {
                assert!(std::env::var_os("MSD_REQUIRE_ADAPTER").is_none(), "no adapter: {error}");
                println!("SKIPPED: {error}");
                None
            }
        }
    }

    #[test]
    fn a_device_in_software_has_the_bits_of_the_processor() {
        let Some(device) = device() else { return };
        let verdict = pollster::block_on(probe(&device)).expect("a device that computes");
        assert!(matches!(verdict, Verdict::SameBits(_)), "{verdict}");
    }

    #[test]
    fn a_broken_law_is_found() {
        let Some(device) = device() else { return };
        let manner = Manner { spelling: Spelling::Hidden, roots: Roots::Native };
        let right = laws(manner);
        // One product of the law of springs is fused with the sum that it is added to.
        let at = right.find("fn pull").expect("the law of springs");
        let product = right[at..].find("hidden(").expect("an operation") + at;
        let broken = [&right[..product], "1.0000001f * hidden(", &right[product + 7..]].concat();
        let wrong = pollster::block_on(first_wrong(&device, &broken)).expect("a program");
        let (law, count) = wrong.expect("other bits");
        assert_eq!(law, "pull");
        assert!(ROWS / 10 < count, "{count}");
    }

    #[test]
    fn a_right_law_is_passed_and_its_inputs_exercise_it() {
        for law in &LAWS {
            let inputs = pollster::block_on(inputs(law, &mut Rests::new()));
            let row = |row: &[f32]| (law.compute)(row);
            let outputs: Vec<_> = inputs.chunks(law.inputs()).map(row).collect();
            let all: Vec<f32> = outputs.iter().flatten().flatten().copied().collect();
            assert_eq!(count_wrong(law, &inputs, &all), 0, "{}", law.name);
            let finite = all.iter().filter(|number| number.is_finite()).count();
            assert!(all.len() * 9 / 10 < finite, "{}: {finite} of {}", law.name, all.len());
            if law.name.starts_with("meet") {
                let met = outputs.iter().filter(|row| row[2][0] == 1.0).count();
                assert!(ROWS / 10 < met && met < ROWS * 9 / 10, "{}: {met}", law.name);
            }
        }
    }
}
