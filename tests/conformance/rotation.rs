//! After a write error the log goes on in a new file and says what the error cost.

#![cfg(unix)]

use super::example::{folder, head, read, rows};
use sideslip::io::outputs::log::mcap_log::McapLog;
use std::fs::File;
use std::io::Read;
use std::process::Command;
use std::sync::{Arc, Mutex};

#[test]
fn a_write_error_is_reported_and_the_log_goes_on_elsewhere() {
    let folder = folder("rotation");
    let path = folder.join("run.mcap");
    // A pipe whose reader goes away is a disk that fails.
    if !Command::new("mkfifo").arg(&path).status().is_ok_and(|status| status.success()) {
        eprintln!("SKIPPED: no mkfifo");
        return;
    }
    let pipe = path.clone();
    let reader = std::thread::spawn(move || {
        let mut first = [0; 200];
        File::open(pipe).unwrap().read_exact(&mut first).unwrap();
        first
    });
    let reported = Arc::new(Mutex::new(Vec::new()));
    let to = Arc::clone(&reported);
    let mut log = McapLog::create(&path, head(), Box::new(move |line| to.lock().unwrap().push(line.to_owned()))).unwrap();
    assert!(reader.join().unwrap().starts_with(b"\x89MCAP0\r\n"));

    let rows = rows(60);
    std::fs::write(folder.join("run.1.mcap"), "someone else's").unwrap();
    for (k, (sample, unknown)) in rows.iter().enumerate() {
        log.sample(sample, unknown);
        if k % 10 == 9 {
            log.flush();
        }
    }
    let summary = log.close();
    let reported = reported.lock().unwrap();
    assert_eq!((reported.len(), summary.faults.len()), (1, 1), "{reported:?}");
    assert!(reported[0].contains("run.mcap: writing failed"), "{reported:?}");
    assert_eq!(summary.files, [path, folder.join("run.2.mcap")]);
    assert_eq!(std::fs::read_to_string(folder.join("run.1.mcap")).unwrap(), "someone else's");
    assert_eq!(summary.lost, 10, "one flush");
    let (found, losses) = read(File::open(&summary.files[1]).unwrap()).unwrap();
    assert!(losses.is_none(), "{losses}");
    assert_eq!(found.len(), 50);
    assert_eq!((losses.messages, summary.written), (51, 51), "and one event that says so");
}
