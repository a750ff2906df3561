//! The worker's side of work beside the page: see `session/trade/worker/web.rs`.

use crate::session::{
    Hand, Labour, RetryTask, SearchTask, SoundnessTask, StudyTask, Task, TermsTask,
};
use js_sys::Function;
use wasm_bindgen::prelude::wasm_bindgen;

/// Work of a worker, which hears orders between its pieces.
#[wasm_bindgen]
pub struct BackgroundWork {
    hand: Box<dyn Hand>,
}

#[wasm_bindgen]
impl BackgroundWork {
    /// Takes up work that the page sent, by its kind; `page` is called with what came of it.
    ///
    /// # Errors
    /// A line, where the page is another version of the program.
    #[wasm_bindgen(constructor)]
    pub fn new(kind: &str, task: &[u8], page: Function) -> Result<BackgroundWork, String> {
        let hand: Option<Box<dyn Hand>> = match kind {
            StudyTask::NAME => Labour::<StudyTask>::of(task, page).map(|work| Box::new(work) as _),
            TermsTask::NAME => Labour::<TermsTask>::of(task, page).map(|work| Box::new(work) as _),
            SearchTask::NAME => {
                Labour::<SearchTask>::of(task, page).map(|work| Box::new(work) as _)
            }
            RetryTask::NAME => Labour::<RetryTask>::of(task, page).map(|work| Box::new(work) as _),
            SoundnessTask::NAME => {
                Labour::<SoundnessTask>::of(task, page).map(|work| Box::new(work) as _)
            }
            _ => None,
        };
        let hand = hand.ok_or("the page and its worker are of two versions")?;
        Ok(BackgroundWork { hand })
    }

    /// Does the next piece; whether there is more to do.
    pub fn advance(&mut self) -> bool {
        self.hand.advance()
    }

    /// Follows an order of the page.
    pub fn hear(&mut self, order: &[u8]) {
        self.hand.hear(order);
    }
}
