//! The check of bit-reproducibility in the page: see [`Verification`].

use msd_run::kept::Verification;
use std::time::Duration;
use wasm_bindgen::prelude::wasm_bindgen;
use web_time::Instant;

/// Computes the hashes of the reference runs in the page, in time slices.
#[wasm_bindgen]
#[derive(Default)]
pub struct Verifier {
    verification: Verification,
}

#[wasm_bindgen]
impl Verifier {
    /// Begins the check.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::new_without_default, reason = "a page has no trait")]
    pub fn new() -> Self {
        Verifier::default()
    }

    /// Continues for some milliseconds, and describes the progress.
    pub fn slice(&mut self, milliseconds: u32) -> String {
        let start = Instant::now();
        let most = Duration::from_millis(milliseconds.into());
        self.verification.go_on(|| most <= start.elapsed());
        let (done, all) = self.verification.progress();
        let wrong = self.verification.wrong();
        match (self.verification.is_done(), wrong) {
            (false, _) => format!("{done} of {all} runs verified"),
            (true, []) => format!("all {all} runs match the reference bits"),
            (true, _) => {
                format!("{} of {all} runs do not match:\n{}", wrong.len(), wrong.join("\n"))
            }
        }
    }

    /// Returns whether all runs are checked.
    #[wasm_bindgen(getter)]
    pub fn is_done(&self) -> bool {
        self.verification.is_done()
    }
}
