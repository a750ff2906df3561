//! Errors of opening the window: the missing part, and the alternatives without a window.

use msd_render::RenderError;

/// Reason why no window was shown. Its text has two lines: the missing part, and the alternatives.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n{}", headless(scene))]
pub struct ViewError {
    /// The scene as the user named it: by name or file.
    pub scene: String,
    /// The missing part.
    pub what: Missing,
}

/// A part that a window needs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Missing {
    /// A display to open the window on, or a library to talk to it.
    #[error(
        "no display: {0}; the window needs X11 or Wayland, and on Debian/Ubuntu: \
         apt install libx11-xcb1 libxcursor1 libxi6 libxrandr2 libxkbcommon-x11-0 \
         mesa-vulkan-drivers"
    )]
    Display(String),
    /// A graphics adapter.
    #[error("{error}{hint}", error = .0, hint = driver(.0))]
    Graphics(Box<RenderError>),
    /// The graphics device, or the display, lost while the window was open.
    #[error("{0}")]
    Device(String),
    /// The window itself.
    #[error("no window: {0}")]
    Window(String),
    /// A valid scene.
    #[error("the scene cannot run: {0}")]
    Scene(#[from] msd_core::Error),
    /// A valid link.
    #[error("the link cannot be opened: {0}")]
    Link(String),
    /// A writable status file.
    #[error("the status file cannot be written: {0}")]
    Status(std::io::Error),
}

/// Returns the advice to install a driver, if the error lacks it: no driver supports the surface.
fn driver(error: &RenderError) -> &'static str {
    match error {
        RenderError::NoSurface(_) => {
            "; is there a driver? On Debian/Ubuntu: apt install mesa-vulkan-drivers"
        }
        _ => "",
    }
}

fn headless(scene: &str) -> String {
    // Quoted for a shell if needed.
    let scene = if scene.contains(char::is_whitespace) { &format!("\"{scene}\"") } else { scene };
    format!(
        "without a window: msd render {scene} --out picture.png, or msd run {scene} \
         (from the sources: cargo run --release -- render {scene} --out picture.png)"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_says_what_is_missing_and_what_works_in_two_lines() {
        let what = Missing::Display("DISPLAY is not set".to_owned());
        let text = ViewError { scene: "jelly".to_owned(), what }.to_string();
        assert_eq!(text.lines().count(), 2);
        assert!(text.contains("apt install") && text.contains("msd render jelly --out"));
    }

    #[test]
    fn the_hint_names_a_file_as_the_person_did() {
        for (scene, told) in [
            ("scenes/rope.toml", "msd render scenes/rope.toml --out"),
            ("my scenes/rope.toml", "msd run \"my scenes/rope.toml\" "),
        ] {
            let what = Missing::Display("DISPLAY is not set".to_owned());
            let text = ViewError { scene: scene.to_owned(), what }.to_string();
            assert!(text.contains(told), "{text}");
        }
    }
}
