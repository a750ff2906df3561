//! The memory a scene would take, counted before any body is built.

use crate::error::{FileError, Place};
use crate::file::tree::Source;
use msd_core::Neighbours;
use msd_core::lattice::FAMILIES;

/// What the bodies so far ask for.
#[derive(Default)]
pub(crate) struct Budget {
    particles: u128,
    springs: u128,
    bends: u128,
    volumes: u128,
}

/// The most memory a scene may take, bytes: beyond it a small machine starts to swap, and a page of
/// a browser, which has 4 GiB for everything, would abort.
const MEMORY: u128 = if cfg!(target_pointer_width = "32") { 1_000_000_000 } else { 4_000_000_000 };
/// Rows, columns in double precision and work space of a particle and of a spring, bytes.
const PARTICLE_BYTES: u128 = 400;
const SPRING_BYTES: u128 = 100;
const BEND_BYTES: u128 = 250;
const VOLUME_BYTES: u128 = 400;

impl Budget {
    /// Counts what a body asks for, before anything is allocated.
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

    /// Counts what is no body of a scene file; `asks` is where it is asked for, and by which key.
    pub(crate) fn take_for(
        &mut self,
        asks: impl FnOnce() -> (Place, String),
        [particles, springs]: [u128; 2],
    ) -> Result<(), FileError> {
        self.particles = self.particles.saturating_add(particles);
        self.springs = self.springs.saturating_add(springs);
        let bytes = self.particles.saturating_mul(PARTICLE_BYTES);
        let bytes = bytes.saturating_add(self.springs.saturating_mul(SPRING_BYTES));
        let bytes = bytes.saturating_add(self.bends.saturating_mul(BEND_BYTES));
        let bytes = bytes.saturating_add(self.volumes.saturating_mul(VOLUME_BYTES));
        if bytes <= MEMORY {
            return Ok(());
        }
        let (particles, springs) = (in_words(self.particles), in_words(self.springs));
        let (place, key) = asks();
        let hint = if key.ends_with(".spacing") { "; make it larger" } else { "" };
        Err(FileError::TooLarge {
            place,
            key,
            counts: format!("{particles} particles and {springs} springs"),
            gigabytes: bytes as f64 * 1e-9,
            limit: MEMORY as f64 * 1e-9,
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
