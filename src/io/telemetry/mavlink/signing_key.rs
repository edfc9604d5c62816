//! The secret key of MAVLink 2 signing, from a file.
//!
//! Consumes a file of 64 hexadecimal digits (white space around them is allowed) or of exactly 32 raw bytes; produces a
//! [`SigningKey`], whose bytes no message and no debug output shows. Refused: a file of any other content, a key of zeros alone
//! (MAVLink's word for "no signing"), a file that users outside its owner and group can read or write.

use std::fs::File;
use std::io::{Error, Read};
use std::path::{Path, PathBuf};

/// Bytes of a key.
pub const KEY: usize = 32;
/// More than a file with a key holds.
const FILE_MAX: u64 = 1024;
/// Permissions of those who are neither owner nor group.
#[cfg(unix)]
const OTHERS: u32 = 0o007;

/// A key that is shared with the other end. Not printed by anything.
#[derive(Clone, PartialEq, Eq)]
pub struct SigningKey([u8; KEY]);

impl std::fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SigningKey(secret)")
    }
}

/// Why there is no key; no message contains a part of the file.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum KeyError {
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: Error },
    #[error("{}: expected 64 hexadecimal digits or 32 raw bytes, found {found}", path.display())]
    Content { path: PathBuf, found: String },
    #[error("{}: expected a key that only its owner and group can read, found permissions {mode:03o}: chmod 600 it", path.display())]
    Exposed { path: PathBuf, mode: u32 },
}

impl SigningKey {
    /// A key of these bytes; `None` where all are zero.
    pub fn new(bytes: [u8; KEY]) -> Option<Self> {
        bytes.iter().any(|byte| *byte != 0).then_some(SigningKey(bytes))
    }

    /// Reads a key file.
    ///
    /// # Errors
    /// [`KeyError`] where it cannot be read, holds no key, or others could read it too.
    pub fn read(path: &Path) -> Result<Self, KeyError> {
        let io = |source| KeyError::Io { path: path.into(), source };
        let file = File::open(path).map_err(io)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = file.metadata().map_err(io)?.permissions().mode() & 0o777;
            if mode & OTHERS != 0 {
                return Err(KeyError::Exposed { path: path.into(), mode });
            }
        }
        let mut bytes = Vec::new();
        file.take(FILE_MAX).read_to_end(&mut bytes).map_err(io)?;
        let content = |found: String| KeyError::Content { path: path.into(), found };
        let key = parse(&bytes).map_err(content)?;
        SigningKey::new(key).ok_or_else(|| content("zeros alone, which mean that nothing is signed".to_owned()))
    }

    pub(super) fn bytes(&self) -> &[u8; KEY] {
        &self.0
    }
}

/// The key in the bytes of a file, or what was found in its place: counts and kinds, never the content.
fn parse(bytes: &[u8]) -> Result<[u8; KEY], String> {
    if let Ok(raw) = bytes.try_into() {
        return Ok(raw);
    }
    let text = bytes.trim_ascii();
    if text.len() != 2 * KEY {
        let more = if bytes.len() as u64 >= FILE_MAX { " or more" } else { "" };
        return Err(format!("{} bytes{more}", bytes.len()));
    }
    let mut key = [0; KEY];
    for (byte, (place, pair)) in key.iter_mut().zip(text.chunks(2).enumerate()) {
        let digits = std::str::from_utf8(pair).ok().filter(|pair| pair.bytes().all(|digit| digit.is_ascii_hexdigit()));
        *byte = digits
            .and_then(|digits| u8::from_str_radix(digits, 16).ok())
            .ok_or_else(|| format!("something else at digit {} or {}", 2 * place + 1, 2 * place + 2))?;
    }
    Ok(key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    fn read(name: &str, content: &[u8], mode: u32) -> Result<SigningKey, KeyError> {
        let path = std::env::temp_dir().join(format!("sideslip-key-{name}-{}", std::process::id()));
        std::fs::write(&path, content).unwrap();
        std::fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
        let read = SigningKey::read(&path);
        std::fs::remove_file(&path).unwrap();
        read
    }

    #[test]
    fn digits_and_raw_bytes_are_the_same_key_and_neither_is_printed() {
        let raw: [u8; KEY] = std::array::from_fn(|i| 0xE0 + i as u8);
        let digits: String = raw.iter().map(|byte| format!("{byte:02x}")).collect();
        let key = read("raw", &raw, 0o600).unwrap();
        for text in [digits.clone(), digits.to_uppercase(), format!("{digits}\n"), format!("  {digits} \r\n")] {
            assert_eq!(read("digits", text.as_bytes(), 0o640).unwrap(), key);
        }
        assert_eq!(key.bytes(), &raw);
        assert_eq!(format!("{key:?}"), "SigningKey(secret)");
    }

    #[test]
    fn what_is_no_key_and_what_others_can_read_is_refused_without_a_word_of_it() {
        let secret = "secretsecretsecretsecretsecretsecretsecretsecretsecretsecretsecr";
        for (content, mode, words) in [
            (&b""[..], 0o600, "found 0 bytes"),
            (&[7; 31], 0o600, "found 31 bytes"),
            (&[7; 2000], 0o600, "found 1024 bytes or more"),
            (&[0; 32], 0o600, "zeros alone"),
            (&[b'0'; 64], 0o600, "zeros alone"),
            (secret.as_bytes(), 0o600, "something else at digit 1 or 2"),
            (&[7; 32], 0o644, "permissions 644: chmod 600"),
            (&[7; 32], 0o602, "permissions 602"),
        ] {
            let refused = read("wrong", content, mode).unwrap_err().to_string();
            assert!(refused.contains(words) && !refused.contains("secret"), "{refused}");
        }
        assert!(matches!(SigningKey::read(Path::new("/nowhere/key")), Err(KeyError::Io { .. })));
    }
}
