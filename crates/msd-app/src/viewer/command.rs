//! Commands of keys and buttons.

use super::gesture::Tool;

/// A command of a key or a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Pause or resume.
    TogglePause,
    /// Pause and take one step.
    StepForward,
    /// Pause and take one step back.
    StepBack,
    /// Undo the last edit, pin, cut or freeze.
    Undo,
    /// Redo the edit that was undone last.
    Redo,
    /// Start the scene again from its current file.
    Restart,
    /// Read the file of the scene again.
    Reload,
    /// Make the current shape the rest shape.
    Freeze,
    /// Pin or free the hovered particle, or else the selected one.
    Pin,
    /// Show or hide the edges of surfaces.
    Wireframe,
    /// Bring the whole scene into view.
    FrameAll,
    /// Turn the camera by this many steps to the right and up.
    Turn(i8, i8),
    /// Zoom in by this many steps.
    Closer(i8),
    /// Begin or end a recording.
    Record,
    /// Save a picture of the current view.
    Picture,
    /// Open the built-in scene with this number, from 0.
    Scene(usize),
    /// Choose the tool of a left drag; the grab, if this tool is already active.
    Tool(Tool),
    /// Release, deselect, return to the grab tool, close the help.
    Escape,
    /// Open or close the gallery.
    Open,
    /// Save the run in its current state.
    SaveRun,
    /// Save the scene with the values of the sliders.
    SaveScene,
    /// Copy the command line for the current view.
    CopyCommand,
    /// Open or close the lessons.
    Lessons,
    /// Open the tour.
    Guide,
    /// Switch full screen on or off.
    FullScreen,
    /// Show or hide the panels.
    Panels,
    /// Show or hide the help.
    Help,
    /// Close the window.
    Quit,
}
