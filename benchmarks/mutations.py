"""Random small changes of the source, one at a time: which of them does a test notice?

``python -m benchmarks.mutations [--seed 1] [--count 30] [--paths instrument/schemes ...] [--tests tests/instrument ...]``

Run it from the repository's root. The copy of the tree that it changes lies in a temporary folder, together with all that its
tests write.

A change swaps a sign, a factor, a bound, an ``and``, a minimum or a truth value, or alters a number. What the type checker holds
(annotations, decorators, aliases of types) and the text of messages are left alone.
"""

import argparse
import ast
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Literal, TypeAlias

SOURCES: Final = ("protocols", "drivers", "sim_backends", "instrument", "kinopix")
"""Folders of source, and what is changed where nothing else is asked for."""

NOT_SOURCE: Final = "protocols/conformance"
"""Tests that lie among the source."""

_OPERATORS: Final[dict[type[ast.AST], tuple[str, str]]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.And: ("and", "or"),
    ast.Or: ("or", "and"),
}

_NAMES: Final = {
    "min": "max",
    "max": "min",
    "minimum": "maximum",
    "maximum": "minimum",
    "argmin": "argmax",
    "argmax": "argmin",
    "any": "all",
    "all": "any",
}

_SPARE_S: Final = 30.0
"""Time that a changed tree is given beyond three times that of the unchanged one, before it counts as noticed."""

Outcome: TypeAlias = Literal["killed", "killed by time", "SURVIVED"]


@dataclass(frozen=True)
class Mutant:
    """One change of one file."""

    path: str
    """File, relative to the root."""
    line: int
    """Line of the change, from 1."""
    start: int
    """First byte that is replaced."""
    old: str
    """Text that stands there."""
    new: str
    """Text in its place."""

    def apply(self, source: bytes) -> bytes:
        """Give the changed source.

        Raises:
            ValueError: the old text does not stand there.
        """
        end = self.start + len(self.old.encode())
        if source[self.start : end].decode() != self.old:
            raise ValueError(f"{self.path}:{self.line}: expected {self.old!r}, saw {source[self.start : end]!r}")
        return source[: self.start] + self.new.encode() + source[end:]

    def describe(self, source: bytes) -> str:
        """Say where the change is and what it makes of its line."""
        after = self.apply(source).decode().splitlines()[self.line - 1].strip()
        return f"{self.path}:{self.line}: {self.old or 'nothing'} -> {self.new or 'nothing'}: {after}"


class _Finder:
    """Finds the places in one file where something can be changed."""

    def __init__(self, path: str, source: bytes) -> None:
        self._path = path
        self._source = source
        self._starts = [0]
        for line in source.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def find(self, node: ast.AST) -> Iterator[Mutant]:
        """Give the changes of a node and of all below it."""
        yield from self._of(node)
        for child in self._children(node):
            yield from self.find(child)

    @staticmethod
    def _children(node: ast.AST) -> Iterator[ast.AST]:
        """Give the nodes below, but for those that are left alone."""
        left_alone: list[ast.AST | None] = []
        match node:
            case ast.JoinedStr():
                return
            case ast.FunctionDef(decorator_list=decorators, returns=returns):
                left_alone = [*decorators, returns]
            case ast.ClassDef(decorator_list=decorators):
                left_alone = [*decorators]
            case ast.arg(annotation=annotation):
                left_alone = [annotation]
            case ast.AnnAssign(annotation=alias, value=value):
                left_alone = [alias, value if "TypeAlias" in ast.unparse(alias) else None]
            case _:
                pass
        yield from (child for child in ast.iter_child_nodes(node) if not any(child is left for left in left_alone))

    def _of(self, node: ast.AST) -> Iterator[Mutant]:
        match node:
            case ast.BinOp(left=left, op=op, right=right) | ast.AugAssign(target=left, op=op, value=right):
                yield from self._between(left, op, right)
            case ast.Compare(left=left, ops=ops, comparators=comparators):
                for first, comparison, second in zip([left, *comparators], ops, comparators, strict=False):
                    yield from self._between(first, comparison, second)
            case ast.BoolOp(op=junction, values=values):
                for first, second in pairwise(values):
                    yield from self._between(first, junction, second)
            case ast.UnaryOp(op=ast.USub()):
                yield self._at(node.lineno, self._start(node), "-", "")
            case ast.UnaryOp(op=ast.Not()):
                yield self._at(node.lineno, self._start(node), "not ", "")
            case ast.Constant(value=bool(value)):
                yield self._at(node.lineno, self._start(node), str(value), str(not value))
            case ast.Constant(value=int() | float() as value):
                old = self._source[self._start(node) : self._end(node)].decode()
                new = str(value + 1) if isinstance(value, int) else str(2 * value or 1.0)
                yield self._at(node.lineno, self._start(node), old, new)
            case ast.Name(id=name) if name in _NAMES:
                yield self._at(node.lineno, self._start(node), name, _NAMES[name])
            case ast.Attribute(attr=name) if name in _NAMES:
                end = self._end(node)
                yield self._at(node.end_lineno or node.lineno, end - len(name.encode()), name, _NAMES[name])
            case _:
                pass

    def _between(self, left: ast.expr, op: ast.AST, right: ast.expr) -> Iterator[Mutant]:
        if type(op) not in _OPERATORS:
            return
        old, new = _OPERATORS[type(op)]
        place = self._source.find(old.encode(), self._end(left), self._start(right))
        if place >= 0:
            yield self._at(self._source.count(b"\n", 0, place) + 1, place, old, new)

    def _start(self, node: ast.expr) -> int:
        return self._starts[node.lineno - 1] + node.col_offset

    def _end(self, node: ast.expr) -> int:
        return self._starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)

    def _at(self, line: int, start: int, old: str, new: str) -> Mutant:
        return Mutant(self._path, line, start, old, new)


def mutants_of(path: str, source: bytes) -> tuple[Mutant, ...]:
    """Give every change that can be made in a file, in the order of the text."""
    return tuple(sorted(_Finder(path, source).find(ast.parse(source)), key=lambda mutant: mutant.start))


def choose(root: Path, paths: Sequence[str], count: int, seed: int) -> list[Mutant]:
    """Choose changes at random, each one as likely as any other, among all that the files below ``paths`` allow.

    Raises:
        ValueError: nothing there can be changed.
    """
    every: list[Mutant] = []
    for path in paths:
        place = root / path
        for file in [place] if place.is_file() else sorted(place.rglob("*.py")):
            name = file.relative_to(root).as_posix()
            if not name.startswith(NOT_SOURCE):
                every += mutants_of(name, file.read_bytes())
    if not every:
        raise ValueError(f"{', '.join(paths)}: saw nothing to change; expected a file or folder of source")
    return random.Random(seed).sample(every, min(count, len(every)))


def belonging_tests(root: Path, path: str) -> tuple[str, ...]:
    """Give the tests that belong to a file: those named as it, then all of the folder that mirrors its own, or the next above."""
    folder = Path(path).parent
    while not any((root / "tests" / folder).rglob("test_*.py")):
        folder = folder.parent
    home = Path("tests") / folder
    by_name = home / f"test_{Path(path).stem}.py"
    first = (by_name.as_posix(),) if (root / by_name).exists() else ()
    contract = ("tests/conformance",) if path.startswith("protocols/") else ()
    return (*first, home.as_posix(), *contract)


class Tree:
    """A copy of the work tree whose files may be changed and tested."""

    def __init__(self, home: Path, root: Path) -> None:
        """Copy what git knows, and what it would take up.

        Args:
            home: empty folder for the copy and for all that its tests write.
            root: the work tree; it is only read.
        """
        self.root = home / "tree"
        self._home = home
        self._runs = 0
        listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        for name in subprocess.run(listed, cwd=root, check=True, capture_output=True).stdout.decode().split("\0"):
            if name and (root / name).is_file():
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, self.root / name)

    def passes(self, tests: Sequence[str], *, timeout_s: float | None = None, recompile: bool = False) -> bool:
        """Run tests, and tell whether all passed.

        Args:
            tests: files and folders.
            timeout_s: longest time; None for any.
            recompile: keep no machine code of other runs: what is written out inside another function would be the old one.

        Raises:
            TimeoutError: they take longer.
        """
        self._runs += 1
        numba_folder = self._home / (f"numba-{self._runs}" if recompile else "numba")
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-cov"]
        started = subprocess.Popen(
            [*command, f"--basetemp={self._home / 'tests'}", *dict.fromkeys(tests)],
            cwd=self.root,
            env={
                **os.environ,
                "PYTHONPATH": str(self.root),
                "PYTHONDONTWRITEBYTECODE": "1",
                "NUMBA_CACHE_DIR": str(numba_folder),
                "TMPDIR": str(self._home),
            },
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            return started.wait(timeout_s) == 0
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"tests took longer than {timeout_s} s") from None
        finally:
            if started.poll() is None:
                os.killpg(started.pid, signal.SIGKILL)
                started.wait()
            if recompile:
                shutil.rmtree(numba_folder, ignore_errors=True)

    def try_out(self, mutant: Mutant, tests: Sequence[str], timeout_s: float) -> Outcome:
        """Make a change, run the tests, and take the change back."""
        file = self.root / mutant.path
        source = file.read_bytes()
        file.write_bytes(mutant.apply(source))
        try:
            machine_code = b"compiled" in source or b"inlined" in source
            return "SURVIVED" if self.passes(tests, timeout_s=timeout_s, recompile=machine_code) else "killed"
        except TimeoutError:
            return "killed by time"
        finally:
            file.write_bytes(source)


def main() -> None:
    """Print the fate of each change, and how many were noticed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="other seeds choose other changes")
    parser.add_argument("--count", type=int, default=30, help="how many changes")
    parser.add_argument("--paths", nargs="+", default=list(SOURCES), help="files and folders to change")
    parser.add_argument("--tests", nargs="+", help="tests to run, instead of those that belong to the changed file")
    asked = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it, tests send it
    root = Path.cwd()
    mutants = choose(root, asked.paths, asked.count, asked.seed)
    times_s: dict[tuple[str, ...], float] = {}
    killed = 0
    with TemporaryDirectory(prefix="kinopix-mutations-") as home:
        tree = Tree(Path(home), root)
        for mutant in mutants:
            tests = tuple(asked.tests or belonging_tests(root, mutant.path))
            if tests not in times_s:
                begin_s = time.monotonic()
                if not tree.passes(tests):
                    sys.exit(f"{' '.join(tests)}: expected tests that pass before anything is changed; these fail.")
                times_s[tests] = time.monotonic() - begin_s
            outcome = tree.try_out(mutant, tests, 3 * times_s[tests] + _SPARE_S)
            killed += outcome != "SURVIVED"
            print(f"{outcome:8}  {mutant.describe((root / mutant.path).read_bytes())}", flush=True)
    print(f"{killed} of {len(mutants)} killed")


if __name__ == "__main__":
    main()
