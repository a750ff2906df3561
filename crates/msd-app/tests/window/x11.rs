//! Another program of the desktop: it drops a file, pastes, covers the screen, takes a screenshot.

use super::desk::PATIENCE;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, ImageFormat, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Connects to a display; returns its root too.
fn connect(display: &str) -> (RustConnection, Window) {
    let (connection, screen) = x11rb::connect(Some(display)).expect("the display");
    let root = connection.setup().roots[screen].root;
    (connection, root)
}

fn atom(connection: &RustConnection, name: &str) -> u32 {
    let asked = connection.intern_atom(false, name.as_bytes()).expect("the display");
    asked.reply().expect("an atom").atom
}

/// Creates a window of this size that window managers ignore.
fn window(connection: &RustConnection, root: Window, size: [u16; 2]) -> Window {
    let window = connection.generate_id().expect("a number");
    let own = CreateWindowAux::new().override_redirect(1).background_pixel(0);
    let [width, height] = size;
    let class = WindowClass::INPUT_OUTPUT;
    let made = connection.create_window(0, window, root, 0, 0, width, height, 0, class, 0, &own);
    made.expect("the display").check().expect("a window");
    window
}

/// Drops a file onto the window that accepts it: the messages of XDND, version 5.
pub fn drop_file(display: &str, file: &Path) {
    let (connection, root) = connect(display);
    let atom = |name: &str| atom(&connection, name);
    let source = window(&connection, root, [1, 1]);
    let (selection, list) = (atom("XdndSelection"), atom("text/uri-list"));
    connection.set_selection_owner(source, selection, 0u32).expect("the display");
    let target = target(&connection, root);
    let send = |kind: &str, data: [u32; 4]| {
        let [a, b, c, d] = data;
        let event = ClientMessageEvent::new(32, target, atom(kind), [source, a, b, c, d]);
        connection.send_event(false, target, EventMask::NO_EVENT, event).expect("the display");
        connection.flush().expect("the display");
    };
    send("XdndEnter", [5 << 24, list, 0, 0]);
    send("XdndPosition", [0, 600 << 16 | 400, 0, atom("XdndActionCopy")]);
    let asked = wait(&connection, |event| match event {
        Event::SelectionRequest(asked) => Some(asked),
        _ => None,
    });
    let text = format!("file://{}\r\n", file.display().to_string().replace(' ', "%20"));
    let [to, property] = [asked.requestor, asked.property];
    let put = connection.change_property8(PropMode::REPLACE, to, property, list, text.as_bytes());
    put.expect("the display");
    let answer = SelectionNotifyEvent {
        response_type: SELECTION_NOTIFY_EVENT,
        sequence: 0,
        time: asked.time,
        requestor: asked.requestor,
        selection,
        target: list,
        property,
    };
    connection.send_event(false, to, EventMask::NO_EVENT, answer).expect("the display");
    send("XdndDrop", [0, 0, 0, 0]);
    let finished = atom("XdndFinished");
    wait(&connection, |event| match event {
        Event::ClientMessage(message) if message.type_ == finished => Some(()),
        _ => None,
    });
}

/// Returns the window that accepts dropped files.
fn target(connection: &RustConnection, root: Window) -> Window {
    let aware = atom(connection, "XdndAware");
    let tree = connection.query_tree(root).expect("the display").reply().expect("windows");
    let takes_files = |&window: &Window| {
        let asked = connection.get_property(false, window, aware, AtomEnum::ANY, 0, 1);
        asked.expect("the display").reply().is_ok_and(|found| found.value_len == 1)
    };
    tree.children.into_iter().find(takes_files).expect("a window that takes files")
}

fn wait<T>(connection: &RustConnection, wanted: impl Fn(Event) -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        match connection.poll_for_event().expect("the display") {
            Some(event) => {
                if let Some(found) = wanted(event) {
                    return found;
                }
            }
            None => sleep(Duration::from_millis(10)),
        }
    }
    panic!("the window does not answer")
}

/// Returns the text on the clipboard.
pub fn clipboard(display: &str) -> String {
    let (connection, root) = connect(display);
    let atom = |name: &str| atom(&connection, name);
    let asking = window(&connection, root, [1, 1]);
    let (text, property) = (atom("UTF8_STRING"), atom("MSD_PASTED"));
    let time = x11rb::CURRENT_TIME;
    let asked = connection.convert_selection(asking, atom("CLIPBOARD"), text, property, time);
    asked.expect("the display").check().expect("a selection");
    wait(&connection, |event| match event {
        Event::SelectionNotify(told) => Some(told),
        _ => None,
    });
    let read = connection.get_property(true, asking, property, AtomEnum::ANY, 0, 1 << 16);
    let read = read.expect("the display").reply().expect("what was copied");
    String::from_utf8(read.value).expect("UTF-8")
}

/// A window over the whole screen, until it is dropped.
pub struct Cover {
    _connection: RustConnection,
}

impl Cover {
    pub fn over(display: &str) -> Self {
        let (connection, root) = connect(display);
        let screen = connection.get_geometry(root).expect("the display").reply().expect("a size");
        let window = window(&connection, root, [screen.width, screen.height]);
        connection.map_window(window).expect("the display").check().expect("a window");
        Cover { _connection: connection }
    }
}

/// The program of a desktop that publishes the pixel density (XSETTINGS).
pub struct Desktop {
    connection: RustConnection,
    window: Window,
}

impl Desktop {
    /// Starts before the program that reads the setting.
    pub fn over(display: &str) -> Self {
        let (connection, root) = connect(display);
        let window = window(&connection, root, [1, 1]);
        let desktop = Desktop { connection, window };
        desktop.scale(1.0);
        let selection = atom(&desktop.connection, "_XSETTINGS_S0");
        let owned = desktop.connection.set_selection_owner(window, selection, x11rb::CURRENT_TIME);
        owned.expect("the display").check().expect("a selection");
        desktop
    }

    /// Sets the pixels per point.
    pub fn scale(&self, factor: f64) {
        let settings = atom(&self.connection, "_XSETTINGS_SETTINGS");
        // In the byte order of this machine: a serial number, one setting, which is a number.
        let order = u32::from(cfg!(target_endian = "big")).to_le_bytes();
        let name = b"Xft/DPI\0";
        let kind = [&[0, 0][..], &7u16.to_ne_bytes()].concat();
        let value = (96.0 * 1024.0 * factor) as i32;
        let [serial, count, changed] = [1u32, 1, 1].map(u32::to_ne_bytes);
        let parts = [&order[..], &serial, &count, &kind, name, &changed, &value.to_ne_bytes()];
        let data = parts.concat();
        let put = self.connection.change_property8(
            PropMode::REPLACE,
            self.window,
            settings,
            settings,
            &data,
        );
        put.expect("the display").check().expect("a property");
    }
}

/// A screenshot.
pub struct Picture {
    width: usize,
    bytes: Vec<u8>,
}

impl Picture {
    /// Returns blue, green and red of a pixel.
    pub fn pixel(&self, [x, y]: [usize; 2]) -> &[u8] {
        let start = 4 * (y * self.width + x);
        &self.bytes[start..start + 3]
    }
}

pub fn picture(display: &str) -> Picture {
    let (connection, root) = connect(display);
    let screen = connection.get_geometry(root).expect("the display").reply().expect("a size");
    let [width, height] = [screen.width, screen.height];
    let asked = connection.get_image(ImageFormat::Z_PIXMAP, root, 0, 0, width, height, !0);
    let image = asked.expect("the display").reply().expect("a picture");
    Picture { width: width.into(), bytes: image.data }
}
