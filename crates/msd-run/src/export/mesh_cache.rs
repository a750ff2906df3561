//! Caches of the vertices of a mesh over time, for the mesh that they belong to: PC2 and MDD.

use super::Follow;
use super::skin::{Skin, seen_positions};
use crate::runner::Runner;
use msd_scene::{FileError, Output, Spool};
use std::io::{self, Write};

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cache {
    /// Point cache 2 of 3ds Max: little-endian, moments by number.
    Pc2,
    /// Of LightWave: big-endian, moments by time.
    Mdd,
}

/// A cache that is being written.
#[derive(Debug)]
pub struct MeshCache {
    cache: Cache,
    output: Output,
    particles: Vec<usize>,
    times: Vec<f64>,
    spool: Spool,
}

impl MeshCache {
    /// Begins one of the vertices of a skin, in their order.
    pub fn new(cache: Cache, output: Output, spool: Spool, skin: &Skin) -> Self {
        MeshCache { cache, output, particles: skin.particles.clone(), times: Vec::new(), spool }
    }

    fn header(&self) -> Vec<u8> {
        let (vertices, moments) = (self.particles.len() as i32, self.times.len() as i32);
        let mut header = Vec::new();
        match self.cache {
            Cache::Pc2 => {
                header.extend(b"POINTCACHE2\0");
                header.extend(1i32.to_le_bytes());
                header.extend(vertices.to_le_bytes());
                // The first frame of the animation, and frames from one moment to the next.
                header.extend(0f32.to_le_bytes());
                header.extend(1f32.to_le_bytes());
                header.extend(moments.to_le_bytes());
            }
            Cache::Mdd => {
                header.extend(moments.to_be_bytes());
                header.extend(vertices.to_be_bytes());
                let first = self.times.first().copied().unwrap_or(0.0);
                header.extend(
                    self.times.iter().flat_map(|time| ((time - first) as f32).to_be_bytes()),
                );
            }
        }
        header
    }
}

impl Follow for MeshCache {
    fn add(&mut self, runner: &Runner) -> io::Result<()> {
        self.times.push(runner.time());
        for component in seen_positions(runner, &self.particles).flatten() {
            let bytes = match self.cache {
                Cache::Pc2 => component.to_le_bytes(),
                Cache::Mdd => component.to_be_bytes(),
            };
            self.spool.write_all(&bytes)?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FileError> {
        let header = self.header();
        let MeshCache { mut output, spool, .. } = *self;
        let written = output.write_all(&header).and_then(|()| spool.copy_to(&mut output));
        written.map_err(|error| output.refused(&error))?;
        output.finish()
    }
}
