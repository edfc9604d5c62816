//! Start-up of a Cortex-M: vectors, floating point, memory as the program expects it, and a painted stack.

#![expect(unsafe_code, reason = "what runs before memory is as the language expects it has no safe form")]

use core::arch::global_asm;

/// Every word of the stack before the flight.
const PAINT: u32 = 0xA5A5_A5A5;

// Register 0xE000ED88 is CPACR: full access to coprocessors 10 and 11 turns floating point on. The stack is painted up to the
// stack pointer, then `flight` begins.
global_asm!(
    ".section .vectors, \"a\"",
    ".word stack_top",
    ".word reset",
    ".rept 14",
    ".word fault",
    ".endr",
    ".section .text.reset, \"ax\"",
    ".thumb_func",
    ".global reset",
    "reset:",
    "ldr r0, =0xE000ED88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xF00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "ldr r0, =data_start",
    "ldr r1, =data_end",
    "ldr r2, =data_image",
    "1: cmp r0, r1",
    "bhs 2f",
    "ldr r3, [r2], #4",
    "str r3, [r0], #4",
    "b 1b",
    "2: ldr r0, =bss_start",
    "ldr r1, =bss_end",
    "mov r2, #0",
    "3: cmp r0, r1",
    "bhs 4f",
    "str r2, [r0], #4",
    "b 3b",
    "4: ldr r0, =stack_bottom",
    "mov r1, sp",
    "ldr r2, ={paint}",
    "5: cmp r0, r1",
    "bhs 6f",
    "str r2, [r0], #4",
    "b 5b",
    "6: bl {flight}",
    ".thumb_func",
    "fault:",
    "ldr sp, =stack_top",
    "bl {fault}",
    paint = const PAINT,
    flight = sym super::flight,
    fault = sym super::fault,
);

unsafe extern "C" {
    static stack_bottom: u32;
    static stack_top: u32;
    static code_bytes: u8;
    static memory_bytes: u8;
}

/// Bytes of program and of memory, the stack's among them, as linked.
pub(super) fn linked_bytes() -> [usize; 2] {
    [(&raw const code_bytes).addr(), (&raw const memory_bytes).addr()]
}

/// Bytes of the stack that were used since the start: from the first word that is not paint any more.
pub(super) fn stack_used() -> usize {
    let (bottom, top) = (&raw const stack_bottom, &raw const stack_top);
    let mut word = bottom;
    // SAFETY: the words between the two symbols of the linker script are the stack's memory; the loop ends at the top.
    while word < top && unsafe { word.read_volatile() } == PAINT {
        word = word.wrapping_add(1);
    }
    top.addr() - word.addr()
}
