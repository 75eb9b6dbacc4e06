/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * libusb with one USB-CTR that gives a sample every 50 us, for benchmarks/counter_reads.py. What is not here is the real libusb's.
 *
 * The bus: a bulk transfer gets its packet in the microframe (125 us) after both are there, 13 packets a microframe at most, as
 * bulk packets of 512 bytes have (USB 2.0, table 5-10). A control transfer takes three. The board keeps 8192 samples, then it overruns.
 */
#define _GNU_SOURCE
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>

#define FRAME 125000LL
#define SAMPLE 50000LL
#define A_FRAME 13
#define FIFO 8192

struct transfer { /* struct libusb_transfer */
    void *handle; uint8_t flags; unsigned char endpoint, type; unsigned timeout; int status, length, actual;
    void (*callback)(struct transfer *); void *user; unsigned char *buffer; int iso;
};
struct queued { struct queued *next; struct transfer *transfer; long long since; int cancelled; };

static struct queued *first;
static long long start, last_frame = -1, transfers;
static int used, device, started, overrun;
static uint32_t scans, taken, packet_samples;

static long long now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec * 1000000000LL + t.tv_nsec; }
static void sleep_until(long long t) {
    struct timespec at = {t / 1000000000LL, t % 1000000000LL};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
}
/* When the next packet has come for a transfer that waits since then; -1: never. */
static long long comes(long long since) {
    if (!started || (scans && taken >= scans)) return -1;
    uint32_t samples = scans && taken + packet_samples > scans ? scans - taken : packet_samples;
    long long there = start + SAMPLE * (long long)(taken + samples), frame = (there > since ? there : since) / FRAME + 1;
    if (frame < last_frame) frame = last_frame;
    if (frame == last_frame && used >= A_FRAME) frame++;
    return (frame + 1) * FRAME;
}
static int take(unsigned char *buffer, long long at) {
    uint32_t produced = (uint32_t)((at - start) / SAMPLE), samples = packet_samples;
    if (produced - taken > FIFO && !(scans && produced > scans)) overrun = 1;
    if (scans && taken + samples > scans) samples = scans - taken;
    for (uint32_t k = 0; k < samples; k++) { buffer[2 * k] = (taken + k) % 251; buffer[2 * k + 1] = 0; }
    taken += samples;
    long long frame = at / FRAME - 1;
    used = frame == last_frame ? used + 1 : 1;
    last_frame = frame;
    transfers++;
    return 2 * (int)samples;
}
static int pop(int status, int actual) {
    struct queued *done = first;
    first = done->next;
    struct transfer *t = done->transfer;
    free(done);
    t->status = status;
    t->actual = actual;
    t->callback(t);
    return 1;
}
long long kinopix_transfers(void) { return transfers; }

int libusb_submit_transfer(struct transfer *t) {
    struct queued **end = &first, *made = malloc(sizeof *made);
    *made = (struct queued){NULL, t, now(), 0};
    while (*end) end = &(*end)->next;
    *end = made;
    return 0;
}
int libusb_cancel_transfer(struct transfer *t) {
    for (struct queued *q = first; q; q = q->next) if (q->transfer == t) { q->cancelled = 1; return 0; }
    return -5;
}
int libusb_handle_events_timeout(void *context, struct timeval *tv) {
    (void)context;
    long long deadline = now() + tv->tv_sec * 1000000000LL + tv->tv_usec * 1000LL;
    for (int done = 0;;) {
        if (!first) return 0;
        long long t = now(), at = first->cancelled ? t : comes(first->since);
        if (first->cancelled) done = pop(3, 0);
        else if (at >= 0 && at <= t) { int n = take(first->transfer->buffer, at); done = pop(0, n); }
        else if (done || t >= deadline) return 0;
        else sleep_until(at >= 0 && at < deadline ? at : deadline);
    }
}
int libusb_handle_events(void *context) { struct timeval tv = {1, 0}; return libusb_handle_events_timeout(context, &tv); }
int libusb_bulk_transfer(void *h, unsigned char e, unsigned char *data, int length, int *actual, unsigned timeout) {
    (void)h; (void)e; (void)length;
    long long since = now(), at = comes(since), deadline = since + timeout * 1000000LL;
    *actual = 0;
    if (at < 0 || at > deadline) { sleep_until(deadline); return -7; }
    sleep_until(at);
    *actual = take(data, at);
    return 0;
}
int libusb_control_transfer(void *h, uint8_t kind, uint8_t request, uint16_t v, uint16_t i, unsigned char *data, uint16_t n, unsigned t) {
    (void)h; (void)v; (void)i; (void)t;
    sleep_until((now() / FRAME + 3) * FRAME);
    if (kind & 0x80) {
        memset(data, 0, n);
        if (request == 0x40) { data[0] = (unsigned char)(0x02 | overrun << 2); data[1] = 1; }
        if (request == 0x48) memcpy(data, "01234567", 8);
        if (request == 0x10) { uint32_t edges = taken + 1; memcpy(data, &edges, 4); }
    } else if (request == 0x21) {
        memcpy(&scans, data, 4);
        packet_samples = data[12] + 1u;
        start = now(); taken = 0; started = 1; overrun = 0;
    } else if (request == 0x22) started = 0;
    return n;
}
long libusb_get_device_list(void *c, void ***list) { (void)c; *list = calloc(2, sizeof **list); **list = &device; return 1; }
void libusb_free_device_list(void **list, int unref) { (void)unref; free(list); }
int libusb_get_device_descriptor(void *d, unsigned char *out) {
    (void)d;
    static const unsigned char told[18] = {18, 1, 0, 2, 255, 255, 255, 64, 0xDB, 9, 0x27, 1, 1, 1, 1, 2, 3, 0};
    memcpy(out, told, sizeof told);
    return 0;
}
uint8_t libusb_get_bus_number(void *d) { (void)d; return 1; }
uint8_t libusb_get_port_number(void *d) { (void)d; return 1; }
uint8_t libusb_get_device_address(void *d) { (void)d; return 1; }
int libusb_get_device_speed(void *d) { (void)d; return 3; }
void *libusb_ref_device(void *d) { return d; }
void libusb_unref_device(void *d) { (void)d; }
int libusb_open(void *d, void **h) { (void)d; *h = &device; return 0; }
void libusb_close(void *h) { (void)h; }
int libusb_get_configuration(void *h, int *c) { (void)h; *c = 1; return 0; }
int libusb_claim_interface(void *h, int i) { (void)h; (void)i; return 0; }
int libusb_release_interface(void *h, int i) { (void)h; (void)i; return 0; }
int libusb_clear_halt(void *h, unsigned char e) { (void)h; (void)e; return 0; }
