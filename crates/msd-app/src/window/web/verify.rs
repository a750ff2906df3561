//! The check of equal bits in the page: see [`Verification`].

use msd_run::kept::Verification;
use std::time::Duration;
use wasm_bindgen::prelude::wasm_bindgen;
use web_time::Instant;

/// Computes the kept hashes in the page, in slices of time.
#[wasm_bindgen]
#[derive(Default)]
pub struct Verifier {
    verification: Verification,
}

#[wasm_bindgen]
impl Verifier {
    /// Begins.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::new_without_default, reason = "a page has no trait")]
    pub fn new() -> Self {
        Verifier::default()
    }

    /// Goes on for some milliseconds, and says how far it is.
    pub fn slice(&mut self, milliseconds: u32) -> String {
        let start = Instant::now();
        let most = Duration::from_millis(milliseconds.into());
        self.verification.go_on(|| most <= start.elapsed());
        let (done, all) = self.verification.progress();
        let wrong = self.verification.wrong();
        match (self.verification.is_done(), wrong) {
            (false, _) => format!("{done} of {all} runs verified"),
            (true, []) => format!("all {all} runs end in the bits that are kept"),
            (true, _) => {
                format!("{} of {all} runs end in other bits:\n{}", wrong.len(), wrong.join("\n"))
            }
        }
    }

    /// Whether all is done.
    #[wasm_bindgen(getter)]
    pub fn is_done(&self) -> bool {
        self.verification.is_done()
    }
}
