//! The worker's side of background work: see `session/trade/worker/web.rs`.

use crate::session::{
    Drive, Note, Order, RetryTask, SearchTask, SoundnessTask, StudyTask, Task, TermsTask, drive,
};
use js_sys::{Function, Uint8Array};
use msd_study::choice::Choice;
use msd_study::monitor::{Halt, Progress};
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

/// Background work of a worker, which handles orders between its pieces.
#[wasm_bindgen]
pub struct BackgroundWork {
    drive: Drive,
    in_pieces: bool,
    page: Function,
    wish: Option<Choice>,
    paused: bool,
}

#[wasm_bindgen]
impl BackgroundWork {
    /// Decodes a task of the page by its kind; `page` is called with the results.
    ///
    /// # Errors
    /// A line, if the page has another version of the program.
    #[wasm_bindgen(constructor)]
    pub fn new(kind: &str, task: &[u8], page: Function) -> Result<BackgroundWork, String> {
        let drive = match kind {
            StudyTask::NAME => drive::<StudyTask>(task),
            TermsTask::NAME => drive::<TermsTask>(task),
            SearchTask::NAME => drive::<SearchTask>(task),
            RetryTask::NAME => drive::<RetryTask>(task),
            SoundnessTask::NAME => drive::<SoundnessTask>(task),
            _ => None,
        };
        let drive = drive.ok_or("the page and its worker have different versions")?;
        let in_pieces = kind == StudyTask::NAME;
        Ok(BackgroundWork { drive, in_pieces, page, wish: None, paused: false })
    }

    /// Works on the next piece; returns whether more work is left.
    pub fn advance(&mut self) -> bool {
        if self.paused {
            return false;
        }
        let page = &self.page;
        let report = &mut |progress: Progress| post(page, &Note::Progress(progress));
        match (self.drive)(self.wish.take(), report) {
            Ok(Some(found)) => {
                post(page, &Note::Found(found));
                if self.in_pieces {
                    return true;
                }
                post(page, &Note::Idle);
            }
            Ok(None) | Err(Halt::Cancelled) => post(page, &Note::Idle),
            Err(halt) => post(page, &Note::Failed(halt.to_string())),
        }
        false
    }

    /// Handles an order of the page.
    pub fn hear(&mut self, order: &[u8]) {
        match postcard::from_bytes(order) {
            Ok(Order::Wish(choice)) => self.wish = Some(choice),
            Ok(Order::Pause(paused)) => self.paused = paused,
            // Cannot fail: the page has the same program.
            Err(_) => {}
        }
    }
}

fn post(page: &Function, note: &Note) {
    let bytes = postcard::to_stdvec(note).unwrap_or_default();
    // The page reads all messages, or no longer exists.
    page.call1(&JsValue::NULL, &Uint8Array::from(&bytes[..])).ok();
}
