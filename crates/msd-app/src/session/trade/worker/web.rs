//! A web worker: a second instance of the program beside the page, with messages in bytes.

use super::{BROKEN, Report, Task};
use js_sys::{Array, Uint8Array};
use msd_study::choice::Choice;
use msd_study::monitor::{Halt, Monitor, Progress};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::{Closure, JsValue};
use web_sys::{MessageEvent, WorkerOptions, WorkerType};

/// Use of the machine by a worker, in words.
pub const MANNERS: &str = "At most half a core on average; pauses after the measurement in \
                           progress. After a pause, a search or the measurement of the model \
                           terms restarts";

/// A message from the worker to the page.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Note {
    Progress(Progress),
    /// The result, in bytes.
    Found(Vec<u8>),
    /// No work is left.
    Idle,
    Failed(String),
}

/// A message from the page to the worker.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Order {
    Wish(Choice),
    Pause(bool),
}

/// The page's handle: reads the results. Its drop cancels the work.
#[derive(Debug)]
pub(crate) struct PageWorker<T> {
    report: Rc<RefCell<Report<T>>>,
    /// Name of the task and the task itself, for the worker.
    task: (&'static str, Vec<u8>),
    in_pieces: bool,
    state: RefCell<State>,
}

/// Messages sent to the worker.
#[derive(Debug, Default)]
struct State {
    /// `None` before the start, and after the end.
    beside: Option<Beside>,
    paused: bool,
    wish: Option<Choice>,
}

impl<T: DeserializeOwned + 'static> PageWorker<T> {
    /// Prepares to work; [`PageWorker::set_paused`] starts the worker.
    pub(crate) fn start<W: Task<Found = T> + Serialize>(work: W) -> Self {
        let bytes = postcard::to_stdvec(&work);
        let failure = bytes.as_ref().err().map(ToString::to_string);
        let report = Report { idle: failure.is_some(), failure, ..Report::default() };
        PageWorker {
            report: Rc::new(RefCell::new(report)),
            task: (W::NAME, bytes.unwrap_or_default()),
            in_pieces: W::IN_PIECES,
            state: RefCell::default(),
        }
    }

    /// Returns the current report.
    pub(crate) fn report(&self) -> Report<T> {
        self.report.borrow().clone()
    }

    /// Pauses or resumes the work.
    pub(crate) fn set_paused(&self, paused: bool) {
        let mut state = self.state.borrow_mut();
        let is_over = self.report.borrow().idle && !self.in_pieces;
        if is_over {
            state.beside = None;
        } else if paused && !self.in_pieces {
            state.beside = None;
            self.report.borrow_mut().progress = None;
        } else if let Some(beside) = state.beside.as_ref().filter(|_| paused != state.paused) {
            beside.post(&Order::Pause(paused));
        } else if !paused && state.beside.is_none() && self.report.borrow().failure.is_none() {
            state.beside = Beside::start(self.task.0, &self.task.1, self.report.clone());
        }
        state.paused = paused;
    }

    /// Requests a trial of a choice as the next one.
    pub(crate) fn wish(&self, choice: Choice) {
        let mut state = self.state.borrow_mut();
        let State { beside: Some(beside), wish, .. } = &mut *state else { return };
        if *wish != Some(choice) {
            *wish = Some(choice);
            self.report.borrow_mut().idle = false;
            beside.post(&Order::Wish(choice));
        }
    }
}

/// A web worker that this handle terminates on drop.
#[derive(Debug)]
struct Beside {
    worker: web_sys::Worker,
    _hear: Closure<dyn FnMut(MessageEvent)>,
    _fail: Closure<dyn FnMut(JsValue)>,
}

impl Beside {
    /// Starts a worker, or reports why that failed.
    fn start<T: DeserializeOwned + 'static>(
        name: &str,
        task: &[u8],
        report: Rc<RefCell<Report<T>>>,
    ) -> Option<Self> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let Ok(worker) = web_sys::Worker::new_with_options("study.js", &options) else {
            fail(&mut report.borrow_mut(), "this browser blocks web workers");
            return None;
        };
        let failed = report.clone();
        let hear = Closure::new(move |event: MessageEvent| {
            take(&mut report.borrow_mut(), &Uint8Array::new(&event.data()).to_vec());
        });
        let fail = Closure::new(move |_: JsValue| fail(&mut failed.borrow_mut(), BROKEN));
        worker.set_onmessage(Some(hear.as_ref().unchecked_ref()));
        worker.set_onerror(Some(JsCast::unchecked_ref(fail.as_ref())));
        let start = Array::of3(&wasm_bindgen::module(), &name.into(), &Uint8Array::from(task));
        // It throws only if an object cannot be sent, which does not apply to these.
        worker.post_message(&start).ok();
        Some(Beside { worker, _hear: hear, _fail: fail })
    }

    fn post(&self, order: &Order) {
        let bytes = postcard::to_stdvec(order).unwrap_or_default();
        self.worker.post_message(&Uint8Array::from(&bytes[..])).ok();
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // No late message may call a dropped closure.
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
        self.worker.terminate();
    }
}

fn take<T: DeserializeOwned>(report: &mut Report<T>, note: &[u8]) {
    match postcard::from_bytes(note) {
        Ok(Note::Progress(progress)) => report.progress = Some(progress),
        Ok(Note::Found(found)) => match postcard::from_bytes(&found) {
            Ok(found) => report.found = Some(Arc::new(found)),
            Err(_) => fail(report, BROKEN),
        },
        Ok(Note::Idle) => report.idle = true,
        Ok(Note::Failed(why)) => fail(report, &why),
        Err(_) => fail(report, BROKEN),
    }
}

fn fail<T>(report: &mut Report<T>, why: &str) {
    (report.idle, report.failure) = (true, Some(why.to_owned()));
}

/// Function that works on the next piece of a task, with its result in bytes.
pub(crate) type Drive =
    Box<dyn FnMut(Option<Choice>, &mut dyn Monitor) -> Result<Option<Vec<u8>>, Halt>>;

/// Decodes a task from the page.
pub(crate) fn drive<W>(task: &[u8]) -> Option<Drive>
where
    W: Task<Found: Serialize> + DeserializeOwned,
{
    let mut task: W = postcard::from_bytes(task).ok()?;
    Some(Box::new(move |choice, monitor| {
        let found = task.advance(choice, monitor)?;
        Ok(found.map(|found| postcard::to_stdvec(&found).unwrap_or_default()))
    }))
}
