//! What work takes, for examples that measure.

/// What the main thread has been running for, in seconds (Linux): a busy machine disturbs it less than the time of day.
pub(crate) fn cpu_seconds() -> Result<f64, Box<dyn std::error::Error>> {
    let stat = std::fs::read_to_string("/proc/self/schedstat")?;
    let nanoseconds: f64 = stat.split_whitespace().next().unwrap_or_default().parse()?;
    Ok(nanoseconds * 1e-9)
}
