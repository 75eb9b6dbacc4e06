"""The rows of a benchmark for TVAL3: as a MAT file, and run under Octave where the user has both."""

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.io import loadmat, savemat

from protocols import Floats, Singles

SETTINGS: dict[str, float] = {
    "mu": 2.0**8,
    "beta": 2.0**5,
    "tol": 1e-6,
    "maxit": 1025,
    "TVnorm": 2,
    "nonneg": 1,
    "TVL2": 1,
}
"""Fields of TVAL3's options: its defaults but for the last two, non-negative images and noisy values."""

EXPAND = """
data = load('{mat}');
h = size(data.down, 2); w = size(data.across, 2); m = size(data.down, 1);
A = zeros(m, h * w);
for k = 1:m
  A(k, :) = reshape(double(data.down(k, :))' * double(data.across(k, :)), 1, []);
end
b = double(data.values(:));
"""
"""Octave and MATLAB code that builds the matrix: row k is the outer product of row k of ``down`` and of ``across``."""

RUN = """
addpath(genpath('{folder}'));
opts = data.settings; opts.mu = {mu};
opts.nonneg = logical(opts.nonneg); opts.TVL2 = logical(opts.TVL2); opts.disp = false;
tic; [image, out] = TVAL3(A, b, h, w, opts); took_s = toc;
save('-v6', '{answer}', 'image', 'took_s');
"""


@dataclass(frozen=True, eq=False)
class OctaveRun:
    """What TVAL3 gave."""

    image: Floats
    """``(height, width)``."""

    took_s: float
    """Of the solver alone."""


@dataclass(frozen=True, eq=False)
class Written:
    """Whitened rows, each the outer product of two factors, their values, and the image that they are of."""

    down: Singles
    """``(rows, height)``."""

    across: Singles
    """``(rows, width)``; the weights are in here, so that an image is a transmission 0 to 1."""

    values: Singles
    """``(rows,)``: with noise of variance 1."""

    truth: Floats
    """``(height, width)``."""

    def write(self, path: Path) -> None:
        """Write all as a MAT file, with the settings for TVAL3."""
        contents = {
            "down": self.down,
            "across": self.across,
            "values": self.values[:, None],
            "truth": self.truth,
            "settings": SETTINGS,
        }
        savemat(path, contents, do_compression=True)


def run_octave(octave: str, folder: Path, written: Written, *, mu: float) -> OctaveRun:
    """Run TVAL3 once, with a mu of its own scaled problem.

    Raises:
        subprocess.CalledProcessError: Octave or TVAL3 failed; its words are on the terminal.
    """
    with tempfile.TemporaryDirectory() as there:
        mat, answer, script = (Path(there) / name for name in ("rows.mat", "answer.mat", "run.m"))
        written.write(mat)
        code = EXPAND.format(mat=mat) + RUN.format(folder=folder.resolve(), mu=mu, answer=answer)
        script.write_text(code, encoding="utf-8")
        subprocess.run([octave, "--no-gui", "--quiet", str(script)], check=True)
        found = loadmat(answer)
    return OctaveRun(np.asarray(found["image"], np.float64), float(np.asarray(found["took_s"]).item()))
