#include "hardware/pio.h"
static const uint16_t pulses_program_instructions[] = {0x2020, 0x20a0, 0x0040};
static const struct pio_program pulses_program = {pulses_program_instructions, 3, -1};
static inline pio_sm_config pulses_program_get_default_config(uint offset) {
    pio_sm_config c = pio_get_default_sm_config();
    sm_config_set_wrap(&c, offset + 0, offset + 2);
    return c;
}

static const uint16_t ticks_program_instructions[] = {0x0041, 0xa042};
static const struct pio_program ticks_program = {ticks_program_instructions, 2, -1};
static inline pio_sm_config ticks_program_get_default_config(uint offset) {
    pio_sm_config c = pio_get_default_sm_config();
    sm_config_set_wrap(&c, offset + 0, offset + 1);
    return c;
}

static const uint16_t sync_program_instructions[] = {0x2020, 0x20a0, 0xa0c2, 0x8000};
static const struct pio_program sync_program = {sync_program_instructions, 4, -1};
static inline pio_sm_config sync_program_get_default_config(uint offset) {
    pio_sm_config c = pio_get_default_sm_config();
    sm_config_set_wrap(&c, offset + 0, offset + 3);
    return c;
}
