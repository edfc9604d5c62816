//! Instructions since the start, by SysTick.
//!
//! The emulator is told that an instruction takes a nanosecond; SysTick counts down at the processor's 25 MHz, so a tick is 40
//! instructions.

#![expect(unsafe_code, reason = "registers have no safe form")]

/// Instructions a tick.
pub(super) const PER_TICK: u32 = 40;
/// SysTick has 24 bits.
const MASK: u32 = 0x00FF_FFFF;

const CONTROL: *mut u32 = 0xE000_E010 as *mut u32;
const RELOAD: *mut u32 = 0xE000_E014 as *mut u32;
const CURRENT: *mut u32 = 0xE000_E018 as *mut u32;

/// Starts the counter.
pub(super) fn start() {
    // SAFETY: the three are SysTick's registers on every Cortex-M; nothing else in this program uses them.
    unsafe {
        RELOAD.write_volatile(MASK);
        CURRENT.write_volatile(0);
        // Enabled, by the processor's clock, without an interrupt.
        CONTROL.write_volatile(0b101);
    }
}

/// The count, downwards.
pub(super) fn now() -> u32 {
    // SAFETY: a read of SysTick's counter has no effect.
    unsafe { CURRENT.read_volatile() }
}

/// Instructions between two counts that are less than a turn of the counter apart.
pub(super) fn between(earlier: u32, later: u32) -> u32 {
    (earlier.wrapping_sub(later) & MASK) * PER_TICK
}
