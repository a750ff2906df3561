//! Pictures and films as files: PNG, GIF, animated WebP, and formats encoded by ffmpeg. An error is
//! a line for the user.

use image_webp::{ColorType, EncoderParams, EncodingError, WebPEncoder};
use msd_render::Image;
use msd_scene::{Output, Spool, shown_path};
use std::fmt::Display;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use tempfile::TempPath;

/// Extensions of films that ffmpeg encodes.
const BY_FFMPEG: [&str; 5] = ["mp4", "m4v", "mov", "mkv", "webm"];

/// Form of the output files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One picture.
    Png,
    /// A picture per frame, with its number in the name: the text before the number, the number of
    /// digits, and the text after it.
    Numbered(String, usize, String),
    /// A film with up to 256 colours per frame.
    Gif,
    /// A film in full colour.
    WebP,
    /// A film encoded by ffmpeg.
    Ffmpeg,
}

impl Kind {
    /// Returns the kind of a film or a picture by the name of its file.
    ///
    /// # Errors
    /// A line that names the formats and options to use instead.
    pub fn of(path: &Path, is_film: bool) -> Result<Self, String> {
        let shown = shown_path(path);
        let refused = |reason: &str| Err(format!("{shown}: {reason}"));
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let is_moving = matches!(&*ending, "gif" | "webp") || BY_FFMPEG.contains(&&*ending);
        match (&*ending, is_film) {
            ("png", false) => Ok(Kind::Png),
            ("png", true) => match numbered(&path.to_string_lossy()) {
                Some(kind) => Ok(kind),
                None => refused("a picture per frame needs its number in the name, as in %04d.png"),
            },
            ("gif", true) => Ok(Kind::Gif),
            ("webp", true) => Ok(Kind::WebP),
            (_, true) if is_moving => Ok(Kind::Ffmpeg),
            (_, false) if is_moving => {
                refused("a film takes --frames FROM:TO:EVERY, such as --frames 0:10:1/30")
            }
            (_, false) => refused("pictures are written as PNG; use .png"),
            (_, true) => refused(
                "unknown extension; use .webp, .gif or %04d.png, or .mp4, .webm, .mov or .mkv \
                 (these need ffmpeg)",
            ),
        }
    }

    /// Returns the file of a frame.
    pub fn path(&self, path: &Path, frame: usize) -> PathBuf {
        match self {
            Kind::Numbered(before, digits, after) => {
                format!("{before}{frame:0digits$}{after}").into()
            }
            _ => path.into(),
        }
    }
}

/// Splits a name at a number such as `%04d` or `%d`.
fn numbered(name: &str) -> Option<Kind> {
    let (before, rest) = name.split_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    let count = if digits.is_empty() { 1 } else { digits.parse().ok()? };
    let is_plain = (1..=9).contains(&count) && !after.contains('%');
    is_plain.then(|| Kind::Numbered(before.into(), count, after.into()))
}

/// A film in the course of writing.
pub trait FilmFile: Send {
    /// Adds a frame.
    fn add(&mut self, image: Image) -> Result<(), String>;

    /// Completes the file and moves it to its path.
    fn finish(self: Box<Self>) -> Result<(), String>;
}

/// Begins a film, or a picture.
///
/// # Errors
/// Fails if the file cannot be written or ffmpeg is not installed.
pub fn begin(path: &Path, kind: &Kind, about: About) -> Result<Box<dyn FilmFile>, String> {
    Ok(match kind {
        Kind::Ffmpeg => Box::new(ByFfmpeg::begin(path, about)?),
        Kind::Numbered(..) => Box::new(Pictures::numbered(path, kind)?),
        _ => {
            let output = Output::create(path).map_err(told)?;
            match kind {
                Kind::Gif => Box::new(Gif::begin(output, about)?),
                Kind::WebP => {
                    let spool = Spool::beside(path).map_err(|error| unwritten(path, error))?;
                    Box::new(WebP { output, spool, about, last: None, frames: 0 })
                }
                _ => Box::new(Pictures {
                    path: path.into(),
                    kind: kind.clone(),
                    next: Some(output),
                    frames: 0,
                }),
            }
        }
    })
}

fn unwritten(path: impl AsRef<Path>, error: impl Display) -> String {
    format!("{}: cannot be written: {error}", shown_path(path.as_ref()))
}

fn told(error: impl Display) -> String {
    error.to_string()
}

/// Facts about a film that are known before its frames.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Time from one frame to the next, seconds.
    pub every: f64,
    /// Whether pixels may be transparent.
    pub is_open: bool,
}

impl About {
    /// Returns the duration of a frame in units of 1/`parts` second. Rounding errors do not add up:
    /// the whole film has the right length.
    fn duration(&self, frame: usize, parts: f64) -> u32 {
        let time = |frame: usize| (frame as f64 * self.every * parts).round();
        (time(frame + 1) - time(frame)).clamp(1.0, f64::from(u16::MAX)) as u32
    }
}

/// One picture, or a picture per frame.
struct Pictures {
    path: PathBuf,
    kind: Kind,
    /// The file of the next frame, if it is open.
    next: Option<Output>,
    frames: usize,
}

impl Pictures {
    fn numbered(path: &Path, kind: &Kind) -> Result<Self, String> {
        // Opened at once, so that a file that cannot be written is reported before the run.
        let next = Output::create(&kind.path(path, 0)).map_err(told)?;
        Ok(Pictures { path: path.into(), kind: kind.clone(), next: Some(next), frames: 0 })
    }
}

impl FilmFile for Pictures {
    fn add(&mut self, image: Image) -> Result<(), String> {
        let path = self.kind.path(&self.path, self.frames);
        self.frames += 1;
        let opened = self.next.take().map_or_else(|| Output::create(&path), Ok);
        let mut output = opened.map_err(told)?;
        write_png(&mut output, &image).map_err(|error| unwritten(&path, error))?;
        output.finish().map_err(told)
    }

    fn finish(self: Box<Self>) -> Result<(), String> {
        Ok(())
    }
}

/// Writes a picture as PNG.
///
/// # Errors
/// Fails if `output` cannot be written.
pub fn write_png(output: impl Write, image: &Image) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(output, image.width, image.height);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.rgba)?;
    writer.finish()
}

/// A part of a picture: left, top, width and height, pixels.
type Patch = [u32; 4];

/// Returns the smallest patch that differs, from even coordinates; one pixel if nothing differs.
fn changed(before: Option<&Image>, image: &Image) -> Patch {
    let Image { width, height, rgba } = image;
    let whole = [0, 0, *width, *height];
    let Some(before) = before else { return whole };
    let row_bytes = 4 * *width as usize;
    let rows = || before.rgba.chunks_exact(row_bytes).zip(rgba.chunks_exact(row_bytes));
    let differs = |(a, b): (&[u8], &[u8])| a != b;
    let Some(top) = rows().position(differs) else { return [0, 0, 1, 1] };
    let bottom = *height as usize - rows().rev().position(differs).unwrap_or(0);
    let mut ends = [*width as usize, 0];
    for (a, b) in rows().skip(top).take(bottom - top) {
        let pixels = || a.chunks_exact(4).zip(b.chunks_exact(4));
        if let Some(first) = pixels().position(differs) {
            let last = *width as usize - pixels().rev().position(differs).unwrap_or(0);
            ends = [ends[0].min(first), ends[1].max(last)];
        }
    }
    // WebP supports even coordinates only.
    let (left, top) = (ends[0] as u32 & !1, top as u32 & !1);
    [left, top, ends[1] as u32 - left, bottom as u32 - top]
}

/// Returns the pixels of a patch; unchanged ones become transparent, which compresses better.
fn cut_out(before: Option<&Image>, image: &Image, [left, top, width, height]: Patch) -> Vec<u8> {
    let mut pixels = Vec::with_capacity(4 * width as usize * height as usize);
    for row in top..top + height {
        let start = 4 * (row * image.width + left) as usize;
        let range = start..start + 4 * width as usize;
        let from = pixels.len();
        pixels.extend_from_slice(&image.rgba[range.clone()]);
        let Some(before) = before else { continue };
        let pairs = pixels[from..].chunks_exact_mut(4).zip(before.rgba[range].chunks_exact(4));
        pairs.filter(|(now, before)| now == before).for_each(|(now, _)| now.fill(0));
    }
    pixels
}

/// A GIF: up to 256 colours in each frame, times in hundredths of a second.
struct Gif {
    encoder: gif::Encoder<Output>,
    about: About,
    last: Option<Image>,
    frames: usize,
    name: PathBuf,
}

impl Gif {
    fn begin(output: Output, about: About) -> Result<Self, String> {
        let name = PathBuf::from(output.name());
        let [width, height] = about.size.map(|side| side as u16);
        let begin = || {
            let mut encoder = gif::Encoder::new(output, width, height, &[])?;
            encoder.set_repeat(gif::Repeat::Infinite)?;
            Ok(encoder)
        };
        let encoder = begin().map_err(|error: gif::EncodingError| unwritten(&name, error))?;
        Ok(Gif { encoder, about, last: None, frames: 0, name })
    }
}

impl FilmFile for Gif {
    fn add(&mut self, image: Image) -> Result<(), String> {
        let before = self.last.as_ref().filter(|_| !self.about.is_open);
        let patch = changed(before, &image);
        let [left, top, width, height] = patch.map(|side| side as u16);
        let mut pixels = cut_out(before, &image, patch);
        let frame = gif::Frame::from_rgba_speed(width, height, &mut pixels, 10);
        let delay = self.about.duration(self.frames, 100.0) as u16;
        let dispose = match self.about.is_open {
            true => gif::DisposalMethod::Background,
            false => gif::DisposalMethod::Keep,
        };
        let frame = gif::Frame { left, top, delay, dispose, ..frame };
        self.frames += 1;
        self.last = Some(image);
        self.encoder.write_frame(&frame).map_err(|error| unwritten(&self.name, error))
    }

    fn finish(self: Box<Self>) -> Result<(), String> {
        let output = self.encoder.into_inner().map_err(|error| unwritten(&self.name, error))?;
        output.finish().map_err(told)
    }
}

/// Quality of the pictures of a WebP, from 0 to 100. At 95 they are some 42 dB from the rendered
/// ones, an invisible loss, at a tenth of the lossless size.
const QUALITY: u8 = 95;
/// Side of a block of the lossy encoder, pixels.
const BLOCK: u32 = 16;

/// An animated WebP, times in milliseconds.
struct WebP {
    output: Output,
    /// The encoded frames, kept aside as the header before them needs their length.
    spool: Spool,
    about: About,
    last: Option<Image>,
    frames: usize,
}

/// Returns the three low bytes of a number, little-endian.
fn three_bytes(number: u32) -> [u8; 3] {
    let [low, middle, high, _] = number.to_le_bytes();
    [low, middle, high]
}

/// Returns a chunk of a RIFF file, padded to an even length.
fn chunk(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let mut chunk = [name, &(content.len() as u32).to_le_bytes()[..], content].concat();
    chunk.resize(chunk.len().next_multiple_of(2), 0);
    chunk
}

impl WebP {
    fn frame(&mut self, image: &Image) -> Result<Vec<u8>, EncodingError> {
        let before = self.last.as_ref().filter(|_| !self.about.is_open);
        let patch @ [left, top, width, height] = changed(before, image);
        let pixels = cut_out(None, image, patch);
        let mut picture = Vec::new();
        if self.about.is_open {
            WebPEncoder::new(&mut picture).encode(&pixels, width, height, ColorType::Rgba8)?;
        } else {
            picture = with_loss(&pixels, [width, height])?;
        }
        let duration = self.about.duration(self.frames, 1000.0);
        let numbers = [left / 2, top / 2, width - 1, height - 1, duration].map(three_bytes);
        // The frame replaces its patch of the canvas instead of blending with it.
        let flags = [2];
        // The picture as a file of its own has 12 bytes before its chunk.
        Ok(chunk(b"ANMF", &[numbers.as_flattened(), &flags, &picture[12..]].concat()))
    }

    fn head(&self) -> Vec<u8> {
        let [width, height] = self.about.size.map(|side| three_bytes(side - 1));
        // Flags: animation and alpha.
        let canvas = chunk(b"VP8X", &[&[0x12, 0, 0, 0], &width[..], &height].concat());
        // Transparent background, endless loop.
        [canvas, chunk(b"ANIM", &[0; 6])].concat()
    }
}

/// Encodes a picture as a WebP file, with an invisible loss.
fn with_loss(pixels: &[u8], size: [u32; 2]) -> Result<Vec<u8>, EncodingError> {
    // Edge pixels are repeated to fill whole blocks: the encoder spoils partial ones.
    let [width, height] = size.map(|side| side.next_multiple_of(BLOCK));
    let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
    for row in (0..height).map(|row| row.min(size[1] - 1)) {
        for column in (0..width).map(|column| column.min(size[0] - 1)) {
            let at = 4 * (row * size[0] + column) as usize;
            rgb.extend_from_slice(&pixels[at..at + 3]);
        }
    }
    let mut picture = Vec::new();
    let mut encoder = WebPEncoder::new(&mut picture);
    let mut params = EncoderParams::default();
    (params.use_lossy, params.lossy_quality) = (true, QUALITY);
    encoder.set_params(params);
    encoder.encode(&rgb, width, height, ColorType::Rgb8)?;
    // The header, 26 bytes into the file, gets the true size; the blocks stay the same.
    for (side, bytes) in size.into_iter().zip(picture[26..30].chunks_exact_mut(2)) {
        bytes.copy_from_slice(&(side as u16).to_le_bytes());
    }
    Ok(picture)
}

impl FilmFile for WebP {
    fn add(&mut self, image: Image) -> Result<(), String> {
        let name = PathBuf::from(self.output.name());
        let frame = self.frame(&image).map_err(|error| unwritten(&name, error))?;
        self.frames += 1;
        self.last = Some(image);
        self.spool.write_all(&frame).map_err(|error| unwritten(&name, error))
    }

    fn finish(self: Box<Self>) -> Result<(), String> {
        let head = self.head();
        let WebP { mut output, spool, .. } = *self;
        let write = || {
            let length = 4 + head.len() as u64 + spool.length();
            let length = u32::try_from(length).map_err(|_| io::Error::other("more than 4 GB"))?;
            output.write_all(&[b"RIFF", &length.to_le_bytes()[..], b"WEBP", &head].concat())?;
            spool.copy_to(&mut output)
        };
        let written = write();
        written.map_err(|error| told(output.refused(&error)))?;
        output.finish().map_err(told)
    }
}

/// A child process that is killed and reaped on drop.
struct Helper(Option<Child>);

impl Drop for Helper {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            // `kill` fails if the child has ended by itself; `wait` reaps it in either case.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A film that ffmpeg encodes from the pixels on its standard input.
struct ByFfmpeg {
    ffmpeg: Helper,
    /// Temporary file for ffmpeg, which seeks in its output; moved to the final path at the end.
    part: TempPath,
    output: Output,
}

impl ByFfmpeg {
    fn begin(path: &Path, about: About) -> Result<Self, String> {
        let output = Output::create(path).map_err(told)?;
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let part = tempfile::Builder::new()
            .prefix(".msd-")
            .suffix(&format!(".part.{ending}"))
            .tempfile_in(folder.unwrap_or(Path::new(".")))
            .map_err(|error| unwritten(path, error))?
            .into_temp_path();
        let [width, height] = about.size;
        // Rounded to six digits, so that 1/30 s between frames gives a rate of exactly 30.
        let rate = format!("{}", (1e6 / about.every).round() / 1e6);
        let mut command = Command::new("ffmpeg");
        command
            .args(["-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"])
            .args(["-video_size", &format!("{width}x{height}"), "-framerate", &rate, "-i", "-"])
            // Most players decode no other pixel format, and it needs even sides.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
            .arg(&*part)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt;
            // Keeps Ctrl-C from ffmpeg: msd handles it and finishes the film.
            command.process_group(0);
        }
        let child = command.spawn().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => format!(
                "{}: .{ending} needs ffmpeg, which is not installed; .webp and .gif do not",
                shown_path(path)
            ),
            _ => format!("ffmpeg cannot be started: {error}"),
        })?;
        Ok(ByFfmpeg { ffmpeg: Helper(Some(child)), part, output })
    }
}

impl FilmFile for ByFfmpeg {
    fn add(&mut self, image: Image) -> Result<(), String> {
        let Some(child) = &mut self.ffmpeg.0 else { return Ok(()) };
        let written = child.stdin.as_mut().map(|input| input.write_all(&image.rgba));
        // `finish` reports the reason, which ffmpeg prints when it ends.
        if written.is_some_and(|written| written.is_err()) {
            child.stdin = None;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), String> {
        let ByFfmpeg { mut ffmpeg, part, mut output } = *self;
        // `wait_with_output` closes the standard input first.
        let Some(child) = ffmpeg.0.take() else { return Ok(()) };
        let done = child.wait_with_output();
        let done = done.map_err(|error| told(output.refused(&error)))?;
        if !done.status.success() {
            let said = msd_scene::one_line(String::from_utf8_lossy(&done.stderr));
            return Err(unwritten(output.name(), format!("ffmpeg: {said}")));
        }
        let copied = File::open(&part).and_then(|mut film| io::copy(&mut film, &mut output));
        copied.map_err(|error| told(output.refused(&error)))?;
        output.finish().map_err(told)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_what_pictures_are_written_into() {
        let of = |name: &str, is_film| Kind::of(Path::new(name), is_film);
        assert_eq!(of("a.png", false), Ok(Kind::Png));
        assert_eq!(of("a.GIF", true), Ok(Kind::Gif));
        assert_eq!(of("a.webp", true), Ok(Kind::WebP));
        assert_eq!(of("a.mp4", true), Ok(Kind::Ffmpeg));
        let kind = of("film/%04d.png", true).expect("a number");
        assert_eq!(kind.path(Path::new(""), 37), Path::new("film/0037.png"));
        assert_eq!(
            of("%d.png", true).expect("a number").path(Path::new(""), 7),
            Path::new("7.png")
        );
        let told = |name: &str, is_film| of(name, is_film).expect_err(name);
        assert!(told("a.png", true).contains("as in %04d.png"));
        assert!(told("a.gif", false).contains("--frames 0:10:1/30"));
        assert!(told("a.jpg", false).contains("use .png"));
        assert!(told("a.xyz", true).contains(".webp, .gif"));
        for name in ["%.png", "%99d.png", "%d%d.png", "%sd.png"] {
            assert!(of(name, true).is_err(), "{name}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_ends_and_is_reaped_with_what_it_works_for() {
        let child = Command::new("sleep").arg("600").spawn().expect("sleep starts");
        let place = PathBuf::from(format!("/proc/{}", child.id()));
        let helper = Helper(Some(child));
        assert!(place.exists());
        drop(helper);
        // A zombie would still have an entry in `/proc`.
        assert!(!place.exists());
    }

    #[test]
    fn frames_together_last_as_long_as_the_film() {
        let about = About { size: [1, 1], every: 1.0 / 30.0, is_open: false };
        let sum: u32 = (0..300).map(|frame| about.duration(frame, 100.0)).sum();
        assert_eq!(sum, 1000);
    }

    #[test]
    fn what_has_changed_is_cut_out_from_an_even_place() {
        let image = |set: &[[u32; 2]]| {
            let mut rgba = vec![0; 4 * 8 * 6];
            set.iter().for_each(|[x, y]| rgba[4 * (8 * y + x) as usize] = 9);
            Image { width: 8, height: 6, rgba }
        };
        let before = image(&[]);
        assert_eq!(changed(None, &before), [0, 0, 8, 6]);
        assert_eq!(changed(Some(&before), &before), [0, 0, 1, 1]);
        let now = image(&[[3, 3], [5, 4]]);
        assert_eq!(changed(Some(&before), &now), [2, 2, 4, 3]);
        let patch = cut_out(None, &now, [2, 2, 4, 3]);
        assert_eq!(patch.iter().filter(|&&byte| byte == 9).count(), 2);
        assert_eq!((patch.len(), patch[4 * (4 + 1)]), (4 * 4 * 3, 9));
        // Unchanged pixels are transparent.
        let opaque = |set| {
            let mut image = image(set);
            image.rgba.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
            image
        };
        let (before, now) = (opaque(&[[2, 2]]), opaque(&[[2, 2], [3, 2]]));
        let patch = cut_out(Some(&before), &now, [2, 2, 2, 1]);
        assert_eq!(patch, [0, 0, 0, 0, 9, 0, 0, 255]);
    }
}
