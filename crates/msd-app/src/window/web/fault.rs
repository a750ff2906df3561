//! Faults of the program itself, which the page puts into words.

use js_sys::{Error, Function, Reflect, global};
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsCast, JsValue};

/// Reports each panic as an error that nobody catches, in the page and in its workers: what follows
/// it says no more than that something unreachable was reached.
pub fn report_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let error = Error::new(&panic.to_string());
        // Where a browser has no such function, the page hears of what follows.
        let report = Reflect::get(&global(), &"reportError".into());
        let report = report.ok().and_then(|report| report.dyn_into::<Function>().ok());
        report.map(|report| report.call1(&JsValue::NULL, &error).ok());
    }));
}

/// Panics, as a fault of the program would: for tests.
#[wasm_bindgen]
pub fn fail() {
    panic!("a test has asked for it");
}
