//! What the program says to whoever emulates or debugs it, and its end: Arm semihosting.
//!
//! Source: Arm, Semihosting for AArch32 and AArch64, 2022: SYS_WRITE0 (0x04) and SYS_EXIT_EXTENDED (0x20).

#![expect(unsafe_code, reason = "a breakpoint instruction has no safe form")]

use core::arch::asm;
use core::fmt::Write;

const WRITE0: usize = 0x04;
const EXIT_EXTENDED: usize = 0x20;
const APPLICATION_EXIT: usize = 0x2_0026;

fn call(operation: usize, argument: usize) {
    // SAFETY: a breakpoint with this number hands control to the host, which reads what the argument points at and writes
    // nothing but r0; without a host it is a fault, which `start` ends in.
    unsafe { asm!("bkpt 0xab", inlateout("r0") operation => _, in("r1") argument, options(nostack)) }
}

/// Standard output of the host.
pub(super) struct HostOutput;

impl Write for HostOutput {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for part in text.as_bytes().chunks(63) {
            // Its last byte stays zero, which ends the text.
            let mut line = [0_u8; 64];
            line.iter_mut().zip(part).for_each(|(to, from)| *to = *from);
            call(WRITE0, line.as_ptr().addr());
        }
        Ok(())
    }
}

/// Ends the emulation with that exit status.
pub(super) fn exit(status: usize) -> ! {
    let block = [APPLICATION_EXIT, status];
    call(EXIT_EXTENDED, block.as_ptr().addr());
    loop {}
}
