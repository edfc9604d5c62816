//! Random numbers, streams with known words, noise and bit slips; the same on every machine.
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;

/// SplitMix64 (Steele, Lea and Flood, 2014).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// Below the bound, which is small.
    pub(super) fn below(&mut self, bound: usize) -> usize {
        (self.next() >> 11) as usize % bound
    }

    /// Above 0, to 1.
    pub(super) fn unit(&mut self) -> f64 {
        ((self.next() >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }
}

/// A symmetric channel: each bit is wrong with that probability. Returns how many were made wrong.
pub(super) fn add_errors(line: &mut [u8], rate: f64, random: &mut Random) -> u64 {
    let mut made = 0;
    let mut place = 0.0;
    loop {
        // The distance to the next wrong bit is geometric.
        place += 1.0 + (random.unit().ln() / (1.0 - rate).ln()).floor();
        let bit = place as usize - 1;
        let Some(byte) = line.get_mut(bit / 8) else { return made };
        *byte ^= 0x80 >> (bit % 8);
        made += 1;
    }
}

/// Bits as bytes, after each of these places (increasing) that many bits are inserted (ones and zeros in turn) or left out.
pub(super) fn with_slips(line: &[u8], slips: &[(usize, i32)]) -> Vec<u8> {
    let mut bits: Vec<u8> = Vec::with_capacity(line.len() * 8 + 64);
    let mut slips = slips.iter().peekable();
    let mut skip = 0;
    for n in 0..line.len() * 8 {
        if let Some((_, by)) = slips.next_if(|(place, _)| *place == n) {
            (0..*by).for_each(|k| bits.push((k % 2) as u8));
            skip = (-*by).max(0);
        }
        if skip > 0 {
            skip -= 1;
        } else {
            bits.push(line[n / 8] >> (7 - n % 8) & 1);
        }
    }
    bits.chunks(8).map(|bits| bits.iter().enumerate().fold(0, |byte, (k, bit)| byte | bit << (7 - k))).collect()
}

/// A pattern of 32 bits and 32 words of 16 bits: the subframe identifier in the last four of word 1, then 30 parameters, and in
/// word 32 another in each of four subframes. The parity, if any, is in every word.
pub(super) fn format(line_code: &str, parity: &str) -> PcmFormat {
    let bits = if parity == "none" { 16 } else { 15 };
    let mut text = format!(
        "bit_rate = 2_048_000\nline_code = \"{line_code}\"\nparity = \"{parity}\"\nwords = 33\nword_bits = 16\nminor_frames = 16\n\
         [sync]\npattern = 0xFE6B_2840\nbits = 32\n[subframe_id]\nword = 1\nbits = [{}, {bits}]\n",
        bits - 3
    );
    for word in 2..32 {
        text += &format!("[[parameter]]\nname = \"word {word}\"\nword = {word}\n");
    }
    for frame in 1..=4 {
        text += &format!("[[parameter]]\nname = \"sub {frame}\"\nword = 32\nframe = {frame}\nframe_interval = 4\n");
    }
    PcmFormat::from_toml(&text).unwrap()
}

/// A stream and what was sent in it.
pub(super) struct Sent {
    pub(super) line: Vec<u8>,
    /// By minor frame and place of the word: parameter and raw word.
    pub(super) words: Vec<(usize, u64)>,
    pub(super) words_per_frame: usize,
}

/// Minor frames with random words.
pub(super) fn sent(format: &PcmFormat, frames: usize, inverted: bool, random: &mut Random) -> Sent {
    let mut encoder = PcmEncoder::new(format, 0.0).unwrap();
    if inverted {
        encoder = encoder.inverted();
    }
    let bits = format.words()[1].data().1;
    let (mut line, mut words) = (Vec::new(), Vec::new());
    for _ in 0..frames {
        let value = |parameter, _| {
            let word = random.next() & ((1 << bits) - 1);
            words.push((parameter, word));
            word as f64
        };
        encoder.minor_frame(value, &mut line).unwrap();
    }
    encoder.finish(&mut line);
    let words_per_frame = words.len() / frames;
    Sent { line, words, words_per_frame }
}
