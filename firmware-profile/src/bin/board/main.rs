//! The profile on a Cortex-M7: the same manoeuvre as on the host, or the samples of the host's file that the command line names,
//! with the instructions and the stack that it took.
//!
//! `board/run` builds it with nothing but `core`, emulates the board, and holds the fingerprint against the host's. It ends with
//! status 1 where a limit of `budget.toml` is exceeded, 2 after a panic, 3 after a fault (a stack that is too small is one).
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod instructions;
#[cfg(target_os = "none")]
mod semihosting;
#[cfg(target_os = "none")]
mod start;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    // Built for the host by checks of all features only.
    std::process::ExitCode::FAILURE
}

#[cfg(target_os = "none")]
use on_board::{fault, flight};

#[cfg(target_os = "none")]
mod on_board {
    use super::{instructions, semihosting, start};
    use core::cell::UnsafeCell;
    use core::ffi::CStr;
    use core::fmt::Write;
    use firmware_profile::budget::BOARD_STEP_INSTRUCTIONS;
    use firmware_profile::c_interface::SideslipSample;
    use firmware_profile::fingerprint::Fingerprint;
    use firmware_profile::manoeuvre::ManoeuvreSamples;
    use firmware_profile::{Profile, SETTINGS};
    use semihosting::{HostFile, HostOutput, command_line, exit};
    use sideslip::flight::run::RunGeometry;
    use sideslip::flight::sample::Sample;

    /// The place of the pipeline. A program without threads and interrupts has it to itself.
    struct OnlyOne(UnsafeCell<Profile>);

    #[expect(unsafe_code, reason = "a static that is written without a lock has no safe form")]
    // SAFETY: `flight` is called once, from reset, and nothing else names the static.
    unsafe impl Sync for OnlyOne {}

    static PROFILE: OnlyOne = OnlyOne(UnsafeCell::new(Profile::new(&SETTINGS, RunGeometry::DEFAULT)));

    /// What a flight took, in instructions.
    struct Cost {
        sum: u64,
        steps: u64,
        worst: u32,
        worst_s: f64,
        before: u32,
        worst_pair: u32,
    }

    impl Cost {
        fn take(&mut self, time_s: f64, taken: u32) {
            if taken > self.worst {
                (self.worst, self.worst_s) = (taken, time_s);
            }
            self.worst_pair = self.worst_pair.max(self.before + taken);
            self.before = taken;
            self.sum += u64::from(taken);
            self.steps += 1;
        }
    }

    /// Flies the samples of the file, or the manoeuvre, and says what it took.
    #[expect(unsafe_code, reason = "as of the static")]
    pub(super) extern "C" fn flight() -> ! {
        // SAFETY: the one reference to it; see `OnlyOne`.
        let profile = unsafe { &mut *PROFILE.0.get() };
        let mut fingerprint = Fingerprint::default();
        let mut cost = Cost { sum: 0, steps: 0, worst: 0, worst_s: 0.0, before: 0, worst_pair: 0 };
        instructions::start();
        let mut step = |sample: &Sample| {
            let before = instructions::now();
            let tick = profile.step(sample);
            cost.take(sample.time_s, instructions::between(before, instructions::now()));
            fingerprint.take(tick);
        };
        match recorded() {
            Some(file) => {
                let mut bytes = [0; SideslipSample::BYTES];
                while file.fill(&mut bytes) {
                    step(&Sample::from(&SideslipSample::from_le_bytes(&bytes)));
                }
            }
            None => ManoeuvreSamples::default().for_each(|sample| step(&sample)),
        }
        let stack = start::stack_used();
        fingerprint.take(profile.finish());
        let [code, memory] = start::linked_bytes();
        let Cost { sum, steps, worst, worst_s, worst_pair, .. } = cost;
        let written = write!(
            HostOutput,
            "code         {code} bytes with the initial image\nmemory       {memory} bytes with the stack\n\
             stack        {stack} bytes used\nstep         {} instructions in the mean of {steps}, {worst} at most (at \
             {worst_s:.2} s), {worst_pair} of two in a row, limit {BOARD_STEP_INSTRUCTIONS} of one\nfingerprint  {:016x}\n",
            sum / steps.max(1),
            fingerprint.0
        );
        exit(usize::from(written.is_err() || worst as usize > BOARD_STEP_INSTRUCTIONS))
    }

    /// The file that the command line names after the program.
    fn recorded() -> Option<HostFile> {
        let mut buffer = [0; 512];
        let line = command_line(&mut buffer)?;
        let after = line.iter().position(|byte| *byte == b' ')? + 1;
        let file = CStr::from_bytes_until_nul(buffer.get(after..)?).ok().and_then(HostFile::open);
        if file.is_none() {
            let _ = HostOutput.write_str("the file of samples cannot be opened\n");
            exit(2)
        }
        file
    }

    /// An exception that nothing here raises on purpose.
    pub(super) extern "C" fn fault() -> ! {
        let _ = HostOutput.write_str("fault: memory that there is not, such as beyond the stack, or an instruction\n");
        exit(3)
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        let _ = writeln!(HostOutput, "{info}");
        exit(2)
    }
}
