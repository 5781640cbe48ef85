//! What the operating system grants a loop: a real-time priority, locked memory, and processors that stay awake.

#![allow(unsafe_code, reason = "no safe crate here sets the real-time priority")]

use std::fs::{File, OpenOptions};
use std::io::Write;

use rustix::mm::{MlockAllFlags, mlockall};

/// What was granted, for as long as this value lives.
#[derive(Debug)]
pub struct Privileges {
    /// The priority of the first-in-first-out schedule, 1 to 99; `Err` with the error of the operating system if it was
    /// refused; `None` if it was not asked for.
    pub priority: Option<Result<i32, i32>>,
    /// Whether the memory is locked, as above.
    pub locked_memory: Option<Result<(), i32>>,
    /// The file that keeps the processors awake while it is open, as above.
    pub awake: Option<Result<File, i32>>,
}

/// Keeps the processors out of deep sleep, from which they wake late, as long as the result lives. It costs power, and usually
/// only root may.
fn keep_awake() -> std::io::Result<File> {
    let mut file = OpenOptions::new().write(true).open("/dev/cpu_dma_latency")?;
    // the longest wake-up that is tolerated, µs
    file.write_all(&0_i32.to_ne_bytes())?;
    Ok(file)
}

/// Asks for a real-time priority for this thread, for all memory that the program has now to stay in place, and for processors
/// that stay out of deep sleep. Call it on the loop's thread when all is allocated. What is refused is said, and the loop runs
/// without it.
pub fn claim(priority: Option<i32>, lock_memory: bool, stay_awake: bool) -> Privileges {
    Privileges {
        priority: priority.map(set_priority),
        // what is mapped later is not locked: a limit on it would make that fail
        locked_memory: lock_memory
            .then(|| mlockall(MlockAllFlags::CURRENT).map_err(|error| error.raw_os_error())),
        awake: stay_awake.then(|| keep_awake().map_err(|error| error.raw_os_error().unwrap_or(0))),
    }
}

fn set_priority(priority: i32) -> Result<i32, i32> {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: 0 is the calling thread, and the parameters outlive the call, which only reads them.
    let outcome = unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) };
    if outcome == 0 {
        return Ok(priority);
    }
    Err(std::io::Error::last_os_error().raw_os_error().unwrap_or(0))
}
