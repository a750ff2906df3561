//! Keyboard shortcuts and their commands.

use crate::viewer::{Command, Tool};
use egui::{Event, Key, Modifiers, RawInput};

/// The keys and their effects, most used first, for the help.
pub const KEYS: &[(&str, &str)] = &[
    ("Space", "pause / resume"),
    (".  and  ,", "one step forward, one step back"),
    ("R", "restart from the current file"),
    ("Ctrl + R", "reload the scene file"),
    ("Ctrl + Z, with Shift", "undo an edit, a setting, a pin or a cut; redo"),
    ("P", "pin or free the particle under the pointer"),
    ("F", "freeze: make the current shape the rest shape"),
    ("C, then drag", "cut springs; C again: grab"),
    ("B, then drag", "select a group with a box; B again: grab"),
    ("F12", "save a picture as a PNG file"),
    ("F9", "start / stop recording to a file"),
    ("W", "wireframe"),
    ("A  or  Home", "frame the whole scene"),
    ("Arrows, + and -", "orbit and zoom, while no control has the focus"),
    ("1 to 9", "scenes"),
    ("O", "gallery of scenes; open a file"),
    ("S", "save the run"),
    ("Ctrl + S", "save the scene with the current values"),
    ("Ctrl + C", "copy the command line for this view"),
    ("Esc", "release, deselect, back to grabbing"),
    ("H", "hide or show the panels"),
    ("F11", "full screen"),
    ("Tab, arrows, Enter", "move the focus and use every control; Esc leaves it"),
    ("F1", "this help"),
    ("Ctrl + Q", "quit"),
];

const DIGITS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

/// Takes the shortcuts out of the input, unless a text field has the focus.
///
/// Tab stays with egui: it moves the focus, and the focused control then receives the keys.
pub fn take_commands(input: &mut RawInput, typing: bool) -> Vec<Command> {
    let mut commands = Vec::new();
    input.events.retain(|event| {
        if matches!(event, Event::Copy) && !typing {
            commands.push(Command::CopyCommand);
            return false;
        }
        let &Event::Key { key, pressed: true, repeat, modifiers, .. } = event else { return true };
        let Some(command) = command(key, modifiers, typing) else { return true };
        // A key held down repeats a step, but not a pause.
        use Command::{Closer, StepBack, StepForward, Turn};
        if !repeat || matches!(command, StepForward | StepBack | Turn(..) | Closer(_)) {
            commands.push(command);
        }
        false
    });
    commands
}

fn command(key: Key, modifiers: Modifiers, typing: bool) -> Option<Command> {
    if key == Key::Q && modifiers.command {
        return Some(Command::Quit);
    }
    if key == Key::S && modifiers.command && !typing {
        return Some(Command::SaveScene);
    }
    if key == Key::R && modifiers.command && !typing {
        return Some(Command::Reload);
    }
    if key == Key::Z && modifiers.command && !typing {
        return Some(if modifiers.shift { Command::Redo } else { Command::Undo });
    }
    if key == Key::F1 {
        return Some(Command::Help);
    }
    if key == Key::F11 {
        return Some(Command::FullScreen);
    }
    if key == Key::F12 {
        return Some(Command::Picture);
    }
    if key == Key::F9 && modifiers.is_none() {
        return Some(Command::Record);
    }
    // On many keyboards a plus is typed with Shift.
    let is_plus = key == Key::Plus && modifiers.shift_only();
    if typing || (modifiers.any() && !is_plus) {
        return None;
    }
    let digit = DIGITS.iter().position(|&digit| digit == key);
    Some(match key {
        Key::Space => Command::TogglePause,
        Key::Period => Command::StepForward,
        Key::Comma => Command::StepBack,
        Key::R => Command::Restart,
        Key::F => Command::Freeze,
        Key::P => Command::Pin,
        Key::C => Command::Tool(Tool::Cut),
        Key::B => Command::Tool(Tool::Select),
        Key::ArrowLeft => Command::Turn(-1, 0),
        Key::ArrowRight => Command::Turn(1, 0),
        Key::ArrowUp => Command::Turn(0, 1),
        Key::ArrowDown => Command::Turn(0, -1),
        Key::Plus | Key::Equals => Command::Closer(1),
        Key::Minus => Command::Closer(-1),
        Key::W => Command::Wireframe,
        Key::H => Command::Panels,
        Key::O => Command::Open,
        Key::S => Command::SaveRun,
        Key::A | Key::Home => Command::FrameAll,
        Key::Escape => Command::Escape,
        _ => Command::Scene(digit?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(key: Key, modifiers: Modifiers, repeat: bool) -> RawInput {
        let event = Event::Key { key, physical_key: None, pressed: true, repeat, modifiers };
        RawInput { events: vec![event], ..RawInput::default() }
    }

    fn commands(key: Key, modifiers: Modifiers, repeat: bool, typing: bool) -> Vec<Command> {
        take_commands(&mut press(key, modifiers, repeat), typing)
    }

    #[test]
    fn keys_are_taken_out_of_the_input() {
        let mut input = press(Key::W, Modifiers::NONE, false);
        assert_eq!(take_commands(&mut input, false), [Command::Wireframe]);
        assert!(input.events.is_empty());
    }

    #[test]
    fn typing_keeps_its_keys() {
        for key in [Key::Space, Key::R, Key::Num1, Key::W, Key::Escape, Key::Period] {
            let mut input = press(key, Modifiers::NONE, false);
            assert!(take_commands(&mut input, true).is_empty());
            assert_eq!(input.events.len(), 1);
        }
        assert_eq!(commands(Key::Q, Modifiers::COMMAND, false, true), [Command::Quit]);
    }

    #[test]
    fn escape_and_plain_q_do_not_quit() {
        assert_eq!(commands(Key::Escape, Modifiers::NONE, false, false), [Command::Escape]);
        assert!(commands(Key::Q, Modifiers::NONE, false, false).is_empty());
    }

    #[test]
    fn a_held_key_repeats_steps_only() {
        assert_eq!(commands(Key::Period, Modifiers::NONE, true, false), [Command::StepForward]);
        assert!(commands(Key::Space, Modifiers::NONE, true, false).is_empty());
        assert!(commands(Key::R, Modifiers::COMMAND, true, false).is_empty());
        assert_eq!(commands(Key::R, Modifiers::COMMAND, false, false), [Command::Reload]);
    }

    #[test]
    fn undo_is_where_everyone_expects_it() {
        let undo = |modifiers| commands(Key::Z, modifiers, false, false);
        assert_eq!(undo(Modifiers::COMMAND), [Command::Undo]);
        assert_eq!(undo(Modifiers::COMMAND | Modifiers::SHIFT), [Command::Redo]);
        assert!(undo(Modifiers::NONE).is_empty());
        assert!(commands(Key::Z, Modifiers::COMMAND, false, true).is_empty());
    }

    #[test]
    fn a_plus_zooms_with_and_without_shift() {
        for modifiers in [Modifiers::NONE, Modifiers::SHIFT] {
            assert_eq!(commands(Key::Plus, modifiers, false, false), [Command::Closer(1)]);
        }
        // With Ctrl, plus scales egui's panels instead.
        assert!(commands(Key::Plus, Modifiers::COMMAND, false, false).is_empty());
    }

    #[test]
    fn digits_open_scenes() {
        assert_eq!(commands(Key::Num3, Modifiers::NONE, false, false), [Command::Scene(2)]);
    }
}
