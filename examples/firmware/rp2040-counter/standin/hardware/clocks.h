/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * As pico/stdlib.h. */
#ifndef STANDIN_CLOCKS_H
#define STANDIN_CLOCKS_H
#include "pico/stdlib.h"
enum clock_index { clk_sys = 5 };
uint32_t clock_get_hz(enum clock_index clock);
#endif
