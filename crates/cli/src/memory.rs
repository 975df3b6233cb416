//! Peak memory of this process, where the system tells it (Linux).

/// Largest resident memory since the start or the last [`reset`] [MiB]; `None` where the system does not say.
pub(crate) fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes / 1024.0)
}

/// Lets the peak start again from what is in use now; without effect where the system cannot.
pub(crate) fn reset() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
