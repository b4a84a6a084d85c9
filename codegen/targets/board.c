/* Start-up and semihosting for Cortex-M boards without an operating system (QEMU: mps2-an386, mps2-an500). */
#include "board.h"

#include <stddef.h>

extern uint32_t board_stack_top;
extern uint32_t board_data_load;
extern uint32_t board_data_start;
extern uint32_t board_data_end;
extern uint32_t board_bss_start;
extern uint32_t board_bss_end;

void board_reset(void);
void board_fault(void);

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)

typedef void (*handler)(void);

__attribute__((section(".vectors"), used)) static const handler vectors[16] = {
    (handler)(uintptr_t)&board_stack_top, board_reset, board_fault, board_fault, board_fault, board_fault, board_fault,
    NULL, NULL, NULL, NULL, board_fault, board_fault, NULL, board_fault, board_fault,
};

static int semihost(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_reset(void)
{
    const uint32_t *from = &board_data_load;
    for (uint32_t *to = &board_data_start; to < &board_data_end; ++to) {
        *to = *from++;
    }
    for (uint32_t *to = &board_bss_start; to < &board_bss_end; ++to) {
        *to = 0u;
    }
    CPACR |= 0xFu << 20; /* the floating-point unit */
    __asm__ volatile("dsb\n\tisb");
    board_exit(main());
}

void board_fault(void)
{
    board_text("fault\n");
    board_exit(70);
}

void board_start_counter(void)
{
    SYST_CSR = 0u;
    SYST_RVR = 0xFFFFFFu;
    SYST_CVR = 0u;
    SYST_CSR = 5u;
    while (SYST_CVR == 0u) {
    }
}

uint32_t board_ticks(void)
{
    return 0xFFFFFFu - SYST_CVR;
}

uint32_t board_tick_instructions(void)
{
    return 40u; /* 25 MHz core clock of these boards; one instruction is 1 ns of virtual time */
}

void board_text(const char *text)
{
    (void)semihost(4, text);
}

void board_number(uint32_t value)
{
    char digits[12];
    size_t k = sizeof digits - 1u;
    digits[k] = '\0';
    do {
        digits[--k] = (char)('0' + (char)(value % 10u));
        value /= 10u;
    } while (value != 0u);
    board_text(&digits[k]);
}

void board_exit(int status)
{
    const uint32_t block[2] = { 0x20026u, (uint32_t)status };
    (void)semihost(0x20, block);
    for (;;) {
    }
}
