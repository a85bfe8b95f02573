"""What every script does around its call: provenance, and mistakes in a sentence."""

import errno
from pathlib import Path
from types import SimpleNamespace

import pytest

from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.run.job import job


class Files(list[str]):
    """Inputs or outputs of a job, some of them with names."""

    def __init__(self, *unnamed: str, **named: str) -> None:
        super().__init__([*unnamed, *named.values()])
        self.named = named

    def get(self, name: str, default: object = None) -> object:
        return self.named.get(name, default)


def a_job(tmp_path: Path) -> SimpleNamespace:
    return SimpleNamespace(
        log=[str(tmp_path / "job.log")],
        rule="fit",
        input=Files(),
        output=Files(),
        wildcards={"oil": "4102"},
        params=SimpleNamespace(
            config={"campaign": {"name": "june", "data": "measured"}}, code="0123"
        ),
    )


def test_provenance_tells_measured_from_simulated_and_knows_no_clock(tmp_path: Path) -> None:
    with job(a_job(tmp_path)) as one, job(a_job(tmp_path)) as another:
        first = one.provenance
        assert first == another.provenance
        assert (first["campaign"], first["data"], first["rule"]) == ("june", "measured", "fit")


def inputs_of(top: Path, shares: list[list[str]], wildcards: dict[str, str]) -> dict[str, str]:
    """Inputs in the provenance of a job that reads the points of some shares of the logs."""
    collect = a_job(top)
    collect.wildcards = wildcards
    for number, logs in enumerate(shares):
        path = top / f"results/june/parts/points/{len(shares)}-{number}.parquet"
        about = {"campaign": "june", "data": "measured", "rule": "points", "code": "c"}
        inputs = {f"data/raw/june/{log}": log * 4 for log in logs}
        part = {**about, "settings": "s", "part": True, "inputs": inputs}
        tables.write(tables.empty_table("points"), "points", path, part)
        collect.input.append(str(path))
    with job(collect) as of_job:
        return dict(of_job.provenance["inputs"])


@pytest.fixture
def copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where Snakemake puts local copies of results that are in object storage."""
    monkeypatch.chdir(tmp_path)
    return Path(".snakemake/storage/s3/lab/all")


def test_provenance_names_the_logs_whatever_shares_they_were_read_in(copies: Path) -> None:
    together = inputs_of(copies, [["a", "b", "c"]], {})
    assert together.keys() == {"rule points", "data/raw/june"}
    assert inputs_of(copies, [["c"], ["a", "b"]], {}) == together
    assert inputs_of(copies, [["c"], ["a"]], {}) != together
    # a part names each, so that what joins the parts can
    assert inputs_of(copies, [["a"]], {"share": "3"}).keys() == {"rule points", "data/raw/june/a"}


@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        (OSError(errno.ENOSPC, "-", "points.parquet"), "The disk is full. Make room on it ("),
        (OSError(errno.EDQUOT, "-", "points.parquet"), "The quota on this disk is used up. Make"),
        (OSError(errno.EROFS, "-", "points.parquet"), "The disk can only be read. Mount it for"),
        (OSError(errno.EFBIG, "-", "points.parquet"), "A file would be larger than is allowed"),
        (MemoryError("points.parquet"), "There is not enough memory for this step"),
        (OilfilmError("june.csv, row 3: found x; correct it."), "june.csv, row 3: found x"),
    ],
)
def test_what_the_user_can_mend_ends_a_job_in_a_sentence_and_in_the_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], fault: Exception, sentence: str
) -> None:
    with pytest.raises(SystemExit) as ended, job(a_job(tmp_path)):
        raise fault
    assert ended.value.code == 1
    assert capsys.readouterr().err.startswith(sentence)
    assert (tmp_path / "job.log").read_text(encoding="utf-8").startswith(sentence)


@pytest.mark.parametrize("fault", [FileNotFoundError(errno.ENOENT, "nothing"), ZeroDivisionError()])
def test_fault_of_the_program_keeps_its_traceback(tmp_path: Path, fault: Exception) -> None:
    with pytest.raises(type(fault)), job(a_job(tmp_path)):
        raise fault


def test_result_that_was_changed_by_hand_is_used_by_no_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    table, listing = Path("results/june/tables/points.parquet"), "results/june/made/collect.sha256"
    table.parent.mkdir(parents=True)
    Path("results/june/made").mkdir()
    collect, fit = a_job(tmp_path), a_job(tmp_path)
    collect.output = Files(str(table), made=listing)
    fit.input = Files(str(table))
    fit.output = Files(made="results/june/made/fit.sha256")
    with job(collect):
        table.write_bytes(b"as written")
    with job(fit):
        pass
    table.write_bytes(b"by hand")
    with pytest.raises(SystemExit), job(fit):
        pytest.fail("the step has begun")
    said = capsys.readouterr().err
    assert said.startswith("results/june/tables/points.parquet: is not as its step wrote it")
    assert f"Remove it and {listing}" in said
