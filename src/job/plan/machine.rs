//! How much memory the machine has, and this process has taken.

/// The budget where none is given: a quarter of what the machine or its control group has, at most 2 GiB.
pub fn default_budget() -> u64 {
    const MOST: u64 = 2 << 30;
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find_map(|l| l.strip_prefix("MemTotal:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
    });
    // Version 2, then version 1; "max", or a number near 2⁶³, is no limit.
    let group = cgroup_files().into_iter().filter_map(|path| read(&path)?.trim().parse::<u64>().ok()).min();
    machine.into_iter().chain(group).min().map_or(MOST, |bytes| (bytes / 4).min(MOST))
}

/// Where the memory limits of this process's control groups stand, inside a container and outside.
fn cgroup_files() -> Vec<String> {
    let mut files =
        vec!["/sys/fs/cgroup/memory.max".to_string(), "/sys/fs/cgroup/memory/memory.limit_in_bytes".to_string()];
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        if let (Some(controllers), Some(path)) = (parts.next(), parts.next()) {
            match controllers {
                "" => files.push(format!("/sys/fs/cgroup{path}/memory.max")),
                c if c.split(',').any(|c| c == "memory") => {
                    files.push(format!("/sys/fs/cgroup/memory{path}/memory.limit_in_bytes"));
                }
                _ => {}
            }
        }
    }
    files
}

/// As many threads as the machine has cores, or this process may use of them.
pub(crate) fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The most memory that this process has held so far, where the system says so.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
}
