//! The bytes of a message: every basic field of a topic with its offset, formats within formats laid out one after the other.
//!
//! Consumes a format and those that it contains; produces a [`UlogLayout`]. Names of fields within fields are joined by points,
//! elements of an array of formats are numbered: `heartbeats[1].type`. An array of a basic type stays one field. Fields whose
//! name begins with `_padding` keep their place and are not shown; those that end the topic itself may be left out of its
//! messages.
//! Refused, by a budget for the whole log: more than [`VISITS_MAX`] fields visited or [`NAMES_MAX`] bytes of names, formats
//! more than [`DEPTH_MAX`] deep (as one that contains itself is), more than 65535 bytes.
//! Source: PX4 User Guide, "ULog File Format", 'F': Format Message.

use super::definition::{UlogFieldType, UlogFormat};
use super::error::LayoutError;
use super::value::UlogType;
use std::collections::BTreeMap;

/// Fields that are visited for all layouts of a log at most.
pub const VISITS_MAX: usize = 1 << 17;
/// Bytes of names in all layouts of a log at most.
pub const NAMES_MAX: usize = 4 << 20;
/// Formats within formats at most.
pub const DEPTH_MAX: usize = 16;
const SIZE_MAX: usize = 65_535;

/// A field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UlogLeaf {
    /// Its name, with those of the fields that it is in.
    pub name: Box<str>,
    /// Its type.
    pub kind: UlogType,
    /// Elements of an array; `None` where it is none.
    pub array: Option<usize>,
    /// Its first byte in the data of a message.
    pub offset: usize,
    /// Whether it only fills up.
    pub padding: bool,
}

impl UlogLeaf {
    /// Bytes.
    pub fn size(&self) -> usize {
        self.kind.size().saturating_mul(self.array.unwrap_or(1))
    }
}

/// The fields of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UlogLayout {
    /// Fields in their order, those that fill up among them.
    pub leaves: Vec<UlogLeaf>,
    /// Bytes of the data without the padding at the end.
    pub least: usize,
    /// Bytes with it.
    pub most: usize,
    /// Place of the time in `leaves`.
    pub timestamp: Option<usize>,
}

/// What all layouts of a log may still take.
#[derive(Clone, Debug)]
pub(super) struct LayoutBudget {
    visits: usize,
    names: usize,
}

impl Default for LayoutBudget {
    fn default() -> Self {
        LayoutBudget { visits: VISITS_MAX, names: NAMES_MAX }
    }
}

impl LayoutBudget {
    fn spend(&mut self, name: usize) -> Result<(), LayoutError> {
        self.visits = self.visits.checked_sub(1).ok_or(LayoutError::Fields { limit: VISITS_MAX })?;
        self.names = self.names.checked_sub(name).ok_or(LayoutError::Fields { limit: NAMES_MAX })?;
        Ok(())
    }
}

struct Builder<'a> {
    formats: &'a BTreeMap<Box<str>, UlogFormat>,
    budget: &'a mut LayoutBudget,
    leaves: Vec<UlogLeaf>,
    size: usize,
}

impl Builder<'_> {
    fn add(&mut self, format: &UlogFormat, prefix: &str, depth: usize) -> Result<(), LayoutError> {
        if depth > DEPTH_MAX {
            return Err(LayoutError::Depth { name: format.name.to_string(), limit: DEPTH_MAX });
        }
        for field in &format.fields {
            match &field.kind {
                UlogFieldType::Basic(kind) => {
                    self.budget.spend(prefix.len() + field.name.len())?;
                    let (name, padding) = (format!("{prefix}{}", field.name).into(), field.name.starts_with("_padding"));
                    let leaf = UlogLeaf { name, kind: *kind, array: field.array, offset: self.size, padding };
                    self.size = self.size.saturating_add(leaf.size());
                    self.leaves.push(leaf);
                }
                UlogFieldType::Format(name) => {
                    let formats = self.formats;
                    let inner = formats.get(name).ok_or_else(|| LayoutError::NoType { name: name.to_string() })?;
                    for index in 0..field.array.unwrap_or(1) {
                        self.budget.spend(prefix.len())?;
                        let prefix = match field.array {
                            Some(_) => format!("{prefix}{}[{index}].", field.name),
                            None => format!("{prefix}{}.", field.name),
                        };
                        self.add(inner, &prefix, depth + 1)?;
                    }
                }
            }
            if self.size > SIZE_MAX {
                return Err(LayoutError::Size { limit: SIZE_MAX });
            }
        }
        Ok(())
    }
}

impl UlogLayout {
    /// Lays out a format.
    pub(super) fn build(
        format: &UlogFormat,
        formats: &BTreeMap<Box<str>, UlogFormat>,
        budget: &mut LayoutBudget,
    ) -> Result<Self, LayoutError> {
        let mut builder = Builder { formats, budget, leaves: Vec::new(), size: 0 };
        builder.add(format, "", 0)?;
        let (leaves, most) = (builder.leaves, builder.size);
        let outer_padding = |leaf: &&UlogLeaf| leaf.name.starts_with("_padding");
        let least = most - leaves.iter().rev().take_while(outer_padding).map(UlogLeaf::size).sum::<usize>();
        let is_time = |kind| matches!(kind, UlogType::UInt64 | UlogType::UInt32 | UlogType::UInt16 | UlogType::UInt8);
        let timestamp = leaves.iter().position(|leaf| &*leaf.name == "timestamp" && leaf.array.is_none() && is_time(leaf.kind));
        Ok(UlogLayout { leaves, least, most, timestamp })
    }

    /// The field of that name.
    pub fn leaf(&self, name: &str) -> Option<&UlogLeaf> {
        self.leaves.iter().find(|leaf| &*leaf.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(texts: &[&str]) -> Result<UlogLayout, LayoutError> {
        let parsed: Vec<_> = texts.iter().map(|text| UlogFormat::parse(text.as_bytes(), 0).unwrap()).collect();
        let formats = parsed.iter().map(|format| (format.name.clone(), format.clone())).collect();
        UlogLayout::build(&parsed[0], &formats, &mut LayoutBudget::default())
    }

    #[test]
    fn formats_within_formats_are_laid_out_with_their_padding() {
        let texts = [
            "a:uint64_t timestamp;b[2] in;bool ok;uint8_t[7] _padding0;",
            "b:uint16_t x;c deep;uint8_t[3] _padding0;",
            "c:bool y;",
        ];
        let layout = layout(&texts).unwrap();
        let shown: Vec<_> = layout.leaves.iter().filter(|leaf| !leaf.padding).map(|leaf| (&*leaf.name, leaf.offset)).collect();
        let expected =
            [("timestamp", 0), ("in[0].x", 8), ("in[0].deep.y", 10), ("in[1].x", 14), ("in[1].deep.y", 16), ("ok", 20)];
        assert_eq!(shown, expected);
        assert_eq!((layout.least, layout.most, layout.timestamp), (21, 28, Some(0)));
    }

    #[test]
    fn padding_at_the_end_of_an_inner_format_is_logged() {
        let layout = layout(&["a:uint64_t timestamp;b in;", "b:bool y;uint8_t[3] _padding0;"]).unwrap();
        assert_eq!((layout.least, layout.most), (12, 12));
    }

    #[test]
    fn hostile_definitions_are_refused() {
        let depth = |error| matches!(error, LayoutError::Depth { .. });
        assert!(depth(layout(&["a:a again;"]).unwrap_err()));
        assert!(depth(layout(&["a:bool x;b[65535] y;", "b:a[65535] z;"]).unwrap_err()));
        assert!(matches!(layout(&["a:b x;"]).unwrap_err(), LayoutError::NoType { .. }));
        assert!(matches!(layout(&["a:double[65535] x;"]).unwrap_err(), LayoutError::Size { .. }));
        assert!(matches!(layout(&["a:b[65535] x;", "b:double[8192] y;"]).unwrap_err(), LayoutError::Size { .. }));
        assert!(layout(&["a:b[65535] x;", "b:bool y;"]).is_ok());
        let long = format!("a:b[65535] {};", "x".repeat(200));
        assert!(matches!(layout(&[&long, "b:bool y;"]).unwrap_err(), LayoutError::Fields { .. }));
        // The budget is the log's and not the format's.
        let formats = ["a:b[65535] x;", "b:bool y;"].map(|text| UlogFormat::parse(text.as_bytes(), 0).unwrap());
        let map = formats.iter().map(|format| (format.name.clone(), format.clone())).collect();
        let mut budget = LayoutBudget::default();
        let results = [0; 3].map(|_| UlogLayout::build(&formats[0], &map, &mut budget).is_ok());
        assert_eq!(results, [true, false, false]);
    }
}
