//! The memory a scene would take, counted before any body is built.

use crate::error::{FileError, Place};
use crate::file::tree::Source;
use msd_core::lattice::FAMILIES;
use msd_core::{Neighbours, Scene};
use std::sync::atomic::{AtomicU64, Ordering};

/// The demand of the bodies so far.
#[derive(Default)]
pub(crate) struct Budget {
    particles: u128,
    springs: u128,
    bends: u128,
    volumes: u128,
}

/// The most memory that a scene may take, bytes. Until it is set: beyond it a small machine starts
/// to swap, and a page of a browser, which has 4 GiB for everything, would abort.
static MEMORY: AtomicU64 = AtomicU64::new(if IS_SMALL { 1_000_000_000 } else { 4_000_000_000 });
/// Whether addresses have 32 bits.
const IS_SMALL: bool = cfg!(target_pointer_width = "32");

/// Sets the most memory that a scene opened by this process may take, bytes, by an estimate that is
/// made before any of it is built. The default is 4 GB, and 1 GB where addresses have 32 bits.
pub fn limit_memory(bytes: u64) {
    MEMORY.store(bytes, Ordering::Relaxed);
}

/// Rows, columns in double precision and work space of a particle and of a spring, bytes.
const PARTICLE_BYTES: u128 = 400;
const SPRING_BYTES: u128 = 100;
const BEND_BYTES: u128 = 250;
const VOLUME_BYTES: u128 = 400;

/// Estimates the memory that a scene and a run of it take, bytes.
pub fn memory_of(scene: &Scene) -> f64 {
    let count = |rows: usize| rows as u128;
    let budget = Budget {
        particles: count(scene.particles.len()),
        springs: count(scene.springs.len()),
        bends: count(scene.bends.len()),
        volumes: count(scene.volumes.len()),
    };
    budget.bytes() as f64
}

impl Budget {
    /// Counts the demand of a body, before anything is allocated.
    pub(crate) fn take(
        &mut self,
        source: &Source<'_>,
        key: std::fmt::Arguments<'_>,
        counts: [u128; 2],
    ) -> Result<(), FileError> {
        let asks = || {
            let key = key.to_string();
            (source.place_of(&key), key)
        };
        self.take_for(asks, counts)
    }

    /// Counts the bends of the body that is counted next.
    pub(crate) fn add_bends(&mut self, bends: u128) {
        self.bends = self.bends.saturating_add(bends);
    }

    /// Counts the volumes of the body that is counted next.
    pub(crate) fn add_volumes(&mut self, volumes: u128) {
        self.volumes = self.volumes.saturating_add(volumes);
    }

    /// The memory of all that was counted, bytes.
    fn bytes(&self) -> u128 {
        let rows = [
            (self.particles, PARTICLE_BYTES),
            (self.springs, SPRING_BYTES),
            (self.bends, BEND_BYTES),
            (self.volumes, VOLUME_BYTES),
        ];
        let bytes = rows.map(|(count, each)| count.saturating_mul(each));
        bytes.into_iter().fold(0, u128::saturating_add)
    }

    /// Counts rows that are not bodies of a scene file; `asks` is the place that asks for them, and
    /// the key.
    pub(crate) fn take_for(
        &mut self,
        asks: impl FnOnce() -> (Place, String),
        [particles, springs]: [u128; 2],
    ) -> Result<(), FileError> {
        self.particles = self.particles.saturating_add(particles);
        self.springs = self.springs.saturating_add(springs);
        let bytes = self.bytes();
        let limit = MEMORY.load(Ordering::Relaxed);
        if bytes <= u128::from(limit) {
            return Ok(());
        }
        let (particles, springs) = (in_words(self.particles), in_words(self.springs));
        let (place, key) = asks();
        let hint = match (key.ends_with(".spacing"), IS_SMALL) {
            (true, true) => "; make it larger",
            (true, false) => "; make it larger, or allow more by --memory",
            (false, true) => "",
            (false, false) => "; --memory allows more",
        };
        Err(FileError::TooLarge {
            place,
            key,
            counts: format!("{particles} particles and {springs} springs"),
            gigabytes: bytes as f64 * 1e-9,
            limit: limit as f64 * 1e-9,
            hint,
        })
    }
}

/// A count for a message: nobody reads twenty digits, and a saturated sum has wrong ones.
fn in_words(count: u128) -> String {
    match count {
        u128::MAX => "more than 1e38".into(),
        0..1_000_000_000_000_000 => count.to_string(),
        _ => format!("{:.1e}", count as f64),
    }
}

/// Particles and springs of a lattice that need not fit.
pub(crate) fn count_lattice(size: [usize; 3], neighbours: Neighbours) -> [u128; 2] {
    let families = if neighbours == Neighbours::All { FAMILIES.len() } else { 3 };
    let product = |lengths: [u128; 3]| lengths.into_iter().fold(1, u128::saturating_mul);
    let springs = FAMILIES[..families].iter().map(|step| {
        product(
            [0, 1, 2].map(|axis| (size[axis] - step[axis].unsigned_abs().min(size[axis])) as u128),
        )
    });
    [product(size.map(|length| length as u128)), springs.fold(0, u128::saturating_add)]
}
