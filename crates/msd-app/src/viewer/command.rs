//! Commands: what a key or a button asks for.

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
    /// Start the scene again.
    Restart,
    /// Make the present shape the shape at rest.
    Freeze,
    /// Pin or free the particle under the pointer, or else the selected one.
    Pin,
    /// Show or hide the edges of surfaces.
    Wireframe,
    /// Bring everything into view.
    FrameAll,
    /// Begin or end a recording.
    Record,
    /// Open the built-in scene with this number, from 0.
    Scene(usize),
    /// Let go, deselect, close the help.
    Escape,
    /// Show or hide the help.
    Help,
    /// Close the window.
    Quit,
}
