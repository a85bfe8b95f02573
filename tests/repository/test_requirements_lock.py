"""The lock files against pyproject.toml and the installed packages, without a network."""

import re
import tomllib
from collections.abc import Iterable, Iterator
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PYPROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
RUN_LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
LOCK = (ROOT / "requirements-dev.lock").read_text(encoding="utf-8")
SLURM_LOCK = (ROOT / "requirements-slurm.lock").read_text(encoding="utf-8")
DOCS_LOCK = (ROOT / "requirements-docs.lock").read_text(encoding="utf-8")
S3_LOCK = (ROOT / "requirements-s3.lock").read_text(encoding="utf-8")
EVERY_EXTRA = ("report", "workflow", "clone", "s3", "dev")

Pins = dict[str, list[Requirement]]


def pins(lock: str) -> Pins:
    """The pinned versions of each package; more than one where markers tell them apart."""
    found: Pins = {}
    for line in re.findall(r"(?m)^[A-Za-z0-9][^\\\n]*", lock):
        pin = Requirement(line)
        found.setdefault(canonicalize_name(pin.name), []).append(pin)
    return found


def version(pin: Requirement) -> str:
    (specifier,) = pin.specifier
    assert specifier.operator == "==", f"{pin} is no pin"
    return specifier.version


def wanted(pyproject: str, extras: Iterable[str]) -> list[Requirement]:
    """What pyproject.toml asks for with these extras: to run, to develop, to build."""
    content = tomllib.loads(pyproject)
    project = content["project"]
    texts = [*project["dependencies"], *content["build-system"]["requires"]]
    for extra in extras:
        texts += project["optional-dependencies"][extra]
    # one extra of the project may name another
    return [each for each in map(Requirement, texts) if each.name != project["name"]]


def holds(requirement: Requirement, extras: set[str]) -> bool:
    """Whether a requirement applies on this machine, for a package installed with these extras."""
    return requirement.marker is None or any(
        requirement.marker.evaluate({"extra": extra}) for extra in extras | {""}
    )


def elsewhere(requirement: Requirement, extras: set[str]) -> bool:
    """Whether it may apply on another platform or Python."""
    named = set(re.findall(r"""extra == ["']([^"']+)["']""", str(requirement.marker)))
    return not named or bool(named & extras)


def dependencies(requirement: Requirement) -> Iterator[tuple[str, Requirement, bool]]:
    """What an installed package asks for in turn: by whom, what, and whether it applies here."""
    try:
        texts = metadata.requires(requirement.name) or []
    except metadata.PackageNotFoundError:
        return
    for text in texts:
        needed = Requirement(text)
        if holds(needed, requirement.extras):
            yield requirement.name, needed, True
        elif elsewhere(needed, requirement.extras):
            yield requirement.name, needed, False


def faults(pyproject: str, lock: str, extras: Iterable[str] = EVERY_EXTRA) -> list[str]:
    """Every way in which a lock does not fit pyproject.toml and the installed packages."""
    pinned = pins(lock)
    found = []
    reached: set[str] = set()
    seen: set[tuple[str, frozenset[str], bool]] = set()
    queue = [("pyproject.toml", each, holds(each, set())) for each in wanted(pyproject, extras)]
    while queue:
        asker, needed, here = queue.pop()
        name = canonicalize_name(needed.name)
        reached.add(name)
        candidates = [
            pin
            for pin in pinned.get(name, [])
            if not here or pin.marker is None or pin.marker.evaluate()
        ]
        # Elsewhere a Python older than ours may be meant, or a package that the resolver ruled out.
        if here and not any(needed.specifier.contains(version(pin), True) for pin in candidates):
            have = ", ".join(version(pin) for pin in candidates) or "nothing"
            found.append(f"{asker} asks for {needed}, the lock has {have}")
        key = (name, frozenset(needed.extras), here)
        if key not in seen:
            seen.add(key)
            # what is installed for another lock alone asks for nothing here
            queue += [(by, each, here and applies) for by, each, applies in dependencies(needed)]
    found += [f"nothing asks for {name}, which the lock has" for name in pinned.keys() - reached]
    return sorted(found)


def without(name: str, lock: str) -> str:
    return re.sub(rf"(?m)^{name}==.*\n(?: .*\n)*", "", lock)


def test_locks_fit_pyproject_and_the_installed_packages():
    assert not faults(PYPROJECT, LOCK), "requirements-dev.lock is stale: run `make lock`"
    running = ("report", "workflow", "clone")
    assert not faults(PYPROJECT, RUN_LOCK, running), "requirements.lock is stale: run `make lock`"


def test_packages_that_run_are_the_same_in_both_locks():
    dev = pins(LOCK)
    for name, pinned in pins(RUN_LOCK).items():
        assert [version(pin) for pin in pinned] == [version(pin) for pin in dev[name]]


def test_lock_of_object_storage_changes_no_package_that_runs():
    stored, running = pins(S3_LOCK), pins(RUN_LOCK)
    plugin = "snakemake-storage-plugin-s3"
    (asked,) = (each for each in wanted(PYPROJECT, ["s3"]) if each.name == plugin)
    assert asked.specifier.contains(version(stored[plugin][0])), "run `make lock`"
    shared = stored.keys() & running.keys()
    assert "snakemake" in shared
    assert {name: stored[name] for name in shared} == {name: running[name] for name in shared}


def test_extras_of_the_project_are_all_checked():
    project = tomllib.loads(PYPROJECT)["project"]
    assert set(project["optional-dependencies"]) == {*EVERY_EXTRA, "slurm", "docs"}


def test_lock_of_the_documentation_changes_no_package_of_the_others():
    site, others = pins(DOCS_LOCK), pins(LOCK)
    asked = {canonicalize_name(each.name): each for each in wanted(PYPROJECT, ["docs"])}
    for name in asked.keys() & site.keys():
        assert asked[name].specifier.contains(version(site[name][0])), "run `make lock`"
    shared = site.keys() & others.keys()
    assert {"matplotlib", "jinja2"} <= shared
    assert {"sphinx", "myst-nb"} <= site.keys() - others.keys()
    assert {name: [version(pin) for pin in site[name]] for name in shared} == {
        name: [version(pin) for pin in others[name]] for name in shared
    }


def test_lock_of_the_cluster_has_the_plugin_and_changes_no_package_that_runs():
    cluster, running = pins(SLURM_LOCK), pins(RUN_LOCK)
    plugin = "snakemake-executor-plugin-slurm"
    (asked,) = (each for each in wanted(PYPROJECT, ["slurm"]) if each.name == plugin)
    (pin,) = cluster[plugin]
    assert asked.specifier.contains(version(pin)), "run `make lock`"
    assert plugin not in pins(LOCK), "it slows down every test that runs snakemake"
    shared = cluster.keys() & running.keys()
    assert "snakemake" in shared
    assert {name: cluster[name] for name in shared} == {name: running[name] for name in shared}


@pytest.mark.parametrize(
    ("pyproject", "lock", "fault"),
    [
        (
            PYPROJECT.replace('"numpy>=', '"no-such-package>=1", "numpy>='),
            LOCK,
            "pyproject.toml asks for no-such-package>=1, the lock has nothing",
        ),
        (
            PYPROJECT.replace('"pytest>=', '"no-such-package>=1", "pytest>='),
            LOCK,
            "pyproject.toml asks for no-such-package>=1, the lock has nothing",
        ),
        (
            re.sub(r'"scipy>=[\d.]+"', '"scipy>=999"', PYPROJECT),
            LOCK,
            r"pyproject.toml asks for scipy>=999, the lock has \d.*",
        ),
        (
            re.sub(r' *"matplotlib>=.*\n', "", PYPROJECT),
            LOCK,
            "nothing asks for matplotlib, which the lock has",
        ),
        (PYPROJECT, without("smmap", LOCK), "gitdb asks for smmap.*, the lock has nothing"),
        (PYPROJECT, LOCK + "leftover==1.0\n", "nothing asks for leftover, which the lock has"),
    ],
    ids=[
        "new dependency",
        "new development tool",
        "raised bound",
        "dropped dependency",
        "lost package",
        "leftover package",
    ],
)
def test_stale_lock_is_noticed(pyproject: str, lock: str, fault: str):
    assert any(re.fullmatch(fault, found) for found in faults(pyproject, lock))


def test_locked_versions_are_the_installed_ones():
    # Else the test above reads the metadata of other versions than the lock's.
    installed = {canonicalize_name(each.name): each.version for each in metadata.distributions()}
    different = [
        f"{pin}: {installed.get(name)} is installed"
        for name, several in pins(LOCK).items()
        for pin in several
        if pin.marker is None or pin.marker.evaluate()
        if installed.get(name) != version(pin)
    ]
    assert not different, "run `make`"


def test_every_pin_has_hashes():
    blocks = re.findall(r"(?m)^[A-Za-z0-9].*\n(?: .*\n?)*", LOCK)
    assert len(blocks) == sum(map(len, pins(LOCK).values()))
    assert not [
        block.split()[0]
        for block in blocks
        if not re.search(r"--hash=sha256:[0-9a-f]{64}\b", block)
    ]


def test_lock_names_no_place_to_install_from():
    # No address, no option line (--index-url, --find-links), no direct reference, no path.
    assert not re.findall(r"(?m)^.*://.*$|^-.*$|^[^#\n]* @ .*$|^[^#\n]*/.*$", LOCK)


@pytest.mark.parametrize("name", ["rivals", "mutation"])
def test_packages_of_a_benchmark_are_shared_with_the_project(name: str) -> None:
    """benchmarks/fit.py and benchmarks/mutation.py run ours and theirs in one process."""
    lock = (ROOT / f"benchmarks/{name}.lock").read_text(encoding="utf-8")
    ours, theirs = pins(LOCK), pins(lock)
    shared = ours.keys() & theirs.keys()
    assert name != "rivals" or {"numpy", "scipy"} <= shared
    assert {name: [version(pin) for pin in ours[name]] for name in shared} == {
        name: [version(pin) for pin in theirs[name]] for name in shared
    }
    asked = (ROOT / f"benchmarks/{name}.in").read_text(encoding="utf-8").splitlines()
    assert {canonicalize_name(line) for line in asked if not line.startswith("#")} <= theirs.keys()
    assert "://" not in lock
