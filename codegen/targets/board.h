/* What a bare-metal target offers: text out, exit, and a count of executed instructions. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

void board_start_counter(void);
/* Ticks since board_start_counter; a tick is board_tick_instructions() instructions under qemu -icount shift=0. */
uint32_t board_ticks(void);
uint32_t board_tick_instructions(void);
void board_text(const char *text);
void board_number(uint32_t value);
void board_exit(int status);

int main(void);

#endif
