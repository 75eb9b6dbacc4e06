/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * What counter.c uses of the Pico SDK, on the registers of an RP2040 (data sheet, sections 2.5 and 3.7); UART0 in place of USB. */
#include <string.h>
#include <sys/stat.h>
#include <errno.h>
#include "hardware/clocks.h"
#include "hardware/dma.h"
#include "hardware/pio.h"
#define REG(a) (*(volatile uint32_t *)(a))
#define UART 0x40034000u
int main(void);
extern uint32_t _sidata, _sdata, _edata, _sbss, _ebss, _end;
void reset(void);
__attribute__((section(".vectors"), used)) void *const vectors[48] = {(void *)0x20042000, (void *)reset};
void reset(void) {
    memcpy(&_sdata, &_sidata, (char *)&_edata - (char *)&_sdata);
    memset(&_sbss, 0, (char *)&_ebss - (char *)&_sbss);
    main();
    for (;;) {}
}
void *_sbrk(int n) { static char *at = (char *)&_end; char *was = at; at += n; return was; }
int _write(int f, const char *s, int n) { (void)f; for (int i = 0; i < n; i++) { while (REG(UART + 0x18) & 0x20) {} REG(UART) = (unsigned char)s[i]; } return n; }
int _read(int f, char *s, int n) { (void)f; (void)s; (void)n; return 0; }
int _close(int f) { (void)f; return -1; }
int _fstat(int f, struct stat *s) { (void)f; s->st_mode = S_IFIFO; return 0; }
int _isatty(int f) { (void)f; return 0; }
int _lseek(int f, int o, int w) { (void)f; (void)o; (void)w; return 0; }
void _exit(int c) { (void)c; for (;;) {} }
int _kill(int p, int s) { (void)p; (void)s; return -1; }
int _getpid(void) { return 1; }
bool stdio_init_all(void) { REG(0x4000c000) &= ~((1u << 10) | (1u << 22) | (1u << 2) | (1u << 5) | (1u << 8)); REG(UART + 0x2c) = 0x70; REG(UART + 0x30) = 0x301; return true; }
int getchar_timeout_us(uint32_t us) { (void)us; return REG(UART + 0x18) & 0x10 ? PICO_ERROR_TIMEOUT : (int)(REG(UART) & 0xFF); }
static uint64_t now_us(void) { return REG(0x40054028); }
absolute_time_t make_timeout_time_ms(uint32_t ms) { return now_us() + 1000u * ms; }
bool time_reached(absolute_time_t t) { return now_us() >= t; }
uint32_t clock_get_hz(enum clock_index c) { (void)c; return 125000000; }
uint pio_add_program(PIO pio, const pio_program_t *p) {
    static uint top = 32;
    top -= p->length;
    for (uint i = 0; i < p->length; i++) {
        uint16_t w = p->instructions[i];
        pio->instr_mem[top + i] = (w & 0xe000) ? w : w + top; /* jumps are relative to the program */
    }
    return top;
}
void pio_gpio_init(PIO pio, uint pin) { (void)pio; REG(0x4001c004 + 4 * pin) = 0x56; REG(0x40014004 + 8 * pin) = 6; }
void pio_sm_init(PIO pio, uint sm, uint pc, const pio_sm_config *c) {
    pio->ctrl &= ~(1u << sm);
    pio->sm[sm].clkdiv = c->clkdiv; pio->sm[sm].execctrl = c->execctrl; pio->sm[sm].shiftctrl = c->shiftctrl; pio->sm[sm].pinctrl = c->pinctrl;
    pio->sm[sm].shiftctrl ^= 0x80000000u; pio->sm[sm].shiftctrl ^= 0x80000000u; /* clears the FIFOs */
    pio->ctrl |= 1u << (4 + sm); pio->ctrl |= 1u << (8 + sm);
    pio_sm_exec(pio, sm, pc); /* jmp pc */
}
void pio_sm_put_blocking(PIO pio, uint sm, uint32_t data) { while (pio->fstat & 1u << (16 + sm)) {} pio->txf[sm] = data; }
void pio_sm_exec(PIO pio, uint sm, uint instr) { pio->sm[sm].instr = instr; }
uint pio_get_dreq(PIO pio, uint sm, bool tx) { (void)pio; return sm + (tx ? 0 : 4); }
void pio_enable_sm_mask_in_sync(PIO pio, uint32_t m) { pio->ctrl |= m << 8 | m; }
pio_sm_config pio_get_default_sm_config(void) { return (pio_sm_config){1u << 16, 31u << 12, 1u << 18 | 1u << 19, 5u << 26}; }
void sm_config_set_wrap(pio_sm_config *c, uint t, uint w) { c->execctrl = (c->execctrl & ~(0x3ffu << 7)) | t << 7 | w << 12; }
void sm_config_set_in_pins(pio_sm_config *c, uint b) { c->pinctrl = (c->pinctrl & ~(31u << 15)) | b << 15; }
void sm_config_set_in_shift(pio_sm_config *c, bool r, bool a, uint t) { c->shiftctrl = (c->shiftctrl & ~(1u << 18 | 1u << 16 | 31u << 20)) | (uint)r << 18 | (uint)a << 16 | (t & 31u) << 20; }
void sm_config_set_fifo_join(pio_sm_config *c, enum pio_fifo_join j) { c->shiftctrl = (c->shiftctrl & 0x3fffffffu) | (uint)j << 30; }
dma_channel_hw_t *dma_channel_hw_addr(uint ch) { return (dma_channel_hw_t *)(0x50000000u + 0x40 * ch); }
int dma_claim_unused_channel(bool r) { static int n; (void)r; return n++; }
dma_channel_config dma_channel_get_default_config(uint ch) { return (dma_channel_config){1u | 2u << 2 | 1u << 4 | ch << 11 | 0x3fu << 15}; }
static void put(dma_channel_config *c, uint shift, uint mask, uint v) { c->ctrl = (c->ctrl & ~(mask << shift)) | v << shift; }
void channel_config_set_transfer_data_size(dma_channel_config *c, enum dma_channel_transfer_size s) { put(c, 2, 3, s); }
void channel_config_set_read_increment(dma_channel_config *c, bool i) { put(c, 4, 1, i); }
void channel_config_set_write_increment(dma_channel_config *c, bool i) { put(c, 5, 1, i); }
void channel_config_set_ring(dma_channel_config *c, bool w, uint b) { put(c, 6, 15, b); put(c, 10, 1, w); }
void channel_config_set_dreq(dma_channel_config *c, uint d) { put(c, 15, 0x3f, d); }
void dma_channel_configure(uint ch, const dma_channel_config *c, volatile void *w, const volatile void *r, uint n, bool t) {
    dma_channel_hw_t *hw = dma_channel_hw_addr(ch);
    hw->read_addr = (uint32_t)r; hw->write_addr = (uint32_t)w; hw->transfer_count = n;
    if (t) hw->ctrl_trig = c->ctrl;
}
