//! The thread that writes the log: takes messages from the queue, writes them, flushes at regular intervals of the wall clock.
//!
//! It flushes also while no message arrives, so that a message is in the file at most [`FLUSH_EVERY`] and one write after it was
//! taken from the queue. The thread ends when the sender is dropped and the queue is empty; the log is then closed.

use super::mcap_log::{LogSummary, McapLog};
use crate::io::outputs::queue::{QueueReceived, QueueReceiver};
use std::io;
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// The longest that a message stays out of the file while the thread keeps up.
pub const FLUSH_EVERY: Duration = Duration::from_millis(80);

/// The running thread.
#[derive(Debug)]
pub struct LogThread {
    handle: JoinHandle<LogSummary>,
}

impl LogThread {
    /// Starts the thread on an open log.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn spawn(receiver: QueueReceiver, log: McapLog) -> io::Result<Self> {
        let handle = Builder::new().name("sideslip-log".to_owned()).spawn(move || write_until_closed(&receiver, log))?;
        Ok(LogThread { handle })
    }

    /// Waits until everything sent is written and the log is closed. Drop the sender first.
    ///
    /// # Errors
    /// Where the thread died; the log then ends at its last flush.
    pub fn join(self) -> io::Result<LogSummary> {
        self.handle.join().map_err(|_| io::Error::other("the thread that writes the log died"))
    }
}

fn write_until_closed(receiver: &QueueReceiver, mut log: McapLog) -> LogSummary {
    let mut next_flush = Instant::now() + FLUSH_EVERY;
    loop {
        let wait = next_flush.saturating_duration_since(Instant::now());
        match receiver.receive(wait) {
            QueueReceived::Entry(entry) => {
                log.entry(&entry);
                receiver.recycle(entry);
            }
            QueueReceived::Nothing => {}
            QueueReceived::Closed => return log.close(),
        }
        let now = Instant::now();
        if now >= next_flush {
            log.flush();
            next_flush = now + FLUSH_EVERY;
        }
    }
}
