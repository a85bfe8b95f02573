"""Releases and tables of strangers: what is too much, or made to deceive, ends in a sentence."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest

from campaigns import ROOT
from nights import nightly
from oilfilm import read_fit
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
from oilfilm.releases.manifest import MANIFEST_FILE
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.resolved import Settings
from oilfilm.settings.yaml_file import as_yaml
from releases import alter_file

CONFIG = ["--config", str(ROOT / "config")]
# Markup, a template, an address that runs a script, and what steers a terminal or turns a line.
HOSTILE = "<img src=x onerror=alert(1)>{{ 7 * 7 }}\u202e\x1b[31m"


@pytest.fixture
def stranger(release: Path, tmp_path: Path) -> Path:
    """A copy of the release, for a stranger to change."""
    return shutil.copytree(release, tmp_path / "stranger")


def refusal(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """What a command prints that ends in a mistake: one short sentence that steers no terminal."""
    assert main([str(each) for each in arguments]) == 2
    printed = capsys.readouterr().err
    assert "Traceback" not in printed
    assert len(printed) < 3000
    assert printed.rstrip("\n").isprintable()
    return printed


# ---------------------------------------------------------------- manifest and configuration


@pytest.mark.parametrize("key", ["version", "made_from", "sha256"])
def test_key_that_a_manifest_has_twice_is_refused(
    stranger: Path, key: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Other readers of JSON take the first of the two: what they see is not what was checked."""
    path = stranger / MANIFEST_FILE
    content = json.loads(path.read_text(encoding="utf-8"))
    twice = f'{{\n  "{key}": {json.dumps(content[key])},'
    path.chmod(0o644)
    path.write_text(path.read_text(encoding="utf-8").replace("{", twice, 1), encoding="utf-8")
    assert "not as it was written" in refusal(capsys, "verify", stranger)


@pytest.mark.slow
@pytest.mark.parametrize("n_keys", [nightly(900_000), 2_400_000])
def test_manifest_of_very_many_keys_takes_little_memory(stranger: Path, n_keys: int) -> None:
    """Up to 27.7 MB of unknown keys: the promise is 600 MB."""
    path = stranger / MANIFEST_FILE
    path.chmod(0o644)
    keys = ",".join(f'"{number}":1' for number in range(n_keys))
    path.write_text(f"{{{keys}}}", encoding="utf-8")
    program = (
        "import pathlib, re; from oilfilm.cli import main\n"
        f"code = main(['verify', {str(stranger)!r}])\n"
        # the peak by `resource` counts that of the process that started this one
        "status = pathlib.Path('/proc/self/status').read_text()\n"
        "print(code, int(re.search(r'VmHWM:\\s*([0-9]+)', status)[1]) >> 10)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    code, peak_mib = map(int, done.stdout.split())
    assert (code, " keys" in done.stderr) == (2, True)
    assert peak_mib < 600


def test_configuration_made_to_deceive_is_refused(
    release: Path, stranger: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alter_file(stranger, "config.yaml", b"a: \x1b[31m\n")
    assert "not valid YAML" in refusal(capsys, "diff", release, stranger, *CONFIG)


def test_file_larger_than_any_of_a_release_is_not_opened(stranger: Path) -> None:
    opened = StoredRelease.open(stranger)
    large = opened.record_by_path["summary.txt"].model_copy(update={"size": (1 << 28) + 1})
    opened.record_by_path["summary.txt"] = large
    with pytest.raises(OilfilmError, match="268435457 bytes"):
        opened.checked_file("summary.txt")


NOWHERE = ("../../evil", "/evil", "a/b", "C:evil", "")


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    # a rebuild writes one file for each oil and rig
    [
        *({"oils": {name: {}}} for name in NOWHERE),
        {"campaign": {"name": "laboratory", "torque": None}},
        {"campaign": [["name", "laboratory"]]},
        {"shards": 4},
    ],
)
def test_rebuild_refuses_a_configuration_of_a_stranger_or_of_an_earlier_version(
    stranger: Path, config: Settings, changes: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    plain = config.plain_values()
    if names := changes.get("oils"):
        changes = {"oils": {**dict.fromkeys(names, plain["oils"]["4102"]), **plain["oils"]}}
    alter_file(stranger, "config.yaml", as_yaml(plain | changes).encode())
    printed = refusal(capsys, "verify", stranger, "--rebuild", "--cores", "1")
    assert "version of oilfilm" in printed
    assert "folder code/" in printed
    assert ("unknown key 'shards'" in printed) == ("shards" in changes)


# ---------------------------------------------------------------- tables


def written(path: Path, content: arrow.Table, table: str = "coefficients", **options: Any) -> Path:
    """A Parquet file that says it is a table of oilfilm."""
    footer = {"table": table, "campaign": "laboratory"}
    content = content.replace_schema_metadata({"oilfilm": json.dumps(footer)})
    path.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(content, path, **options)
    return path


def repeated(text: str, rows: int) -> arrow.Array:
    """One text in many rows, which a file holds once."""
    indices = arrow.array([0] * rows, arrow.int32())
    return arrow.DictionaryArray.from_arrays(indices, arrow.array([text]))


TOO_MUCH = {
    "columns": (arrow.table({f"c{number}": [1.0] for number in range(3_000)}), {}),
    "long text": (arrow.table({"oil": repeated("x" * 10_000, 200_000)}), {}),
    "lists": (arrow.table({"oil": [[["x"]]]}), {}),
    "parts": (arrow.table({"oil": ["x"] * 500, "law": ["x"] * 500}), {"row_group_size": 1}),
    "names": (arrow.table({HOSTILE: ["x"], "y" * 100_000: ["x"]}), {}),
    "values": (arrow.table({"oil": [HOSTILE]}), {}),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", TOO_MUCH)
def test_table_that_is_too_much_or_deceives_is_no_fit(kind: str, tmp_path: Path) -> None:
    content, options = TOO_MUCH[kind]
    for name in ("coefficients", "refits", "fit_quality"):
        written(tmp_path / f"tables/{name}.parquet", content, name, **options)
    with pytest.raises(OilfilmError) as refused:
        read_fit(tmp_path, "4102")
    assert len(str(refused.value)) < 3000
    assert all(line.isprintable() for line in str(refused.value).split("\n"))
