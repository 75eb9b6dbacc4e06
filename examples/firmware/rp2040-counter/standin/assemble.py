# SPDX-License-Identifier: BSD-3-Clause
"""Make counter.pio.h of counter.pio, as the SDK's pioasm does: ``python assemble.py OUT``.

Needs adafruit-circuitpython-pioasm.
"""

import re
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

assembler: Any = import_module("adafruit_pioasm")

PROGRAM = """static const uint16_t {name}_program_instructions[] = {{{words}}};
static const struct pio_program {name}_program = {{{name}_program_instructions, {length}, -1}};
static inline pio_sm_config {name}_program_get_default_config(uint offset) {{
    pio_sm_config c = pio_get_default_sm_config();
    sm_config_set_wrap(&c, offset + {target}, offset + {wrap});
    return c;
}}
"""

source = Path(__file__).parents[1].joinpath("counter.pio").read_text()
out = ['#include "hardware/pio.h"']
for text in re.split(r"(?m)^(?=\.program)", source)[1:]:
    lines = [line.split(";")[0].rstrip() for line in text.splitlines()]
    program: Any = assembler.Program("\n".join(line for line in lines if line))
    words = ", ".join(f"{word:#06x}" for word in program.assembled)
    target, wrap = program.pio_kwargs["wrap_target"], program.pio_kwargs["wrap"]
    name = text.split()[1]
    out.append(PROGRAM.format(name=name, words=words, length=len(program.assembled), target=target, wrap=wrap))
Path(sys.argv[1]).write_text("\n".join(out))
