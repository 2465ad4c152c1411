//! The system's monotonic clock, whose zero all processes of a machine share.

/// Seconds on `CLOCK_MONOTONIC`. `std::time::Instant` reads the same clock but keeps the number to itself.
pub(crate) fn monotonic_s() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}
