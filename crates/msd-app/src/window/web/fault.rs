//! Reports of panics, which the page explains to the user.

use js_sys::{Error, Function, Reflect, global};
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsCast, JsValue};

/// Reports each panic as an uncaught error, in the page and in its workers: the trap that follows
/// has no message but "unreachable".
pub fn report_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let error = Error::new(&panic.to_string());
        // If a browser lacks this function, the page gets only the error that follows.
        let report = Reflect::get(&global(), &"reportError".into());
        let report = report.ok().and_then(|report| report.dyn_into::<Function>().ok());
        report.map(|report| report.call1(&JsValue::NULL, &error).ok());
    }));
}

/// Panics, for tests.
#[wasm_bindgen]
pub fn fail() {
    panic!("a test has asked for it");
}
