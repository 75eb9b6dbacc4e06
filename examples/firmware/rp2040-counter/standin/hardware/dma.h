/* SPDX-License-Identifier: BSD-3-Clause
 * Copyright The Kinopix authors
 *
 * As pico/stdlib.h; registers of the data sheet, section 2.5.7. */
#ifndef STANDIN_DMA_H
#define STANDIN_DMA_H
#include "pico/stdlib.h"
typedef struct { volatile uint32_t read_addr, write_addr, transfer_count, ctrl_trig; } dma_channel_hw_t;
typedef struct { uint32_t ctrl; } dma_channel_config;
enum dma_channel_transfer_size { DMA_SIZE_8 = 0, DMA_SIZE_16 = 1, DMA_SIZE_32 = 2 };
dma_channel_hw_t *dma_channel_hw_addr(uint channel);
int dma_claim_unused_channel(bool required);
dma_channel_config dma_channel_get_default_config(uint channel);
void channel_config_set_transfer_data_size(dma_channel_config *c, enum dma_channel_transfer_size size);
void channel_config_set_read_increment(dma_channel_config *c, bool incr);
void channel_config_set_write_increment(dma_channel_config *c, bool incr);
void channel_config_set_ring(dma_channel_config *c, bool write, uint size_bits);
void channel_config_set_dreq(dma_channel_config *c, uint dreq);
void dma_channel_configure(uint channel, const dma_channel_config *config, volatile void *write_addr, const volatile void *read_addr, uint transfer_count, bool trigger);
#endif
