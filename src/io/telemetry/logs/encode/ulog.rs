//! Writes ULogs: header, flags, definitions, data, appended sections.
//!
//! Consumes texts of formats, and values as bytes (little-endian); produces bytes.

use super::LogEncodeError;

const OFFSETS_AT: usize = 16 + 3 + 16;
const APPENDED_AT: usize = 16 + 3 + 8;

/// Writes a log.
#[derive(Clone, Debug)]
pub struct UlogWriter {
    bytes: Vec<u8>,
    sections: usize,
}

impl UlogWriter {
    /// A log with its header, and flags of which none is set.
    pub fn new(start_us: u64) -> Self {
        let mut bytes = vec![0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 1];
        bytes.extend(start_us.to_le_bytes());
        bytes.extend([40, 0, b'B']);
        bytes.extend([0; 40]);
        UlogWriter { bytes, sections: 0 }
    }

    /// Writes a message of any kind.
    ///
    /// # Errors
    /// [`LogEncodeError::Long`] where its size does not fit its header.
    pub fn message(&mut self, kind: u8, parts: &[&[u8]]) -> Result<(), LogEncodeError> {
        let found = parts.iter().map(|part| part.len()).sum();
        let size = u16::try_from(found).map_err(|_| LogEncodeError::Long { kind: kind.into(), found })?;
        self.bytes.extend(size.to_le_bytes());
        self.bytes.push(kind);
        parts.iter().for_each(|part| self.bytes.extend(*part));
        Ok(())
    }

    /// Writes a format, `name:type field;...`.
    ///
    /// # Errors
    /// As [`message`](Self::message).
    pub fn format(&mut self, text: &str) -> Result<(), LogEncodeError> {
        self.message(b'F', &[text.as_bytes()])
    }

    /// Writes information (`I`) or a parameter (`P`): its key with its type, `float GAIN`, and its value.
    ///
    /// # Errors
    /// As [`message`](Self::message).
    pub fn keyed(&mut self, kind: u8, key: &str, value: &[u8]) -> Result<(), LogEncodeError> {
        let found = key.len();
        let length = u8::try_from(found).map_err(|_| LogEncodeError::Long { kind: kind.into(), found })?;
        self.message(kind, &[&[length], key.as_bytes(), value])
    }

    /// Subscribes a topic.
    ///
    /// # Errors
    /// As [`message`](Self::message).
    pub fn subscribe(&mut self, multi_id: u8, id: u16, name: &str) -> Result<(), LogEncodeError> {
        let [low, high] = id.to_le_bytes();
        self.message(b'A', &[&[multi_id, low, high], name.as_bytes()])
    }

    /// Writes data of a subscription.
    ///
    /// # Errors
    /// As [`message`](Self::message).
    pub fn data(&mut self, id: u16, parts: &[&[u8]]) -> Result<(), LogEncodeError> {
        self.message(b'D', &[&id.to_le_bytes(), &parts.concat()])
    }

    /// Writes a place to begin at.
    pub fn sync(&mut self) {
        self.bytes.extend([8, 0, b'S', 0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12]);
    }

    /// Writes that messages were lost.
    pub fn dropout(&mut self, duration_ms: u16) {
        let [low, high] = duration_ms.to_le_bytes();
        self.bytes.extend([2, 0, b'O', low, high]);
    }

    /// Writes bytes that are no message.
    pub fn garbage(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }

    /// Begins appended data: sets the flag and notes the offset, of which there is room for three.
    pub fn append(&mut self) {
        let offset = (self.bytes.len() as u64).to_le_bytes();
        let at = OFFSETS_AT + 8 * self.sections;
        if self.sections < 3
            && let Some(place) = self.bytes.get_mut(at..at + 8)
        {
            place.copy_from_slice(&offset);
            self.sections += 1;
            if let Some(flags) = self.bytes.get_mut(APPENDED_AT) {
                *flags |= 1;
            }
        }
    }

    /// What was written.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The same, to be damaged.
    pub fn bytes_mut(&mut self) -> &mut Vec<u8> {
        &mut self.bytes
    }
}
