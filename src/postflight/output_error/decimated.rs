//! Decimated records for the first part of the search: means over blocks of samples.
//!
//! The same mean over inputs, outputs and times leaves a linear model with constant coefficients unchanged but for the motion of
//! an input within a block. The search therefore starts from the optimum of a fraction of the samples and ends on all of them.

use super::model::InputOutputRecord;

const LONGEST: usize = 16;
/// Least number of blocks that the shortest record has to keep.
const BLOCKS: usize = 180;

/// The records by means of blocks; none where they are too short for it.
pub fn decimated(records: &[InputOutputRecord]) -> Option<Vec<InputOutputRecord>> {
    let shortest = records.iter().map(|record| record.times_s.len()).min()?;
    let mut block = LONGEST;
    while block > 1 && shortest / block < BLOCKS {
        block /= 2;
    }
    (block > 1).then(|| records.iter().map(|record| by_blocks(record, block)).collect())
}

/// A record by means of blocks of so many samples.
pub fn by_blocks(record: &InputOutputRecord, block: usize) -> InputOutputRecord {
    let all = |series: &[Vec<f64>]| series.iter().map(|one| means(one, block)).collect();
    InputOutputRecord {
        times_s: means(&record.times_s, block),
        inputs: all(&record.inputs),
        outputs: all(&record.outputs),
        input_noise_std: record.input_noise_std.iter().map(|std| std / libm::sqrt(block as f64)).collect(),
    }
}

/// Means over what was sampled, NaN where nothing was; an incomplete last block is left out.
fn means(series: &[f64], block: usize) -> Vec<f64> {
    let mean = |part: &[f64]| {
        let (sum, count) = part.iter().filter(|x| !x.is_nan()).fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
        if count > 0 { sum / f64::from(count) } else { f64::NAN }
    };
    series.chunks_exact(block).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_what_is_there() {
        assert_eq!(means(&[1.0, 3.0, f64::NAN, 5.0, 9.0], 2), [2.0, 5.0]);
        assert!(means(&[f64::NAN; 2], 2)[0].is_nan());
        let long = InputOutputRecord {
            times_s: (0..3000).map(f64::from).collect(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            input_noise_std: Vec::new(),
        };
        assert_eq!(decimated(std::slice::from_ref(&long)).unwrap()[0].times_s.len(), 187);
        let short = InputOutputRecord { times_s: long.times_s[..300].to_vec(), ..long };
        assert!(decimated(&[short]).is_none());
    }
}
