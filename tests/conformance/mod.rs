//! Proof that what is written can be read: by an independent reader, after a cut, after a kill, and by no trick of bytes.

mod example;
mod foreign;
mod full_disk;
mod hostile;
mod independent;
mod mavlink_logs;
mod provenance;
mod rotation;
mod round_trip;
mod schemas;
mod truncation;
