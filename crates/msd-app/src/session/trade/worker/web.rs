//! A worker of the page: the same program once more, beside the page, told and telling in bytes.

use super::{BROKEN, LATE, Report, Task};
use js_sys::{Array, Function, Uint8Array};
use msd_study::choice::Choice;
use msd_study::conduct::Progress;
use msd_study::leave::Halt;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::marker::PhantomData;
use std::rc::Rc;
use std::sync::Arc;
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::{Closure, JsValue};
use web_sys::{MessageEvent, WorkerOptions, WorkerType};

/// What a worker takes of the machine, in words.
pub const MANNERS: &str = "It takes at most half of one core on average; it rests when the setting \
                           at hand is measured, while a search or the prices of the parts begin \
                           anew after a rest";

/// What the worker tells the page.
#[derive(Debug, Serialize, Deserialize)]
enum Note<T> {
    Progress(Progress),
    Found(T),
    /// Nothing is left to do.
    Idle,
    Failed(String),
}

/// What the page tells the worker.
#[derive(Debug, Serialize, Deserialize)]
enum Order {
    Wish(Choice),
    Pause(bool),
}

/// The page's end: reads what was found. When it is dropped the work ends.
#[derive(Debug)]
pub(crate) struct PageWorker<T> {
    report: Rc<RefCell<Report<T>>>,
    /// What the worker knows the work by, and the work itself.
    task: (&'static str, Vec<u8>),
    in_pieces: bool,
    state: RefCell<State>,
}

/// What the worker was told.
#[derive(Debug, Default)]
struct State {
    /// Nothing before it is to work, and after all is done.
    beside: Option<Beside>,
    paused: bool,
    wish: Option<Choice>,
}

impl<T: DeserializeOwned + 'static> PageWorker<T> {
    /// Prepares to work, once it is known not to be paused.
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

    /// What there is to show.
    pub(crate) fn report(&self) -> Report<T> {
        self.report.borrow().clone()
    }

    /// Rests or goes on.
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

    /// Asks for a choice to be tried next.
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

/// A worker of the browser, which ends when this is dropped.
#[derive(Debug)]
struct Beside {
    worker: web_sys::Worker,
    _hear: Closure<dyn FnMut(MessageEvent)>,
    _fail: Closure<dyn FnMut(JsValue)>,
}

impl Beside {
    /// Starts a worker, or reports why there is none.
    fn start<T: DeserializeOwned + 'static>(
        name: &str,
        task: &[u8],
        report: Rc<RefCell<Report<T>>>,
    ) -> Option<Self> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let Ok(worker) = web_sys::Worker::new_with_options("study.js", &options) else {
            fail(&mut report.borrow_mut(), "the browser gives the page no worker");
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
        // It has just been started: it throws where something cannot be sent, as nothing here.
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
        // No late message meets a closure that is gone.
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
        self.worker.terminate();
    }
}

fn take<T: DeserializeOwned>(report: &mut Report<T>, note: &[u8]) {
    match postcard::from_bytes(note) {
        Ok(Note::Progress(progress)) => report.progress = Some(progress),
        Ok(Note::Found(found)) => report.found = Some(Arc::new(found)),
        Ok(Note::Idle) => report.idle = true,
        Ok(Note::Failed(why)) => fail(report, &why),
        Err(_) => fail(report, BROKEN),
    }
}

fn fail<T>(report: &mut Report<T>, why: &str) {
    (report.idle, report.failure) = (true, Some(why.to_owned()));
}

/// The worker's end, by which a piece of work tells the page.
#[derive(Debug)]
pub(crate) struct PageJob<T> {
    page: Function,
    wish: Option<Choice>,
    found: PhantomData<fn(T)>,
}

impl<T> PageJob<T> {
    fn note(&self, note: &Note<T>)
    where
        T: Serialize,
    {
        let bytes = postcard::to_stdvec(note).unwrap_or_default();
        // The page reads what it is sent, or is gone.
        self.page.call1(&JsValue::NULL, &Uint8Array::from(&bytes[..])).ok();
    }

    /// Whether the result is still wanted: a worker whose result is not is no more.
    pub(crate) fn may_go_on(&mut self) -> bool {
        true
    }

    /// Shows what was found.
    pub(crate) fn show(&self, found: T)
    where
        T: Serialize,
    {
        self.note(&Note::Found(found));
    }

    /// Tells how far it is.
    pub(super) fn tell(&self, progress: Progress)
    where
        T: Serialize,
    {
        self.note(&Note::Progress(progress));
    }

    /// A choice to be tried next; it comes between two pieces.
    pub(crate) fn wished(&mut self, _: bool) -> Option<Choice> {
        self.wish.take()
    }
}

/// Work as the worker does it: between two pieces it hears orders.
pub(crate) struct Labour<W: Task> {
    work: W,
    job: PageJob<W::Found>,
    paused: bool,
}

impl<W: Task + DeserializeOwned> Labour<W> {
    /// Takes up work that the page sent; `page` hears what came of it.
    pub(crate) fn of(task: &[u8], page: Function) -> Option<Self> {
        let work = postcard::from_bytes(task).ok()?;
        let job = PageJob { page, wish: None, found: PhantomData };
        Some(Labour { work, job, paused: false })
    }
}

/// What a worker does, whatever it works at.
pub(crate) trait Hand {
    /// Does the next piece; whether there is more to do.
    fn advance(&mut self) -> bool;

    /// Follows an order of the page.
    fn hear(&mut self, order: &[u8]);
}

impl<W: Task<Found: Serialize>> Hand for Labour<W> {
    fn advance(&mut self) -> bool {
        if self.paused {
            return false;
        }
        let advanced = self.work.advance(&mut self.job);
        match advanced {
            Ok(true) => return true,
            Ok(false) | Err(Halt::Stopped) => self.job.note(&Note::Idle),
            Err(Halt::Refused(error)) => self.job.note(&Note::Failed(error.to_string())),
            Err(Halt::Late) => self.job.note(&Note::Failed(LATE.to_owned())),
        }
        false
    }

    fn hear(&mut self, order: &[u8]) {
        match postcard::from_bytes(order) {
            Ok(Order::Wish(choice)) => self.job.wish = Some(choice),
            Ok(Order::Pause(paused)) => self.paused = paused,
            // The page is the same program.
            Err(_) => {}
        }
    }
}
