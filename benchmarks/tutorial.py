"""The tutorial "a picture of your own", followed to the letter in a new clone, and timed.

python -m benchmarks.tutorial

Commands and files are taken out of the page itself. The clone is of this repository, so that the net's time for it is not in
the figures; that of pip for the packages is.
"""

import re
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs" / "tutorials" / "own-picture.md"
PICTURE: Final = "own/run-summary.png"
_BLOCK: Final = re.compile(r"^```(sh|toml|python|console)\n(.*?)^```", re.DOTALL | re.MULTILINE)


def commands_of(page: str) -> list[tuple[str, str]]:
    """Give ("type", command), and ("write", file and text) or ("draw", Python) for what is done between commands, in order."""
    steps: list[tuple[str, str]] = []
    for kind, body in _BLOCK.findall(page):
        if kind == "sh":
            steps += [("type", line) for line in body.splitlines()]
        elif kind == "console":
            steps += [("type", line[2:]) for line in body.splitlines() if line.startswith("$ ")]
        else:
            steps.append(("write" if kind == "toml" else "draw", body))
    return steps


def follow(page: str, folder: Path) -> list[tuple[str, float]]:
    """Do it all in one shell, which begins in ``folder``; give each command with its seconds.

    Raises:
        RuntimeError: a command failed; it is named with what it printed.
    """
    clone, times = folder / "kinopix", list[tuple[str, float]]()
    with subprocess.Popen(["bash"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as shell:
        for kind, text in commands_of(page):
            if kind == "write":
                path = clone / text.split("\n", 1)[0].removeprefix("# ")
                path.parent.mkdir(exist_ok=True)
                path.write_text(text, encoding="utf-8")
                continue
            begin = time.monotonic()
            _type(shell, text if kind == "type" else f"python - <<'END'\n{text}\nEND")
            if kind == "type":
                times.append((text, time.monotonic() - begin))
    return times


def _type(shell: subprocess.Popen[str], command: str) -> None:
    """Type a command, and wait until it is done."""
    if shell.stdin is None or shell.stdout is None:
        raise RuntimeError("a shell without pipes")
    shell.stdin.write(command.replace("<this repository>", f"'{ROOT}'") + "\ncode=$?\necho\necho done $code\n")
    shell.stdin.flush()
    said: list[str] = []
    for line in shell.stdout:
        said.append(line)
        if line.startswith("done "):
            break
    if said[-1:] != ["done 0\n"]:
        raise RuntimeError("".join([f"$ {command}\n", *said]))


def main() -> None:
    """Print each command with its seconds, and the whole."""
    with tempfile.TemporaryDirectory() as folder:
        times = follow(PAGE.read_text(encoding="utf-8"), Path(folder))
        if not (Path(folder) / "kinopix" / PICTURE).is_file():
            raise SystemExit(f"{PICTURE} was not made")
    for command, seconds in times:
        print(f"{seconds:7.1f} s   {command}")
    print(f"{sum(seconds for _, seconds in times):7.1f} s   {len(times)} commands, to {PICTURE}")


if __name__ == "__main__":
    main()
