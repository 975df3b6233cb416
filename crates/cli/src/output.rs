//! Standard output and standard error.

use std::io::Write;

/// Writes a result. A reader that went away (`| head`) is no reason to fail, nor to panic.
pub(crate) fn result(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Writes progress or an error.
pub(crate) fn error(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}
