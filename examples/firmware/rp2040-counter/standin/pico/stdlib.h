/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * What counter.c uses of the Pico SDK, declared as the SDK does: for compiling it where the SDK is not. */
#ifndef STANDIN_STDLIB_H
#define STANDIN_STDLIB_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
typedef unsigned int uint;
typedef uint64_t absolute_time_t;
#define PICO_ERROR_TIMEOUT (-1)
bool stdio_init_all(void);
int getchar_timeout_us(uint32_t us);
absolute_time_t make_timeout_time_ms(uint32_t ms);
bool time_reached(absolute_time_t t);
#endif
