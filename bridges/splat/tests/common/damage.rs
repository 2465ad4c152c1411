//! Random damage to files, each from a number of its own, so that what fails can be done again.
//!
//! `COSPLAT_FUZZ_SEED=N` tries the damage of that number alone, `COSPLAT_FUZZ_SECONDS=N` goes on for that long.

use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// Longest time that a reader may take over a small file, and how often it is tried when the machine may have been busy.
const LIMIT: Duration = Duration::from_secs(1);
const TRIES: usize = 3;

/// Random numbers that are the same everywhere (Steele et al. 2014, `SplitMix64`).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Damages good files by each of these numbers and gives them to `read`, which says whether there was no error. Files are
/// given in turn, as ending and bytes.
pub(crate) fn fuzz(files: &[(&'static str, Vec<u8>)], numbers: Range<u64>, read: impl Fn(&str, &[u8]) -> bool) {
    let number = |name: &str| std::env::var(name).ok().and_then(|value| value.parse::<u64>().ok());
    if let Some(seed) = number("COSPLAT_FUZZ_SEED") {
        let (ending, bytes) = damaged(files, seed);
        let fine = read(ending, &bytes);
        return println!(
            "number {seed}: a `.{ending}` of {} bytes, {}",
            bytes.len(),
            if fine { "read" } else { "refused" }
        );
    }
    let (start, seconds) = (Instant::now(), number("COSPLAT_FUZZ_SECONDS").unwrap_or(0));
    let mut done: BTreeMap<&str, [u64; 2]> = BTreeMap::new();
    let mut seed = numbers.start;
    while seed < numbers.end || start.elapsed() < Duration::from_secs(seconds) {
        let (ending, bytes) = damaged(files, seed);
        let again = || format!("`.{ending}` of {} bytes; COSPLAT_FUZZ_SEED={seed} does it again", bytes.len());
        let timed = || {
            let start = Instant::now();
            let Ok(fine) = catch_unwind(AssertUnwindSafe(|| read(ending, &bytes))) else { panic!("a {}", again()) };
            (start.elapsed(), fine)
        };
        let (time, fine) = timed();
        assert!(time < LIMIT || (1..TRIES).any(|_| timed().0 < LIMIT), "{time:?} for a {}", again());
        let [tried, read] = done.entry(ending).or_default();
        (*tried, *read) = (*tried + 1, *read + u64::from(fine));
        seed += 1;
    }
    println!(
        "{} damaged files in {:.1} s (tried, still read): {done:?}",
        seed - numbers.start,
        start.elapsed().as_secs_f64()
    );
}

/// The damage of that number.
fn damaged(files: &[(&'static str, Vec<u8>)], seed: u64) -> (&'static str, Vec<u8>) {
    let mut random = Random(seed);
    let (ending, bytes) = &files[(seed % files.len() as u64) as usize];
    let mut bytes = bytes.clone();
    // Mostly one or two: much damage is refused at once.
    for _ in 0..=random.below(4).min(random.below(6)) {
        let other = &files[random.below(files.len())].1;
        damage(&mut bytes, other, &mut random);
    }
    (ending, bytes)
}

/// One change: a byte, a number, a digit, a piece cut, doubled, moved or taken from another file, or the end gone.
fn damage(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    // Damage near the beginning, where the headers are, is tried as often as all the rest.
    let reach = if random.below(2) == 0 { bytes.len() } else { bytes.len().min(256) };
    let at = random.below(reach);
    let length = random.below(64).min(bytes.len() - at);
    match random.below(9) {
        0 => bytes[at] = random.next() as u8,
        1 => bytes[at] ^= 1 << random.below(8),
        2 => {
            let extremes = [0, 1, 0x7fff_ffff, 0x8000_0000, u64::from(u32::MAX), u64::MAX, 0x7fc0_0000, 0x7f80_0000];
            let (value, width) = (extremes[random.below(8)], [2, 4, 8][random.below(3)].min(bytes.len() - at));
            bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
        }
        3 => drop(bytes.drain(at..at + length)),
        4 => {
            let piece = bytes[at..at + length].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, piece);
        }
        5 => {
            let to = random.below(bytes.len() - length + 1);
            bytes.copy_within(at..at + length, to);
        }
        6 => {
            // A number written in digits: counts of texts, of headers and of JSON.
            let Some(from) = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit()) else { return };
            let digits = bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
            let words = ["0", "1", "-1", "255", "4294967295", "18446744073709551615", "1e30", "nan", ""];
            bytes.splice(from..from + digits, words[random.below(words.len())].bytes());
        }
        7 => {
            let from = random.below(other.len());
            let piece = &other[from..other.len().min(from + length)];
            bytes.splice(at..at + length, piece.iter().copied());
        }
        _ => bytes.truncate(at),
    }
}
