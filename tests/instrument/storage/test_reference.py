"""docs/reference/recording.md says what the files are like."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from instrument.plan import Plan
from instrument.storage import RecordingWriter, write_analysis
from protocols import CountBlock, DeviceIdentity, Truth
from tests.support import plain_hdf5 as plain

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "recording.md"


def write(path: Path) -> None:
    someone = DeviceIdentity(name="x", vendor="v", model="m")
    with RecordingWriter(
        path,
        Plan(frames=2, image_size=8),
        picture_time_s=50e-6,
        with_truth=True,
        devices={"modulator": someone, "counter": someone, "stage": someone},
    ) as writer:
        writer.append_raw(CountBlock(first_bin=0, counts=np.arange(12, dtype=np.uint32)))
        writer.append(np.arange(12.0))
        writer.finish(truth=Truth(displacement_px=np.zeros((2, 2)), image=np.eye(8)), interrupted="for the test")
    write_analysis(
        path,
        displacement_px=np.zeros((2, 2)),
        sigma_px=np.ones((2, 2)),
        image=np.eye(8),
        displacement_mm=np.ones((2, 2)),
        sigma_mm=np.ones((2, 2)),
    )


def test_the_example_of_the_page_runs_with_h5py_alone(tmp_path: Path) -> None:
    """Sums of 0..5 and 6..11, by an interpreter that cannot see our packages."""
    write(tmp_path / "run.h5")
    example = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[0]
    script = "import sys\nsys.modules['instrument'] = sys.modules['protocols'] = None\n" + example
    environment = {key: value for key, value in os.environ.items() if not key.startswith("COV")}
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("[15. 51.] {")


def test_the_page_names_every_dataset(tmp_path: Path) -> None:
    write(tmp_path / "run.h5")
    names: list[str] = []
    with plain.opened(tmp_path / "run.h5") as file:

        def note(name: str, item: object) -> None:
            if hasattr(item, "shape"):
                names.append(name)

        file.visititems(note)
    rows = [line.split("|")[1] for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    documented = {name for row in rows for name in re.findall(r"`/?([^`@]+)`", row)}
    identity = set(DeviceIdentity.model_fields)
    missing = [
        name
        for name in names
        if name not in documented
        and name.rsplit("/", 1)[1] not in documented
        and not (name.split("/")[1] == "instrument" and name.rsplit("/", 1)[1] in identity)
    ]
    assert missing == []
