"""Do the tests see a fault? Small faults are put into some rooms one by one, and tests run.

Run by `make bench NAME=mutation`; prints per room how many faults the quick tests of that room see,
and names the others. The faults are those of cosmic-ray, a sample with a fixed seed: first a place,
then what is done there. Another tree with the same library (`--tree`) gets the same faults.

Takes two hours.
"""

import argparse
import ast
import importlib
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import Visitor, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[1]
# All modules of a room get faults, but not its drawings, which are compared as pictures. All quick
# tests of the room look for them, with the examples of its docstrings.
ROOMS = ("physics", "bearing", "logs", "curation", "fits", "torque", "deng2026_study")
# A test that takes so long has seen that something is wrong.
LONGEST_S = 300
# All that tests import and that no fault is in: imported once, for every run that is forked off.
IMPORTED = (
    *("pytest", "hypothesis.strategies", "numpy", "scipy.stats", "pandas", "pyarrow.csv"),
    *("pint", "pydantic", "yaml", "nptdms", "openpyxl", "matplotlib.pyplot"),
)


@dataclass(frozen=True)
class Fault:
    """One change of one module."""

    module: Path
    line: int
    operator: str
    occurrence: int

    def put_in(self, source: str) -> str:
        """The module's text with the fault."""
        return str(mutate_code(source, get_operator(self.operator)(), self.occurrence))


class _Places(Visitor):
    """Where each kind of fault can be, in the order in which cosmic-ray counts them."""

    def __init__(self, operator: str) -> None:
        self.operator, self.found = get_operator(operator)(), []

    def visit(self, node):
        self.found += self.operator.mutation_positions(node)
        return node


def lines_without_effect(source: str) -> set[int]:
    """Lines of type hints and docstrings, and of what only type checkers read."""
    lines: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        hints = [getattr(node, name, None) for name in ("annotation", "returns")]
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            hints.append(node)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            hints.append(node)
        for hint in hints:
            if isinstance(hint, ast.AST):
                lines.update(range(hint.lineno, hint.end_lineno + 1))
    return lines


def harmless_positions(source: str) -> set[tuple[int, int]]:
    """Where `strict=True` or `frozen=True` is: no result changes where sound code has False."""
    return {
        (node.value.lineno, node.value.col_offset)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.keyword) and node.arg in ("strict", "frozen")
    }


def faults_of(module: Path) -> Iterator[list[Fault]]:
    """The faults of a module, those of one place together."""
    source = module.read_text(encoding="utf-8")
    left_out, harmless = lines_without_effect(source), harmless_positions(source)
    tree = get_ast(source)
    places: dict[tuple[int, int], list[Fault]] = {}
    for name in sorted(operator_names()):
        if name.startswith("core/Variable"):  # these need names that they are told
            continue
        visitor = _Places(name)
        visitor.walk(tree)
        for occurrence, (start, _) in enumerate(visitor.found):
            if start[0] not in left_out and start not in harmless:
                places.setdefault(start, []).append(Fault(module, start[0], name, occurrence))
    yield from places.values()


def sample(modules: list[Path], count: int) -> list[Fault]:
    """As many faults, each at another place."""
    places = [place for module in modules for place in faults_of(module)]
    draw = random.Random(1)
    return [draw.choice(place) for place in draw.sample(places, min(count, len(places)))]


def tests_see_fault(tree: Path, tests: list[str]) -> bool:
    """Whether any of the tests fails, or does not end, in a process that is forked off."""
    child = os.fork()
    if child == 0:
        os.setsid()
        os.chdir(tree)
        for stream in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
        code = 1
        try:
            options = ["-x", "-q", "-p", "no:cacheprovider", "--no-header"]
            code = importlib.import_module("pytest").main([*options, *tests])
        finally:
            os._exit(int(code))
    end = time.monotonic() + LONGEST_S
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return status != 0
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return True


def score(tree: Path, room: str, count: int) -> None:
    """Print which faults of a room its tests do not see, and how many they see."""
    beside = tree / "workflow" / room
    library = beside if beside.is_dir() else tree / "workflow/oilfilm" / room
    modules = [each for each in sorted(library.rglob("*.py")) if each.parent.name != "figures"]
    files = [f"tests/{room}", str(library)]
    start = time.process_time() + sum(os.times()[2:4])
    if tests_see_fault(tree, files):
        sys.exit(f"{room}: the tests fail without any fault")
    # kept bytecode is of the library without faults
    sys.dont_write_bytecode = True
    faults, missed = sample(modules, count), []
    for fault in faults:
        content, stamps = fault.module.read_bytes(), fault.module.stat()
        fault.module.write_text(fault.put_in(content.decode()), encoding="utf-8")
        if not tests_see_fault(tree, files):
            missed.append(fault)
        fault.module.write_bytes(content)
        os.utime(fault.module, ns=(stamps.st_atime_ns, stamps.st_mtime_ns))
    sys.dont_write_bytecode = False
    for fault in sorted(missed, key=lambda fault: (fault.module, fault.line)):
        print(f"    not seen: {fault.module.name}:{fault.line} {fault.operator} {fault.occurrence}")
    cpu = time.process_time() + sum(os.times()[2:4]) - start
    share = 100 * (1 - len(missed) / len(faults))
    print(
        f"{room}: {len(faults) - len(missed)} of {len(faults)} faults seen ({share:.0f} %), "
        f"{cpu:.0f} s of CPU",
        flush=True,
    )


def main() -> None:
    """Score each room that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=100, help="how many in each room")
    parser.add_argument("--tree", type=Path, default=ROOT, help="clone whose tests are measured")
    parser.add_argument("rooms", nargs="*", default=ROOMS, help="default: all")
    given = parser.parse_args()
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    # plugins are of no use here, and pytest warns of one that is imported already
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    for name in IMPORTED:
        importlib.import_module(name)
    with tempfile.TemporaryDirectory(prefix="oilfilm-mutation-") as folder:
        tree = Path(folder, "tree")
        kept_out = (".git", ".venv*", "results", ".snakemake", "*_cache", ".hypothesis")
        shutil.copytree(given.tree, tree, ignore=shutil.ignore_patterns(*kept_out))
        for room in given.rooms:
            score(tree, room, given.faults)


if __name__ == "__main__":
    main()
