"""The limit on BLAS threads is there while anybody wants it, and gone afterwards: seen in a fresh process, as tests hold it."""

import os
import subprocess
import sys

PROGRAM = """
from threading import Event, Thread
import numpy
from threadpoolctl import threadpool_info
from instrument.numerics import one_blas_thread

def threads():
    return sorted({pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"})

print(threads())
inside, leave = Event(), Event()

def first():
    with one_blas_thread():
        inside.set()
        leave.wait(10)

thread = Thread(target=first)
thread.start()
inside.wait(10)
with one_blas_thread():
    leave.set()
    thread.join()
    print(threads())  # the first has ended, the second goes on
print(threads())
try:
    with one_blas_thread(), one_blas_thread():
        print(threads())
        raise ValueError
except ValueError:
    print(threads())
"""


def test_blocks_that_overlap_or_fail_leave_blas_as_it_was() -> None:
    ran = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "2"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ran.stdout.split("\n")[:5] == ["[2]", "[1]", "[2]", "[1]", "[2]"]
