//! Processor time.

/// Processor time of all threads since the program began; `None` where the system does not tell it.
pub fn cpu_time() -> Option<std::time::Duration> {
    #[cfg(unix)]
    return rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime).try_into().ok();
    #[cfg(not(unix))]
    None
}
