/* The host in place of a board: text to stderr; instructions are counted from outside, by valgrind. */
#include "board.h"

#include <stdio.h>
#include <stdlib.h>

void board_start_counter(void)
{
}

uint32_t board_ticks(void)
{
    return 0u;
}

uint32_t board_tick_instructions(void)
{
    return 0u;
}

void board_text(const char *text)
{
    (void)fputs(text, stderr);
}

void board_number(uint32_t value)
{
    (void)fprintf(stderr, "%lu", (unsigned long)value);
}

void board_exit(int status)
{
    exit(status);
}
