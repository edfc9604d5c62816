//! The profile on a Cortex-M7: the same manoeuvre as on the host, with the instructions and the stack that it took.
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
    use core::fmt::Write;
    use firmware_profile::budget::BOARD_STEP_INSTRUCTIONS;
    use firmware_profile::fingerprint::Fingerprint;
    use firmware_profile::manoeuvre::ManoeuvreSamples;
    use firmware_profile::{Profile, SETTINGS};
    use semihosting::{HostOutput, exit};
    use sideslip::flight::run::RunGeometry;

    /// The place of the pipeline. A program without threads and interrupts has it to itself.
    struct OnlyOne(UnsafeCell<Profile>);

    #[expect(unsafe_code, reason = "a static that is written without a lock has no safe form")]
    // SAFETY: `flight` is called once, from reset, and nothing else names the static.
    unsafe impl Sync for OnlyOne {}

    static PROFILE: OnlyOne = OnlyOne(UnsafeCell::new(Profile::new(&SETTINGS, RunGeometry::DEFAULT)));

    /// Flies the manoeuvre and says what it took.
    #[expect(unsafe_code, reason = "as of the static")]
    pub(super) extern "C" fn flight() -> ! {
        // SAFETY: the one reference to it; see `OnlyOne`.
        let profile = unsafe { &mut *PROFILE.0.get() };
        let mut fingerprint = Fingerprint::default();
        let (mut worst, mut worst_s, mut sum, mut steps) = (0, 0.0, 0_u64, 0_u64);
        let (mut before_it, mut worst_pair) = (0, 0);
        instructions::start();
        for sample in ManoeuvreSamples::default() {
            let before = instructions::now();
            let tick = profile.step(&sample);
            let taken = instructions::between(before, instructions::now());
            if taken > worst {
                (worst, worst_s) = (taken, sample.time_s);
            }
            worst_pair = worst_pair.max(before_it + taken);
            before_it = taken;
            sum += u64::from(taken);
            steps += 1;
            fingerprint.take(tick);
        }
        let stack = start::stack_used();
        fingerprint.take(profile.finish());
        let [code, memory] = start::linked_bytes();
        let written = write!(
            HostOutput,
            "code         {code} bytes with the initial image\nmemory       {memory} bytes with the stack\n\
             stack        {stack} bytes used\nstep         {} instructions in the mean, {worst} at most (at {worst_s:.2} s), \
             {worst_pair} of two in a row, limit {BOARD_STEP_INSTRUCTIONS} of one\nfingerprint  {:016x}\n",
            sum / steps.max(1),
            fingerprint.0
        );
        exit(usize::from(written.is_err() || worst as usize > BOARD_STEP_INSTRUCTIONS))
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
