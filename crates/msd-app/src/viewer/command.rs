//! Commands: what a key or a button asks for.

use super::gesture::Tool;

/// Something a key or a button asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Pause or go on.
    TogglePause,
    /// Pause and take one step.
    StepForward,
    /// Pause and take one step back.
    StepBack,
    /// Undo the last edit, pin, cut or freeze.
    Undo,
    /// Do again what was undone last.
    Redo,
    /// Start the scene again, as its file is now.
    Restart,
    /// Read the file of the scene again.
    Reload,
    /// Make the present shape the shape at rest.
    Freeze,
    /// Pin or free the particle under the pointer, or else the selected one.
    Pin,
    /// Show or hide the edges of surfaces.
    Wireframe,
    /// Bring everything into view.
    FrameAll,
    /// Turn the camera by so many steps to the right and up.
    Turn(i8, i8),
    /// Come closer by so many steps.
    Closer(i8),
    /// Begin or end a recording.
    Record,
    /// Take a picture of what is seen.
    Picture,
    /// Open the built-in scene with this number, from 0.
    Scene(usize),
    /// Choose what a left drag does; grabbing, where that was chosen already.
    Tool(Tool),
    /// Let go, deselect, grab again, close the help.
    Escape,
    /// Open or close the gallery.
    Open,
    /// Save the run as it is.
    SaveRun,
    /// Save the scene with the values of the sliders.
    SaveScene,
    /// Copy the command that shows what is seen.
    CopyCommand,
    /// Offer the guide again.
    Guide,
    /// Let the window fill the screen, or give it back its size.
    FullScreen,
    /// Show or hide the panels.
    Panels,
    /// Show or hide the help.
    Help,
    /// Close the window.
    Quit,
}
