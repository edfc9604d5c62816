//! Pseudo-random binary sequences of the greatest length that a shift register gives.
//!
//! Consumes an order n; produces the sequence of 2^n - 1 clocks as a multistep: lengths of pulses of alternating sign. A register
//! of n bits, all ones at first, gives its last bit; what goes in is the sum modulo two of the bits at its taps:
//!     b(k) = b(k - t1) + b(k - t2) + ...  (mod 2)                                        (1)
//! With +1 for a one and -1 for a zero the sequence, repeated, has the autocorrelation 1 at multiples of its length N and
//! exactly -1/N everywhere else: it excites every frequency alike up to about the half of one a clock.
//! Source of the taps: P. Alfke, "Efficient shift registers, LFSR counters, and long pseudo-random sequence generators",
//! Xilinx XAPP 052, 1996, table 3; that each gives the full length is tested.
//! Refused: other orders than 3 to 8.

/// Taps of order 3, 4, ...
const TAPS: [&[usize]; 6] = [&[3, 2], &[4, 3], &[5, 3], &[6, 5], &[7, 6], &[8, 6, 5, 4]];

/// Least order.
const FIRST: usize = 3;

/// Lengths of the pulses in clocks, the first positive.
pub(crate) fn pattern(order: usize) -> Option<Vec<u32>> {
    let mut lengths: Vec<u32> = Vec::new();
    let mut before = None;
    for bit in bits(order)? {
        match lengths.last_mut() {
            Some(length) if before == Some(bit) => *length += 1,
            _ => lengths.push(1),
        }
        before = Some(bit);
    }
    Some(lengths)
}

/// The order whose pattern this is.
pub(crate) fn order_of(lengths: &[u32]) -> Option<usize> {
    let clocks: u32 = lengths.iter().sum();
    let order = (clocks + 1).checked_ilog2()? as usize;
    (pattern(order)? == lengths).then_some(order)
}

/// Equation (1): one period.
fn bits(order: usize) -> Option<Vec<bool>> {
    let taps = TAPS.get(order.checked_sub(FIRST)?)?;
    let length = (1usize << order) - 1;
    let mut bits = vec![true; order];
    while bits.len() < length {
        let fed = taps.iter().filter_map(|tap| bits.get(bits.len() - tap)).filter(|bit| **bit).count();
        bits.push(fed % 2 == 1);
    }
    Some(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn off_its_peak_the_autocorrelation_is_exactly_minus_one_in_n() {
        for order in 3..=8 {
            let sequence: Vec<i64> = bits(order).unwrap().into_iter().map(|bit| if bit { 1 } else { -1 }).collect();
            let count = sequence.len();
            assert_eq!((count, sequence.iter().sum::<i64>()), ((1 << order) - 1, 1));
            for shift in 0..count {
                let sum: i64 = (0..count).map(|place| sequence[place] * sequence[(place + shift) % count]).sum();
                assert_eq!(sum, if shift == 0 { count as i64 } else { -1 }, "order {order}, shift {shift}");
            }
        }
        assert!(bits(2).is_none() && bits(9).is_none());
    }

    #[test]
    fn order_three_is_that_by_hand_and_each_is_known_again() {
        // 1 1 1 then b(k) = b(k-3) + b(k-2): 0 0 1 0.
        assert_eq!(pattern(3).unwrap(), [3, 2, 1, 1]);
        for order in 3..=8 {
            assert_eq!(order_of(&pattern(order).unwrap()), Some(order));
        }
        assert!([&[][..], &[3, 2, 1], &[3, 2, 1, 2], &[1, 1, 2, 3]].iter().all(|lengths| order_of(lengths).is_none()));
    }
}
