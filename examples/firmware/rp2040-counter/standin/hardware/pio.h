/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * As pico/stdlib.h; registers of the data sheet, section 3.7. */
#ifndef STANDIN_PIO_H
#define STANDIN_PIO_H
#include "pico/stdlib.h"
typedef struct { volatile uint32_t clkdiv, execctrl, shiftctrl, addr, instr, pinctrl; } pio_sm_hw_t;
typedef struct {
    volatile uint32_t ctrl, fstat, fdebug, flevel, txf[4], rxf[4], irq, irq_force, input_sync_bypass, dbg_padout, dbg_padoe, dbg_cfginfo, instr_mem[32];
    pio_sm_hw_t sm[4];
} pio_hw_t;
typedef pio_hw_t *PIO;
#define pio0 ((PIO)0x50200000)
typedef struct { uint32_t clkdiv, execctrl, shiftctrl, pinctrl; } pio_sm_config;
struct pio_program { const uint16_t *instructions; uint8_t length; int8_t origin; };
typedef struct pio_program pio_program_t;
enum pio_src_dest { pio_pins = 0, pio_x = 1, pio_y = 2, pio_null = 3, pio_isr = 6, pio_osr = 7 };
enum pio_fifo_join { PIO_FIFO_JOIN_NONE = 0, PIO_FIFO_JOIN_TX = 1, PIO_FIFO_JOIN_RX = 2 };
uint pio_add_program(PIO pio, const pio_program_t *program);
void pio_gpio_init(PIO pio, uint pin);
void pio_sm_init(PIO pio, uint sm, uint initial_pc, const pio_sm_config *config);
void pio_sm_put_blocking(PIO pio, uint sm, uint32_t data);
void pio_sm_exec(PIO pio, uint sm, uint instr);
uint pio_get_dreq(PIO pio, uint sm, bool is_tx);
void pio_enable_sm_mask_in_sync(PIO pio, uint32_t mask);
pio_sm_config pio_get_default_sm_config(void);
void sm_config_set_wrap(pio_sm_config *c, uint wrap_target, uint wrap);
void sm_config_set_in_pins(pio_sm_config *c, uint in_base);
void sm_config_set_in_shift(pio_sm_config *c, bool shift_right, bool autopush, uint push_threshold);
void sm_config_set_fifo_join(pio_sm_config *c, enum pio_fifo_join join);
static inline uint pio_encode_in(enum pio_src_dest src, uint count) { return 0x4000u | (uint)src << 5 | (count & 31u); }
static inline uint pio_encode_pull(bool if_empty, bool block) { return 0x8080u | (if_empty ? 0x40u : 0) | (block ? 0x20u : 0); }
static inline uint pio_encode_mov(enum pio_src_dest dest, enum pio_src_dest src) { return 0xa000u | (uint)dest << 5 | (uint)src; }
#endif
