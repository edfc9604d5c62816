//! The fuzz targets: for every parser of outside bytes a function that reads any bytes and fails where a promise is broken.
//!
//! In: bytes. Out: how many things were read in them, or a panic that says which promise is broken. Promised of each: no panic,
//! an end; what is handed out is no more than the bytes can hold ([`Steps`]); memory within a bound that grows with the bytes
//! ([`Target::run`]); the same result however the bytes are cut into pieces, where a parser takes pieces; and read again the same
//! after it was written, where there is an encoder. The replay of the corpus and the long runs (`libfuzzer.rs`) call the same
//! functions.

mod chapter10;
mod chapter10_rows;
mod csv;
mod dataflash;
mod documents;
mod mavlink;
mod mcap;
pub(crate) mod pcm;
mod temporary;
mod ulog;

use crate::support::allocations::most_bytes_during;

/// One parser.
pub(crate) struct Target {
    /// Name, and that of its folder in the corpus.
    pub(crate) name: &'static str,
    read: fn(&[u8]) -> usize,
    /// Bytes of memory that it may take whatever it reads, and for each byte read.
    memory: (u64, u64),
}

const MB: u64 = 1 << 20;

/// Every parser of outside bytes.
pub(crate) const TARGETS: [Target; 13] = [
    // A setup is a format of PCM too, see there.
    Target { name: "chapter10", read: chapter10::recording, memory: (128 * MB, 400) },
    Target { name: "csv", read: csv::run_file, memory: (MB, 400) },
    Target { name: "dataflash", read: dataflash::log, memory: (2 * MB, 400) },
    Target { name: "instruments", read: documents::instruments, memory: (MB, 400) },
    Target { name: "mavlink", read: mavlink::stream, memory: (4 * MB, 400) },
    Target { name: "mavlink_config", read: documents::mavlink_config, memory: (MB, 400) },
    // A chunk grows to 255 times its length, and holds a sample in every 31 bytes.
    Target { name: "mcap", read: mcap::log, memory: (16 * MB, 4000) },
    Target { name: "model", read: documents::model, memory: (MB, 400) },
    // A line of text may place a parameter in 4096 words: the limits of a format bound what that takes.
    Target { name: "pcm_format", read: pcm::format_file, memory: (128 * MB, 400) },
    Target { name: "pcm_stream", read: pcm::stream, memory: (MB, 400) },
    Target { name: "tmats", read: chapter10::setup, memory: (2 * MB, 400) },
    Target { name: "udp", read: chapter10::datagrams, memory: (8 * MB, 400) },
    // All layouts of a log together have a budget of their own.
    Target { name: "ulog", read: ulog::log, memory: (32 * MB, 400) },
];

impl Target {
    /// The target of that name.
    #[allow(dead_code, reason = "the binaries of libFuzzer ask for it")]
    pub(crate) fn named(name: &str) -> &'static Target {
        let found = TARGETS.iter().find(|target| target.name == name);
        found.unwrap_or_else(|| panic!("no target is called {name}"))
    }

    /// Reads the bytes.
    pub(crate) fn run(&self, bytes: &[u8]) -> Reading {
        let mut things = 0;
        let held = most_bytes_during(|| things = (self.read)(bytes));
        let (fixed, each) = self.memory;
        let allowed = fixed + each * bytes.len() as u64;
        assert!(held <= allowed, "{}: {held} bytes held for {} bytes read, {allowed} allowed", self.name, bytes.len());
        Reading { things, held }
    }
}

/// What became of an input.
pub(crate) struct Reading {
    /// Things that were read: messages, samples, packets, documents; 0 where all was refused.
    #[allow(dead_code, reason = "libFuzzer does not ask")]
    pub(crate) things: usize,
    /// The most memory that was held, bytes.
    pub(crate) held: u64,
}

/// Counts what is handed out: of so many bytes at most so much can come.
struct Steps {
    left: u64,
}

impl Steps {
    /// At most `each` for every byte, and a few for none.
    fn of(bytes: &[u8], each: u64) -> Self {
        Steps { left: 16 + each * bytes.len() as u64 }
    }

    fn one(&mut self) {
        self.left = self.left.checked_sub(1).expect("more was handed out than the bytes can hold");
    }
}

/// The bytes in pieces of unequal lengths up to some 100, which depend on the bytes alone.
fn pieces(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let length = 1 + (rest.len() * 31 + usize::from(*rest.first()?)) % 101;
        let (piece, after) = rest.split_at(length.min(rest.len()));
        rest = after;
        Some(piece)
    })
}

/// Bits of numbers in order, for comparisons; every NaN is the same.
fn bits(numbers: impl IntoIterator<Item = f64>) -> Vec<u64> {
    numbers.into_iter().map(|number| if number.is_nan() { u64::MAX } else { number.to_bits() }).collect()
}
