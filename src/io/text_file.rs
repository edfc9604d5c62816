//! Text files that a user names: formats, maps, models, instruments; read whole, of bounded size.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The largest that is read, bytes.
pub const TEXT_FILE_MAX: u64 = 16 << 20;

/// Why a text file cannot be read.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum TextFileError {
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    #[error("expected a text file of at most {} MiB, found more", TEXT_FILE_MAX >> 20)]
    TooLong,
    #[error("expected UTF-8 text: {0}")]
    NotUtf8(#[from] std::string::FromUtf8Error),
}

/// The text of a file.
///
/// # Errors
/// [`TextFileError`] where it cannot be read, is longer than [`TEXT_FILE_MAX`], or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, TextFileError> {
    let mut bytes = Vec::new();
    File::open(path)?.take(TEXT_FILE_MAX + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > TEXT_FILE_MAX {
        return Err(TextFileError::TooLong);
    }
    Ok(String::from_utf8(bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_endless_a_folder_or_no_text_is_refused() {
        assert!(matches!(read_text(Path::new("/dev/zero")), Err(TextFileError::TooLong)));
        let folder = std::env::temp_dir().join(format!("sideslip-text-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("latin.toml");
        std::fs::write(&file, b"name = \"Z\xfcrich\"").unwrap();
        assert!(matches!(read_text(&file), Err(TextFileError::NotUtf8(_))));
        assert!(matches!(read_text(&folder), Err(TextFileError::Unreadable(_))));
        std::fs::write(&file, "a = 1").unwrap();
        assert_eq!(read_text(&file).unwrap(), "a = 1");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
