"""A release copied from object storage: whole and as released, or not at all."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from oilfilm.cli import main
from storage_servers import SECRET, Storage, moto_storage

PLACE = "s3://lab/releases/laboratory"


@pytest.fixture(scope="module")
def storage() -> Iterator[Storage]:
    with moto_storage() as server:
        yield server


@pytest.fixture(scope="module", autouse=True)
def in_the_bucket(release: Path, storage: Storage) -> None:
    """The release is in the bucket as well."""
    files = (path for path in release.rglob("*") if path.is_file())
    keys = {f"releases/laboratory/{path.relative_to(release).as_posix()}": path for path in files}
    storage.put({key: path.read_bytes() for key, path in keys.items()})


@pytest.mark.slow
def test_fetch_is_whole(release: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fetched = tmp_path / "fetched"
    assert main(["fetch", f"{PLACE}/", str(fetched)]) == 0
    assert "as released" in capsys.readouterr().out
    for path in release.rglob("*"):
        if path.is_file():
            assert path.read_bytes() == (fetched / path.relative_to(release)).read_bytes()
    assert main(["fetch", PLACE, str(fetched)]) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"summary.txt": b"fake\n"}, "summary.txt: differs"),
        ({"extra.txt": b"x"}, "extra.txt: is extra"),
        ({"manifest.json": b"{}"}, "manifest.json"),
    ],
    ids=["altered", "extra", "manifest"],
)
def test_release_that_is_not_as_released_makes_no_folder(
    storage: Storage,
    tmp_path: Path,
    change: dict[str, bytes],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    whole = storage.files("releases/laboratory/")
    files = {f"altered/{name}": content for name, content in (whole | change).items()}
    storage.put(files)
    assert main(["fetch", "s3://lab/altered", str(tmp_path / "fetched")]) == 2
    assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
    for name in change.keys() - whole.keys():
        storage.client.delete_object(Bucket="lab", Key=f"altered/{name}")


@pytest.mark.slow
@pytest.mark.parametrize(
    "address", ["s3://lab/nothing", "s3://nobody/x", f"s3://key:{SECRET}@lab/x", "june"]
)
def test_address_that_leads_nowhere_ends_in_a_sentence_without_a_key(
    storage: Storage, tmp_path: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fetch", address, str(tmp_path / "fetched")]) == 2
    printed = capsys.readouterr().err
    assert "AWS_ACCESS_KEY_ID" in printed
    assert SECRET not in printed
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["../../beside.txt", "tables/../../../beside.txt", "/x.txt"])
def test_path_that_leads_out_of_the_folder_is_refused_and_nothing_is_written(
    storage: Storage, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = storage.files("releases/laboratory/")
    keys = [f"outward/{path}" for path in (*whole, name)]
    storage.put(dict(zip(keys, [*whole.values(), b"x"], strict=True)))
    folder = tmp_path / "one/two/fetched"
    assert main(["fetch", "s3://lab/outward", str(folder)]) == 2
    printed = capsys.readouterr().err
    assert name in printed
    assert "leads out" in printed
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    storage.client.delete_object(Bucket="lab", Key=keys[-1])
