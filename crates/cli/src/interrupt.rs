//! Ctrl-C: the first stops the search and keeps the best so far, the second kills.

use crate::output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a command ended by the keyboard, as shells count it (128 + SIGINT).
const KILLED: i32 = 130;

/// A flag that the first Ctrl-C sets. Where no handler can be set, Ctrl-C ends the program as usual.
pub(crate) fn flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = flag.clone();
    let _ = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(KILLED);
        }
        output::error("\nstopping with the best so far; Ctrl-C again to end at once\n");
    });
    flag
}
