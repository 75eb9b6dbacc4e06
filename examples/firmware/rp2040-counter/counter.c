/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * A photon counter by the protocol of docs/reference/serial-counter.md. Not run on a board yet: see README.md.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "counter.pio.h"
#include "hardware/clocks.h"
#include "hardware/dma.h"
#include "hardware/pio.h"
#include "pico/stdlib.h"

#define PULSE_PIN 2
#define SYNC_PIN 3
#define RING_BITS 15 /* bytes: 8192 words */
#define RING_WORDS (1u << (RING_BITS - 2))
#define LONGEST 64

static uint32_t ring[2][RING_WORDS] __attribute__((aligned(1u << RING_BITS)));
static const uint machine[2] = {0, 2}; /* pulses, ticks */
static int channel[2];

static bool armed, lost;
static uint32_t n_bins, edges, taken; /* edges: written out or counted; taken: words of the rings that were read */
static uint32_t last[2];

static uint8_t crc8(const char *text) {
    uint8_t crc = 0;
    for (; *text; text++) {
        crc ^= (uint8_t)*text;
        for (int bit = 0; bit < 8; bit++) crc = crc & 0x80 ? (uint8_t)(crc << 1 ^ 0x07) : (uint8_t)(crc << 1);
    }
    return crc;
}

static void say(const char *text) { printf("%s*%02X\n", text, crc8(text)); }

/* Words that a DMA channel has written since it was started. It counts down from the largest number, for 59 hours at 20 kHz. */
static uint32_t written(int which) { return UINT32_MAX - dma_channel_hw_addr(channel[which])->transfer_count; }

static void sync_machine(uint sm, uint target, uint offset) {
    pio_sm_config config = sync_program_get_default_config(offset);
    sm_config_set_in_pins(&config, SYNC_PIN);
    pio_sm_init(pio0, sm, offset, &config);
    /* Y: the instruction that pushes the target's X */
    pio_sm_put_blocking(pio0, sm, pio_encode_in(pio_x, 32));
    pio_sm_exec(pio0, sm, pio_encode_pull(false, true));
    pio_sm_exec(pio0, sm, pio_encode_mov(pio_y, pio_osr));
    int carrier = dma_claim_unused_channel(true);
    dma_channel_config dma = dma_channel_get_default_config(carrier);
    channel_config_set_transfer_data_size(&dma, DMA_SIZE_32);
    channel_config_set_read_increment(&dma, false);
    channel_config_set_write_increment(&dma, false);
    channel_config_set_dreq(&dma, pio_get_dreq(pio0, sm, false));
    dma_channel_configure(carrier, &dma, &pio0->sm[target].instr, &pio0->rxf[sm], UINT32_MAX, true);
}

static void counting_machine(int which, uint offset, pio_sm_config config) {
    uint sm = machine[which];
    sm_config_set_in_pins(&config, PULSE_PIN);
    sm_config_set_in_shift(&config, false, true, 32); /* the forced `in x, 32` pushes by itself */
    sm_config_set_fifo_join(&config, PIO_FIFO_JOIN_RX);
    pio_sm_init(pio0, sm, offset, &config);
    channel[which] = dma_claim_unused_channel(true);
    dma_channel_config dma = dma_channel_get_default_config(channel[which]);
    channel_config_set_transfer_data_size(&dma, DMA_SIZE_32);
    channel_config_set_read_increment(&dma, false);
    channel_config_set_write_increment(&dma, true);
    channel_config_set_ring(&dma, true, RING_BITS);
    channel_config_set_dreq(&dma, pio_get_dreq(pio0, sm, false));
    dma_channel_configure(channel[which], &dma, ring[which], &pio0->rxf[sm], UINT32_MAX, true);
}

/* Take the edges that have come: the first opens bin 0, each later one closes a bin. */
static void take(void) {
    uint32_t have = written(0) < written(1) ? written(0) : written(1);
    if (have - taken > RING_WORDS && armed && !lost && edges <= n_bins) {
        char text[LONGEST];
        snprintf(text, sizeof text, "overrun,%lu", (unsigned long)(edges ? edges - 1 : 0));
        say(text);
        lost = true;
    }
    while (taken != have) {
        uint32_t now[2] = {ring[0][taken % RING_WORDS], ring[1][taken % RING_WORDS]};
        taken++;
        if (!armed) continue;
        if (edges > 0 && edges <= n_bins && !lost) {
            char text[LONGEST]; /* both count down, modulo 2^32 */
            snprintf(text, sizeof text, "%lu,%lu,%lu", (unsigned long)(edges - 1), (unsigned long)(last[0] - now[0]),
                     (unsigned long)(last[1] - now[1]));
            say(text);
        }
        last[0] = now[0];
        last[1] = now[1];
        edges++;
    }
}

static void obey(char *line) {
    char text[LONGEST];
    char *star = strrchr(line, '*');
    if (star == NULL || strlen(star) != 3) return;
    *star = '\0';
    char check[3];
    snprintf(check, sizeof check, "%02X", crc8(line));
    if (strcmp(check, star + 1) != 0) return;
    if (strcmp(line, "id") == 0) {
        snprintf(text, sizeof text, "id,Kinopix,RP2040 counter,1,%lu", (unsigned long)(clock_get_hz(clk_sys) / 2));
        say(text);
    } else if (strcmp(line, "stop") == 0) {
        take();
        snprintf(text, sizeof text, "stopped,%lu", (unsigned long)(armed ? edges : 0));
        armed = false;
        say(text);
    } else if (strncmp(line, "arm,", 4) == 0) {
        char *end;
        unsigned long wanted = strtoul(line + 4, &end, 10);
        if (armed) {
            say("error,armed already");
        } else if (*end != '\0' || wanted == 0) {
            say("error,number of bins");
        } else {
            take(); /* what came before is forgotten */
            n_bins = wanted;
            edges = 0;
            lost = false;
            armed = true;
            snprintf(text, sizeof text, "armed,%lu", wanted);
            say(text);
        }
    } else {
        say("error,what");
    }
}

int main(void) {
    stdio_init_all();
    setvbuf(stdout, NULL, _IOFBF, 512);
    uint pulses = pio_add_program(pio0, &pulses_program);
    uint ticks = pio_add_program(pio0, &ticks_program);
    uint sync = pio_add_program(pio0, &sync_program);
    pio_gpio_init(pio0, PULSE_PIN);
    pio_gpio_init(pio0, SYNC_PIN);
    counting_machine(0, pulses, pulses_program_get_default_config(pulses));
    counting_machine(1, ticks, ticks_program_get_default_config(ticks));
    sync_machine(1, machine[0], sync);
    sync_machine(3, machine[1], sync);
    pio_enable_sm_mask_in_sync(pio0, 0xF);

    char line[LONGEST + 1];
    size_t length = 0;
    absolute_time_t flush = make_timeout_time_ms(10);
    while (true) {
        take();
        if (time_reached(flush)) {
            fflush(stdout);
            flush = make_timeout_time_ms(10);
        }
        int letter = getchar_timeout_us(0);
        if (letter == PICO_ERROR_TIMEOUT || letter == '\r') continue;
        if (letter != '\n') {
            if (length < sizeof line) line[length++] = (char)letter;
            continue;
        }
        if (length <= LONGEST) {
            line[length < sizeof line ? length : LONGEST] = '\0';
            obey(line);
        }
        length = 0;
        fflush(stdout);
    }
}
