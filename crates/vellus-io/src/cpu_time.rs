//! Processor time.

/// Processor time of all threads since the program began; `None` if the system does not report it.
pub fn cpu_time() -> Option<std::time::Duration> {
    #[cfg(unix)]
    return rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime).try_into().ok();
    #[cfg(not(unix))]
    None
}
