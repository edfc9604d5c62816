//! What the program says to whoever emulates or debugs it, and its end: Arm semihosting.
//!
//! Source: Arm, Semihosting for AArch32 and AArch64, 2022: SYS_OPEN, SYS_WRITE0, SYS_READ, SYS_GET_CMDLINE, SYS_EXIT_EXTENDED.

#![expect(unsafe_code, reason = "a breakpoint instruction has no safe form")]

use core::arch::asm;
use core::fmt::Write;

const OPEN: usize = 0x01;
const WRITE0: usize = 0x04;
const READ: usize = 0x06;
const GET_COMMAND_LINE: usize = 0x15;
/// Mode of OPEN: to be read, as bytes.
const READ_BYTES: usize = 1;
const EXIT_EXTENDED: usize = 0x20;
const APPLICATION_EXIT: usize = 0x2_0026;

fn call(operation: usize, argument: usize) -> usize {
    let result;
    // SAFETY: a breakpoint with this number hands control to the host, which reads what the argument points at and writes
    // nothing but r0 and the buffers that the argument names; without a host it is a fault, which `start` ends in.
    unsafe { asm!("bkpt 0xab", inlateout("r0") operation => result, in("r1") argument, options(nostack)) }
    result
}

/// The command line, without a zero at its end.
pub(super) fn command_line(buffer: &mut [u8]) -> Option<&[u8]> {
    let block = [buffer.as_mut_ptr().addr(), buffer.len()];
    let block = block.as_ptr();
    if call(GET_COMMAND_LINE, block.addr()) != 0 {
        return None;
    }
    buffer.split(|byte| *byte == 0).next()
}

/// A file of the host that is read.
pub(super) struct HostFile {
    handle: usize,
}

impl HostFile {
    /// Opens it; the path ends in a zero, which is not counted.
    pub(super) fn open(path: &core::ffi::CStr) -> Option<Self> {
        let block = [path.as_ptr().addr(), READ_BYTES, path.count_bytes()];
        let handle = call(OPEN, block.as_ptr().addr());
        (handle != usize::MAX).then_some(HostFile { handle })
    }

    /// Fills the buffer; `false` at the end of the file.
    pub(super) fn fill(&self, buffer: &mut [u8]) -> bool {
        let block = [self.handle, buffer.as_mut_ptr().addr(), buffer.len()];
        // The number of bytes that are missing.
        call(READ, block.as_ptr().addr()) == 0
    }
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
