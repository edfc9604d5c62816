//! Gaps of several signals as gaps of all.

/// The union of gaps, each from the sample before to the one after, s: in order of time, those that overlap as one. Two that
/// touch have a sample between them.
pub fn gap_union(mut gaps: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    gaps.sort_by(|[one, _], [other, _]| one.total_cmp(other));
    gaps.dedup_by(|[next_from, next_to], [_, to]| {
        let overlap = *next_from < *to;
        if overlap {
            *to = to.max(*next_to);
        }
        overlap
    });
    gaps
}

#[cfg(test)]
mod tests {
    use super::gap_union;

    #[test]
    fn gaps_that_overlap_are_one_and_gaps_that_touch_are_two() {
        let gaps = vec![[7.0, 8.0], [1.0, 3.0], [2.0, 2.5], [2.9, 4.0], [8.0, 9.0]];
        assert_eq!(gap_union(gaps), [[1.0, 4.0], [7.0, 8.0], [8.0, 9.0]]);
        assert!(gap_union(Vec::new()).is_empty());
    }
}
