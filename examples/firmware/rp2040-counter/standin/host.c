/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * What counter.c uses of the Pico SDK, on a computer: standard input and output are the line, and on standard input the byte 1 and two
 * words of 32 bits stand for a sync edge that latched pulses and ticks. */
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include "hardware/clocks.h"
#include "hardware/dma.h"
#include "hardware/pio.h"

static dma_channel_hw_t channels[12];
static volatile uint32_t *rings[12];
static uint32_t ring_words[12];
static int claimed, ringed[2], n_ringed;

bool stdio_init_all(void) { return true; }

static int one(int wait_ms) {
    struct pollfd in = {0, POLLIN, 0};
    unsigned char byte;
    if (poll(&in, 1, wait_ms) < 1) return PICO_ERROR_TIMEOUT;
    if (read(0, &byte, 1) != 1) exit(0);
    return byte;
}

int getchar_timeout_us(uint32_t us) {
    (void)us;
    int byte = one(1);
    if (byte != 1) return byte;
    for (int which = 0; which < 2; which++) {
        uint32_t word = 0;
        for (int k = 0; k < 4; k++) word |= (uint32_t)one(-1) << 8 * k;
        int channel = ringed[which];
        rings[channel][(UINT32_MAX - channels[channel].transfer_count) % ring_words[channel]] = word;
        channels[channel].transfer_count--;
    }
    return PICO_ERROR_TIMEOUT;
}

absolute_time_t make_timeout_time_ms(uint32_t ms) { return ms; }
bool time_reached(absolute_time_t t) { (void)t; return true; }
uint32_t clock_get_hz(enum clock_index clock) { (void)clock; return 125000000; }
uint pio_add_program(PIO pio, const pio_program_t *program) { (void)pio; (void)program; return 0; }
void pio_gpio_init(PIO pio, uint pin) { (void)pio; (void)pin; }
void pio_sm_init(PIO pio, uint sm, uint pc, const pio_sm_config *config) { (void)pio; (void)sm; (void)pc; (void)config; }
void pio_sm_put_blocking(PIO pio, uint sm, uint32_t data) { (void)pio; (void)sm; (void)data; }
void pio_sm_exec(PIO pio, uint sm, uint instr) { (void)pio; (void)sm; (void)instr; }
uint pio_get_dreq(PIO pio, uint sm, bool is_tx) { (void)pio; (void)sm; (void)is_tx; return 0; }
void pio_enable_sm_mask_in_sync(PIO pio, uint32_t mask) { (void)pio; (void)mask; }
pio_sm_config pio_get_default_sm_config(void) { return (pio_sm_config){0, 0, 0, 0}; }
void sm_config_set_wrap(pio_sm_config *c, uint target, uint wrap) { (void)c; (void)target; (void)wrap; }
void sm_config_set_in_pins(pio_sm_config *c, uint base) { (void)c; (void)base; }
void sm_config_set_in_shift(pio_sm_config *c, bool right, bool push, uint threshold) { (void)c; (void)right; (void)push; (void)threshold; }
void sm_config_set_fifo_join(pio_sm_config *c, enum pio_fifo_join join) { (void)c; (void)join; }

dma_channel_hw_t *dma_channel_hw_addr(uint channel) { return &channels[channel]; }
int dma_claim_unused_channel(bool required) { (void)required; return claimed++; }
dma_channel_config dma_channel_get_default_config(uint channel) { (void)channel; return (dma_channel_config){0}; }
void channel_config_set_transfer_data_size(dma_channel_config *c, enum dma_channel_transfer_size size) { (void)c; (void)size; }
void channel_config_set_read_increment(dma_channel_config *c, bool incr) { (void)c; (void)incr; }
void channel_config_set_write_increment(dma_channel_config *c, bool incr) { (void)c; (void)incr; }
void channel_config_set_ring(dma_channel_config *c, bool write, uint size_bits) { if (write) c->ctrl = size_bits; }
void channel_config_set_dreq(dma_channel_config *c, uint dreq) { (void)c; (void)dreq; }
void dma_channel_configure(uint channel, const dma_channel_config *config, volatile void *to, const volatile void *from, uint count, bool start) {
    (void)from; (void)start;
    channels[channel].transfer_count = count;
    if (!config->ctrl) return; /* carries instructions from machine to machine */
    rings[channel] = to;
    ring_words[channel] = 1u << (config->ctrl - 2);
    ringed[n_ringed++] = (int)channel;
}
