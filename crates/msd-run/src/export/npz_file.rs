//! Arrays for numpy: an uncompressed ZIP of NPY files.

use super::Follow;
use super::skin::{positions, velocities};
use crate::on;
use crate::runner::Runner;
use msd_core::Real;
use msd_scene::{FileError, Output, Precision, Spool};
use std::io::{self, Write};

/// Positions and velocities of all particles that are being written, with the times, and the
/// masses and springs of the scene.
#[derive(Debug)]
pub struct Npz {
    output: Output,
    precision: Precision,
    particles: usize,
    times: Vec<f64>,
    /// Positions and velocities.
    columns: [Spool; 2],
    masses: Vec<f64>,
    ends: Vec<[u32; 2]>,
    rest_lengths: Vec<f64>,
}

impl Npz {
    /// Begins one of a run.
    pub fn new(output: Output, columns: [Spool; 2], runner: &Runner) -> Self {
        let (precision, times) = (runner.precision(), Vec::new());
        on!(runner, simulation => {
            let model = simulation.model();
            let there = (0..model.spring_count()).filter(|&spring| !model.is_cut(spring));
            let there: Vec<usize> = there.collect();
            Npz {
                output,
                precision,
                particles: model.particle_count(),
                times,
                columns,
                masses: model.masses().iter().map(|mass| mass.to_f64()).collect(),
                ends: there.iter().map(|&spring| model.ends()[spring]).collect(),
                rest_lengths: there.iter().map(|&row| model.rest_lengths()[row].to_f64()).collect(),
            }
        })
    }
}

impl Follow for Npz {
    fn add(&mut self, runner: &Runner) -> io::Result<()> {
        self.times.push(runner.time());
        let all = [positions(runner), velocities(runner)];
        for (spool, column) in self.columns.iter_mut().zip(all) {
            for component in column.into_iter().flatten() {
                match self.precision {
                    Precision::F32 => spool.write_all(&(component as f32).to_le_bytes())?,
                    Precision::F64 => spool.write_all(&component.to_le_bytes())?,
                }
            }
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), FileError> {
        let Npz { mut output, precision, particles, times, columns, masses, ends, .. } = *self;
        let number = match precision {
            Precision::F32 => "<f4",
            Precision::F64 => "<f8",
        };
        let rest_lengths = self.rest_lengths;
        let moments = times.len();
        let mut zip = Zip { output: &mut output, at: 0, entries: Vec::new() };
        let bytes =
            |column: &[f64]| column.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let write = || -> io::Result<()> {
            for (name, spool) in ["positions", "velocities"].into_iter().zip(columns) {
                zip.add_spool(name, &npy_header(number, &[moments, particles, 3]), spool)?;
            }
            zip.add(("times", &npy_header("<f8", &[moments])), &bytes(&times))?;
            zip.add(("masses", &npy_header("<f8", &[particles])), &bytes(&masses))?;
            let ends_bytes: Vec<u8> = ends.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            zip.add(("springs", &npy_header("<u4", &[ends.len(), 2])), &ends_bytes)?;
            let shape = [rest_lengths.len()];
            zip.add(("rest_lengths", &npy_header("<f8", &shape)), &bytes(&rest_lengths))?;
            zip.finish()
        };
        let written = write();
        written.map_err(|error| output.refused(&error))?;
        output.finish()
    }
}

/// Header before the numbers of an array: format 1.0 of NPY.
fn npy_header(number: &str, shape: &[usize]) -> Vec<u8> {
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let words = format!("{{'descr': '{number}', 'fortran_order': False, 'shape': ({sides}), }}");
    // Numbers begin at a multiple of 64 bytes, after a line feed.
    let length = (10 + words.len() + 1).next_multiple_of(64) - 10;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((length as u16).to_le_bytes());
    header.extend(words.as_bytes());
    header.resize(10 + length - 1, b' ');
    header.push(b'\n');
    header
}

/// A ZIP file without compression, with the fields of 64 bits everywhere.
struct Zip<'o> {
    output: &'o mut Output,
    at: u64,
    entries: Vec<Entry>,
}

struct Entry {
    name: String,
    check: u32,
    size: u64,
    at: u64,
}

/// The version that reads fields of 64 bits, 4.5.
const VERSION: u16 = 45;
/// Midnight of the first day that a ZIP file can say, so that equal runs give equal files.
const DATE: u16 = 1 << 5 | 1;
/// Look for it among the fields of 64 bits.
const ELSEWHERE: u32 = u32::MAX;

impl Zip<'_> {
    fn put(&mut self, parts: &[&[u8]]) -> io::Result<()> {
        for part in parts {
            self.output.write_all(part)?;
            self.at += part.len() as u64;
        }
        Ok(())
    }

    /// Adds an array: its header and its numbers.
    fn add(&mut self, (name, header): (&str, &[u8]), bytes: &[u8]) -> io::Result<()> {
        let mut check = crc32fast::Hasher::new();
        check.update(header);
        check.update(bytes);
        self.begin(name, check.finalize(), (header.len() + bytes.len()) as u64)?;
        self.put(&[header, bytes])
    }

    fn add_spool(&mut self, name: &str, header: &[u8], spool: Spool) -> io::Result<()> {
        let mut check = crc32fast::Hasher::new();
        check.update(header);
        check.combine(spool.check());
        let size = header.len() as u64 + spool.length();
        self.begin(name, check.finalize(), size)?;
        self.put(&[header])?;
        self.at += spool.length();
        spool.copy_to(self.output)
    }

    fn begin(&mut self, name: &str, check: u32, size: u64) -> io::Result<()> {
        let name = format!("{name}.npy");
        self.entries.push(Entry { name: name.clone(), check, size, at: self.at });
        let fields = common(check, &name, 20);
        let sizes = [1u16.to_le_bytes(), 16u16.to_le_bytes()].concat();
        let size = size.to_le_bytes();
        self.put(&[b"PK\x03\x04", &fields, name.as_bytes(), &sizes, &size, &size])
    }

    /// Writes the directory of the archive.
    fn finish(&mut self) -> io::Result<()> {
        let start = self.at;
        let entries = std::mem::take(&mut self.entries);
        for Entry { name, check, size, at } in &entries {
            let fields = common(*check, name, 28);
            let sizes = [1u16.to_le_bytes(), 24u16.to_le_bytes()].concat();
            let (size, at) = (size.to_le_bytes(), at.to_le_bytes());
            // No comment, the first disk, no attributes; the place is elsewhere.
            let rest = [&[0; 10], &ELSEWHERE.to_le_bytes()[..]].concat();
            let version = VERSION.to_le_bytes();
            let head = [b"PK\x01\x02", &version[..], &fields, &rest].concat();
            self.put(&[&head, name.as_bytes(), &sizes, &size, &size, &at])?;
        }
        let (end, count) = (self.at, entries.len() as u64);
        let versions = [VERSION.to_le_bytes(), VERSION.to_le_bytes()].concat();
        let numbers = [count, count, end - start, start].map(u64::to_le_bytes).concat();
        let head = [b"PK\x06\x06", &44u64.to_le_bytes()[..], &versions, &[0; 8]].concat();
        self.put(&[&head, &numbers])?;
        self.put(&[b"PK\x06\x07", &[0; 4], &end.to_le_bytes(), &1u32.to_le_bytes()])?;
        let counts = [u16::MAX.to_le_bytes(), u16::MAX.to_le_bytes()].concat();
        let sizes = [ELSEWHERE.to_le_bytes(), ELSEWHERE.to_le_bytes()].concat();
        self.put(&[b"PK\x05\x06", &[0; 4], &counts, &sizes, &[0; 2]])
    }
}

/// The fields that stand both before an entry and in the list, for so many bytes of others.
fn common(check: u32, name: &str, others: u16) -> Vec<u8> {
    let halves = [VERSION, 0, 0, 0, DATE].map(u16::to_le_bytes).concat();
    let words = [check, ELSEWHERE, ELSEWHERE].map(u32::to_le_bytes).concat();
    let lengths = [name.len() as u16, others].map(u16::to_le_bytes).concat();
    [halves, words, lengths].concat()
}
