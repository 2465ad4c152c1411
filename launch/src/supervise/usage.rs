//! Processor time and memory of a process, from `/proc`.
//!
//! The standard library reaps a process without its resource usage, so this reads the same numbers where the system
//! shows them: processor time from `stat`, which a finished process keeps until it is reaped, and the largest resident
//! memory from `status`, which is gone then and is sampled while the process runs. Elsewhere than on Linux there is
//! nothing to read and nothing is reported.

use std::fs;

/// What a process has used so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Usage {
    /// Processor time, user and system, with that of its finished children \[s\].
    pub(crate) cpu_s: Option<f64>,
    /// Largest resident memory \[MiB\].
    pub(crate) peak_rss_mib: Option<f64>,
}

impl Usage {
    /// Reads what can be read now and keeps the rest.
    pub(crate) fn sample(&mut self, pid: u32) {
        self.cpu_s = cpu_s(pid).or(self.cpu_s);
        self.peak_rss_mib = peak_rss_mib(pid).or(self.peak_rss_mib);
    }
}

fn cpu_s(pid: u32) -> Option<f64> {
    let ticks = cpu_ticks(&fs::read_to_string(format!("/proc/{pid}/stat")).ok()?)?;
    Some(ticks as f64 / rustix::param::clock_ticks_per_second() as f64)
}

/// `utime + stime + cutime + cstime`, fields 14 to 17 of `proc_pid_stat(5)`. The second field, a name in parentheses, may
/// hold anything, so the count starts behind its last parenthesis.
fn cpu_ticks(stat: &str) -> Option<u64> {
    let (_, fields) = stat.rsplit_once(')')?;
    let times: Vec<u64> = fields.split_whitespace().skip(11).take(4).map_while(|f| f.parse().ok()).collect();
    (times.len() == 4).then(|| times.iter().sum())
}

fn peak_rss_mib(pid: u32) -> Option<f64> {
    high_water_kib(&fs::read_to_string(format!("/proc/{pid}/status")).ok()?).map(|kib| kib as f64 / 1024.0)
}

fn high_water_kib(status: &str) -> Option<u64> {
    status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_parentheses_and_spaces_does_not_shift_the_fields() {
        let stat = "42 (a ) b) S 1 42 42 0 -1 4194560 100 200 0 0 11 7 3 2 20 0 4 0 100 1000 10 18446744073709551615";
        assert_eq!(cpu_ticks(stat), Some(23));
        assert_eq!(cpu_ticks("42 (x) S 1"), None);
    }

    #[test]
    fn the_high_water_mark_is_found() {
        assert_eq!(high_water_kib("VmPeak:\t  200 kB\nVmHWM:\t    1234 kB\nVmRSS:\t 1 kB\n"), Some(1234));
        assert_eq!(high_water_kib("Name:\tx\n"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_uses_something() {
        let mut usage = Usage::default();
        usage.sample(std::process::id());
        assert!(usage.cpu_s.is_some() && usage.peak_rss_mib.is_some_and(|m| m > 1.0), "{usage:?}");
    }
}
