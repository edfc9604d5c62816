//! The columns of another program's table, by a map.
//!
//! Consumes the cells of a header and a section of a map; produces columns, in their order, with the factors to SI, and behind
//! them those that are computed of several or not linear ([`DerivedChannels`]). A column that the map does not name is carried
//! along under its own name. Refused: a column that is not there, with the nearest; a channel whose unit neither map nor header
//! state.

use crate::flight::channel::Channel;
use crate::flight::file::run_file::{RecordingColumn, RecordingTarget, quoted};
use crate::flight::sample::Sample;
use crate::flight::unit::{Quantity, factor_to_si};
use crate::io::telemetry::channel_map::map_file::{MapSection, MappedChannel, place_of, unit_of_column};
use crate::io::telemetry::channel_map::unit_text::{name_and_unit, unit_of};
use crate::io::telemetry::logs::mapping::atmosphere::{angles, standard};
use std::collections::HashSet;

/// A header as a map reads it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MappedHeader {
    pub(crate) columns: Vec<RecordingColumn>,
    pub(crate) derived: DerivedChannels,
    /// The column of the time.
    pub(crate) time: usize,
}

/// Channels that are no multiple of one column.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct DerivedChannels {
    /// The columns of a quaternion w, x, y, z.
    attitude: Option<[usize; 4]>,
    /// The column of a static pressure, and the bits of its factor to Pa.
    altitude: Option<(usize, u64)>,
}

impl DerivedChannels {
    /// Whether the cell is part of one.
    pub(crate) fn takes(&self, cell: usize) -> bool {
        self.attitude.is_some_and(|places| places.contains(&cell)) || self.altitude.is_some_and(|(place, _)| place == cell)
    }

    /// Computes them of the cells' numbers; the cell that makes one impossible.
    pub(crate) fn put(&self, sample: &mut Sample, number: impl Fn(usize) -> Option<f64>) -> Result<(), usize> {
        if let Some(places) = self.attitude
            && let [Some(w), Some(x), Some(y), Some(z)] = places.map(&number)
        {
            let [phi, theta, psi] = angles([w, x, y, z]).ok_or(places[0])?;
            for (channel, value) in [(Channel::Phi, phi), (Channel::Theta, theta), (Channel::Psi, psi)] {
                sample.set(channel, value);
            }
        }
        if let Some((place, factor)) = self.altitude
            && let Some(pressure) = number(place)
        {
            let (altitude, _) = standard(pressure * f64::from_bits(factor)).ok_or(place)?;
            sample.set(Channel::Altitude, altitude);
        }
        Ok(())
    }

    /// Of columns by a section of a map.
    pub(crate) fn of(section: &MapSection, headers: &[&str]) -> Result<Self, String> {
        let mut derived = DerivedChannels::default();
        if let Some(columns) = &section.attitude {
            let mut places = [0; 4];
            for (place, column) in places.iter_mut().zip(columns) {
                *place = place_of(column, headers).map_err(|what| format!("attitude: {what}"))?;
            }
            derived.attitude = Some(places);
        }
        for mapped in &section.channels {
            let place = place_of(&mapped.column, headers).map_err(|what| format!("{}: {what}", mapped.name))?;
            let header = headers.get(place).copied().unwrap_or_default();
            if let Some(factor) = pressure_factor(mapped, header) {
                derived.altitude = Some((place, (factor * mapped.factor).to_bits()));
            }
        }
        Ok(derived)
    }

    /// The columns that stand behind those of the file.
    pub(crate) fn columns(&self) -> Vec<RecordingColumn> {
        let attitude =
            self.attitude.iter().flat_map(|_| [("phi", Channel::Phi), ("theta", Channel::Theta), ("psi", Channel::Psi)]);
        let altitude = self.altitude.iter().map(|_| ("altitude", Channel::Altitude));
        let column = |(name, channel): (&str, Channel)| RecordingColumn {
            name: name.to_owned(),
            unit_text: None,
            target: RecordingTarget::Known { channel, factor: 1.0 },
        };
        attitude.chain(altitude).map(column).collect()
    }
}

/// The factor to Pa where an altitude stands as a static pressure.
fn pressure_factor(mapped: &MappedChannel, header: &str) -> Option<f64> {
    let unit = mapped.unit.or_else(|| name_and_unit(header).1.and_then(unit_of))?;
    if mapped.channel == Channel::Altitude { factor_to_si(unit, Quantity::Pressure).ok() } else { None }
}

impl MappedHeader {
    /// Of a header's cells.
    ///
    /// # Errors
    /// A sentence about what the map says and the header lacks.
    pub(crate) fn new(section: &MapSection, headers: &[&str]) -> Result<Self, String> {
        let wanted = section.time.column.as_deref().unwrap_or("time");
        let time = place_of(wanted, headers).map_err(|what| format!("time: {what}"))?;
        let derived = DerivedChannels::of(section, headers)?;
        let mut targets: Vec<Option<(&str, Option<&str>, RecordingTarget)>> = vec![None; headers.len()];
        let mut put = |place: usize, name, unit, target| match targets.get_mut(place) {
            Some(cell @ None) => {
                *cell = Some((name, unit, target));
                Ok(())
            }
            Some(Some((before, ..))) => {
                let header = quoted(headers.get(place).copied().unwrap_or_default());
                Err(format!("{name}: expected a column of its own, found {header}, which is {before} already"))
            }
            None => Ok(()),
        };
        let header = headers.get(time).copied().unwrap_or_default();
        put(time, "time", name_and_unit(header).1, RecordingTarget::Time { factor: 1.0 })?;
        for mapped in &section.channels {
            let place = place_of(&mapped.column, headers)?;
            if derived.takes(place) && mapped.channel == Channel::Altitude {
                continue;
            }
            let header = headers.get(place).copied().unwrap_or_default();
            let (unit, factor) = unit_of_column(&mapped.name, mapped.unit, header)?;
            let target = RecordingTarget::Known { channel: mapped.channel, factor: factor * mapped.factor };
            put(place, &mapped.name, Some(unit), target)?;
        }
        let mut names: HashSet<String> = targets.iter().flatten().map(|(name, ..)| (*name).to_owned()).collect();
        let mut columns = Vec::with_capacity(headers.len());
        for (header, target) in headers.iter().zip(targets) {
            columns.push(match target {
                Some((name, unit, target)) => {
                    RecordingColumn { name: name.to_owned(), unit_text: unit.map(str::to_owned), target }
                }
                None => carried(header, &mut names),
            });
        }
        columns.extend(derived.columns());
        Ok(MappedHeader { columns, derived, time })
    }
}

/// A column that the map does not name: under a name that may stand in a run file, and that no channel and no other column has.
fn carried(header: &str, names: &mut HashSet<String>) -> RecordingColumn {
    let may_stand = |letter: char| !",\"[]'#`".contains(letter) && !letter.is_control();
    let plain = |text: &str| text.chars().filter(|letter| may_stand(*letter)).collect::<String>().trim().to_owned();
    let (name, unit) = header.split_once('[').filter(|(name, _)| !name.trim().is_empty()).unwrap_or((header, ""));
    let (name, unit) = (plain(if unit.ends_with(']') { name } else { header }), plain(unit));
    let name = match name.as_str() {
        "" => "unnamed".to_owned(),
        "time" => "time (not mapped)".to_owned(),
        channel if Channel::from_name(channel).is_some() => format!("{channel} (not mapped)"),
        _ => name,
    };
    let mut own = name.clone();
    for count in 2_u32.. {
        if names.insert(own.clone()) {
            break;
        }
        own = format!("{name} ({count})");
    }
    RecordingColumn { name: own, unit_text: Some(unit).filter(|unit| !unit.is_empty()), target: RecordingTarget::Other }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::telemetry::channel_map::map_file::ChannelMap;

    fn header(map: &str, headers: &[&str]) -> Result<MappedHeader, String> {
        MappedHeader::new(&ChannelMap::from_toml(map).unwrap().sections[0], headers)
    }

    fn names(header: &MappedHeader) -> Vec<&str> {
        header.columns.iter().map(|column| column.name.as_str()).collect()
    }

    #[test]
    fn columns_are_those_of_the_map_and_the_others_keep_names_of_their_own() {
        let map = "time = \"t\"\n[channels]\np = \"Roll Rate [deg/s]\"\naz = { column = \"nz\", unit = \"g\", sign = -1 }\n";
        let read = header(map, &["t", "Roll Rate [deg/s]", "nz", "p", "oil [K]", "oil [K]", ""]).unwrap();
        assert_eq!(names(&read), ["time", "p", "az", "p (not mapped)", "oil", "oil (2)", "unnamed"]);
        assert_eq!(read.columns[2].target, RecordingTarget::Known { channel: Channel::Az, factor: -9.806_65 });
        assert_eq!(read.columns[4].unit_text.as_deref(), Some("K"));
    }

    #[test]
    fn what_the_header_lacks_is_said_with_the_nearest() {
        let map = "time = \"t\"\n[channels]\np = \"Roll Rate\"\n";
        let wrong = header(map, &["t", "RollRate"]).unwrap_err();
        assert!(wrong.starts_with("p: expected a column `Roll Rate`, found none; nearest is `RollRate`"), "{wrong}");
        let wrong = header(map, &["t", "Roll Rate"]).unwrap_err();
        assert!(
            wrong.contains("its header does not say it") && wrong.contains("unit = \"...\" } (rad/s, deg/s, rpm, ...)"),
            "{wrong}"
        );
        let wrong = header(map, &["t", "Roll Rate [V]"]).unwrap_err();
        assert!(wrong.contains("its header says `V`, which is none"), "{wrong}");
        let twice = "time = \"t\"\n[channels]\np = \"w [deg/s]\"\nq = \"w [deg/s]\"\n";
        assert!(header(twice, &["t", "w [deg/s]"]).unwrap_err().contains("which is p already"));
    }

    #[test]
    fn attitude_and_pressure_altitude_are_computed() {
        let map = "time = \"t\"\n[channels]\naltitude = \"Ps [hPa]\"\nattitude = [\"w\", \"x\", \"y\", \"z\"]\n";
        let read = header(map, &["t", "w", "x", "y", "z", "Ps [hPa]"]).unwrap();
        assert_eq!(names(&read), ["time", "w", "x", "y", "z", "Ps", "phi", "theta", "psi", "altitude"]);
        let mut sample = Sample::new(0.0);
        // A quarter turn about z; 898.745 hPa is 1000 m in the tables of the standard atmosphere.
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let cells = [0.0, half, 0.0, 0.0, half, 898.745];
        read.derived.put(&mut sample, |place| cells.get(place).copied()).unwrap();
        assert!((sample.get(Channel::Psi).unwrap() - core::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((sample.get(Channel::Altitude).unwrap() - 1000.0).abs() < 0.1);
        assert_eq!(read.derived.put(&mut sample, |_| Some(0.0)), Err(1));
    }
}
