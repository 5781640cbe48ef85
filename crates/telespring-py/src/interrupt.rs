//! Work that takes long: it runs on other threads while the calling one looks for signals such as Ctrl-C.
//!
//! Python handles signals on its main thread only, and only while that thread holds the interpreter. So no long
//! computation may block it. There are two forms: many short computations, which [`in_parallel`] stops one by
//! one, and one long computation, which [`apart`] leaves to its thread.

use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How long a signal may wait until it is seen.
const PATIENCE: Duration = Duration::from_millis(50);
/// The stack of a thread, as large as that of a main thread.
const STACK: usize = 8 << 20;

/// Tells the parts of a parallel computation that nobody waits for it any more.
#[derive(Debug, Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// Whether the rest of the work is superfluous.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Looks for signals now and then in a computation on the calling thread.
pub struct Watch(Instant);

impl Watch {
    /// A watch that starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Whether it is time to look for signals again.
    fn is_due(&mut self) -> bool {
        let due = self.0.elapsed() >= PATIENCE;
        if due {
            self.0 = Instant::now();
        }
        due
    }

    /// Raises the exception of a signal that came; it attaches to the interpreter only now and then.
    pub fn look(&mut self) -> PyResult<()> {
        if self.is_due() { Python::attach(|py| py.check_signals()) } else { Ok(()) }
    }

    /// The same for a thread that holds the interpreter, which other threads get in between: a function that is
    /// not written in Python neither yields nor looks for signals.
    pub fn look_and_yield(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.is_due() {
            py.detach(|| ());
            py.check_signals()?;
        }
        Ok(())
    }
}

/// Waits for the result of a thread, and looks for signals meanwhile. None if the thread died.
fn wait<T>(result: &Receiver<T>) -> PyResult<Option<T>> {
    loop {
        match result.recv_timeout(PATIENCE) {
            Ok(value) => return Ok(Some(value)),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
        }
    }
}

/// Does parallel work on the threads of the pool. After a signal, `work` is told to stop, and its result is
/// dropped.
pub fn in_parallel<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> T + Send) -> PyResult<T> {
    let pool = pool()?;
    let stop = Stop::default();
    py.detach(|| {
        // the scope ends when the work has ended, which may borrow
        pool.in_place_scope(|scope| {
            let (done, result) = channel();
            let stop = &stop;
            scope.spawn(move |_| {
                // nobody receives it after a signal
                let _ = done.send(work(stop));
            });
            let waited = wait(&result);
            stop.0.store(waited.is_err(), Ordering::Relaxed);
            // a scope resumes the panic of its work
            waited.map(|value| value.ok_or_else(|| PyRuntimeError::new_err("the computation panicked")))
        })
    })?
}

/// Does one long computation on a thread of its own. After a signal nobody waits for that thread: it ends by
/// itself, and its result is dropped. So the work owns all that it uses.
pub fn apart<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    py.detach(|| {
        let (done, result) = channel();
        let worker = std::thread::Builder::new().stack_size(STACK).spawn(move || {
            // nobody receives it after a signal
            let _ = done.send(work());
        })?;
        match wait(&result)? {
            Some(value) => Ok(value),
            None => match worker.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => Err(PyRuntimeError::new_err("the computation ended without a result")),
            },
        }
    })
}

/// A pool and the process whose threads it has.
struct Owned {
    process: u32,
    pool: ThreadPool,
}

/// The threads for parallel work in this process.
///
/// A forked process has none of its parent's threads: work on the parent's pool would wait for ever there, so
/// it gets a pool of its own. Nothing is locked, as the thread that held a lock may be missing, too.
fn pool() -> PyResult<&'static ThreadPool> {
    static POOL: AtomicPtr<Owned> = AtomicPtr::new(std::ptr::null_mut());
    let process = std::process::id();
    let known = POOL.load(Ordering::Acquire);
    // SAFETY: a pointer in POOL comes from a leaked box, which nobody frees.
    if let Some(owned) = unsafe { known.as_ref() }
        && owned.process == process
    {
        return Ok(&owned.pool);
    }
    let pool = ThreadPoolBuilder::new()
        .stack_size(STACK)
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("no threads for parallel work: {error}")))?;
    let mine = Box::into_raw(Box::new(Owned { process, pool }));
    // a parent's pool is leaked: its threads cannot be joined here
    let owned = match POOL.compare_exchange(known, mine, Ordering::AcqRel, Ordering::Acquire) {
        Ok(_) => mine,
        Err(theirs) => {
            // SAFETY: `mine` was never shared.
            drop(unsafe { Box::from_raw(mine) });
            theirs
        }
    };
    // SAFETY: as above; another thread of this process put `theirs` there.
    Ok(&unsafe { &*owned }.pool)
}
