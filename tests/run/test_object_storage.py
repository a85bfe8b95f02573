"""Logs and releases in object storage: the same names and bytes as in folders, or a sentence."""

import io
import shutil
import tracemalloc
from collections.abc import Iterator
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

import pytest
from botocore.exceptions import ClientError
from botocore.response import StreamingBody

from oilfilm import object_storage
from oilfilm.cli import main
from oilfilm.errors import OilfilmError
from oilfilm.logs.raw_files import raw_files, stored_logs, unchanged_logs
from oilfilm.releases import rebuild, transfer
from oilfilm.releases.manifest import read_manifest
from oilfilm.releases.transfer import download_release, upload_release
from oilfilm.releases.verify import verify
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from releases import made, measured_run, project, rebuilding, released, runs_of
from storage_servers import (
    SECRET,
    Storage,
    cut_after,
    in_environment,
    keys_are_checked,
    moto_storage,
    seaweed_storage,
)

ROOT = Path(__file__).parents[2]
LOGS = {
    "b/second.csv": b"2",
    "b-side.csv": b"3",
    "a.csv": b"1",
    "Runs.CSV": b"file;oil\n",
    "README.md": b"read me",
    ".hidden": b"no log",
    "b/.cache/x.csv": b"no log",
}


@pytest.fixture(scope="module", params=["moto", pytest.param("weed", marks=pytest.mark.nightly)])
def server(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Storage]:
    folder = tmp_path_factory.mktemp("server")
    with moto_storage() if request.param == "moto" else seaweed_storage(folder) as storage:
        storage.client().create_bucket(Bucket="lab")
        yield storage


@pytest.fixture
def storage(server: Storage) -> Iterator[Storage]:
    """A server with one empty bucket, `lab`, which this process can use."""
    client = server.client()
    for key in server.files("lab"):
        client.delete_object(Bucket="lab", Key=key)
    with in_environment(server):
        yield server


@pytest.fixture
def release(tmp_path: Path) -> Path:
    settings = resolve(ROOT / "config", {"campaign": "demo"})
    raw = {"a.csv": b"1,2\n"}
    frames = {"runs": runs_of(raw, tmp_path)}
    return released(made(project(tmp_path / "project"), settings, raw, frames))


def test_logs_in_a_bucket_are_those_of_the_same_files_in_a_folder(
    storage: Storage, tmp_path: Path
) -> None:
    storage.put("lab", {f"logs/june/{name}": content for name, content in LOGS.items()})
    storage.put("lab", {"logs/june-torque/t.csv": b"another folder"})
    for name, content in LOGS.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(content)
    states, sheet = stored_logs("s3://lab/logs/june")
    # Folders before files whose names begin alike, as pathlib sorts.
    assert list(states) == raw_files(tmp_path) == ["a.csv", "b/second.csv", "b-side.csv"]
    assert sheet == "Runs.CSV"
    inputs: dict[str, str] = {}
    folder = Path("data/raw/june")
    read = dict(unchanged_logs(folder, states, "s3://lab/logs/june", inputs))
    assert read == {name: LOGS[name] for name in states}
    assert inputs["data/raw/june/a.csv"] == sha256(b"1").hexdigest()[:16]


def test_log_that_changes_after_the_listing_is_refused(storage: Storage) -> None:
    storage.put("lab", {"june/a.csv": b"1"})
    states, _ = stored_logs("s3://lab/june")
    storage.put("lab", {"june/a.csv": b"2"})
    with pytest.raises(OilfilmError, match=r"s3://lab/june/a.csv: has changed since the run began"):
        list(unchanged_logs(Path("data/raw/june"), states, "s3://lab/june"))


@pytest.mark.parametrize("name", ["../a.csv", "b//a.csv", "/a.csv", "b/./a.csv"])
def test_name_that_leads_out_of_the_campaign_is_refused(storage: Storage, name: str) -> None:
    with suppress(ClientError):
        storage.put("lab", {f"june/{name}": b"1"})
    if name not in object_storage.listing("s3://lab/june"):
        pytest.skip("the server does not keep such a name")
    with pytest.raises(OilfilmError, match="is not a path below the campaign"):
        stored_logs("s3://lab/june")


def test_empty_place_is_refused(storage: Storage) -> None:
    with pytest.raises(OilfilmError, match="s3://lab/june: holds no logs"):
        stored_logs("s3://lab/june")


def test_missing_bucket_is_named(storage: Storage) -> None:
    with pytest.raises(OilfilmError, match="s3://nobody: there is no such bucket"):
        object_storage.need_bucket("s3://nobody/june")


def test_wrong_key_ends_in_a_sentence_without_it(storage: Storage) -> None:
    with (
        keys_are_checked(),
        in_environment(storage.with_wrong_key()),
        pytest.raises(OilfilmError, match=r"s3://lab: the storage refuses the key") as refused,
    ):
        object_storage.need_bucket("s3://lab")
    assert "AWS_SECRET_ACCESS_KEY" in str(refused.value)
    assert not any(word in str(refused.value) for word in (SECRET, storage.with_wrong_key().key))


@pytest.mark.parametrize("bucket", [f"key:{SECRET}@lab", "no bucket"])
def test_address_without_a_bucket_is_refused_and_not_quoted(storage: Storage, bucket: str) -> None:
    with pytest.raises(OilfilmError, match=r"expected s3://BUCKET/PLACE") as refused:
        object_storage.need_bucket(f"s3://{bucket}/june")
    assert bucket not in str(refused.value)


def test_missing_credentials_are_named(storage: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name)
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    monkeypatch.setenv("AWS_SHARED_CREDENTIALS_FILE", "/nowhere")
    object_storage._client.cache_clear()
    with pytest.raises(OilfilmError, match="Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"):
        object_storage.need_bucket("s3://lab")


def test_server_that_is_not_there_is_named(storage: Storage) -> None:
    gone = Storage("http://127.0.0.1:9")
    with (
        in_environment(gone),
        pytest.raises(OilfilmError, match=r"did not answer to the end .*AWS_ENDPOINT_URL_S3"),
    ):
        object_storage.need_bucket("s3://lab")


def test_large_object_is_not_there_when_its_upload_is_cut(storage: Storage, tmp_path: Path) -> None:
    file = tmp_path / "large.parquet"
    file.write_bytes(bytes(20_000_000))  # sent in parts
    with (
        cut_after(storage, 12_000_000) as cut,
        in_environment(cut),
        pytest.raises(OilfilmError, match=r"s3://lab/large.parquet: the storage did not answer"),
    ):
        object_storage.upload(file, "s3://lab/large.parquet")
    assert storage.files("lab") == {}
    object_storage.upload(file, "s3://lab/large.parquet")
    assert storage.files("lab") == {"large.parquet": file.read_bytes()}


def test_release_comes_back_as_it_was(storage: Storage, release: Path, tmp_path: Path) -> None:
    place = "s3://lab/releases/demo/v1-0"
    assert upload_release(release, place)
    assert not upload_release(release, place)
    download_release(place, tmp_path / "again")
    assert verify(tmp_path / "again") == []
    for path in release.rglob("*"):
        if path.is_file():
            assert (
                tmp_path / "again" / path.relative_to(release)
            ).read_bytes() == path.read_bytes()


def test_release_whose_upload_was_cut_is_none_and_the_next_upload_completes_it(
    storage: Storage, release: Path, tmp_path: Path
) -> None:
    place = "s3://lab/releases/demo/v1-0"
    sizes = [path.stat().st_size for path in release.rglob("*") if path.is_file()]
    with (
        cut_after(storage, sum(sizes) // 2) as cut,
        in_environment(cut),
        pytest.raises(OilfilmError, match="did not answer to the end"),
    ):
        upload_release(release, place)
    begun = storage.files("lab", "releases/demo/v1-0/")
    assert 0 < len(begun) < len(sizes)
    # What is there is whole, and no manifest makes a release of it.
    assert all(content == (release / name).read_bytes() for name, content in begun.items())
    with pytest.raises(OilfilmError, match=r"manifest.json: there is no such object"):
        download_release(place, tmp_path / "again")
    assert not (tmp_path / "again").exists()
    assert upload_release(release, place)
    download_release(place, tmp_path / "again")
    assert verify(tmp_path / "again") == []


def test_release_that_was_altered_in_the_bucket_is_refused(
    storage: Storage, release: Path, tmp_path: Path
) -> None:
    upload_release(release, "s3://lab/v1-0")
    storage.put("lab", {"v1-0/summary.txt": b"FINE\n"})
    with pytest.raises(OilfilmError, match=r"is not as it was released: summary.txt: differs"):
        download_release("s3://lab/v1-0", tmp_path / "again")
    assert not (tmp_path / "again").exists()


def test_objects_larger_than_their_manifest_says_are_not_read(
    storage: Storage, release: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    upload_release(release, "s3://lab/v1-0")
    larger = (release / "summary.txt").read_bytes() + b" "
    storage.put("lab", {"v1-0/summary.txt": larger})
    with pytest.raises(OilfilmError, match=rf"summary.txt: has {len(larger)} bytes or more"):
        download_release("s3://lab/v1-0", tmp_path / "again")
    monkeypatch.setattr(transfer, "LARGEST", 10)
    with pytest.raises(
        OilfilmError, match=r"manifest.json: has \d+ bytes or more; expected at most 10"
    ):
        download_release("s3://lab/v1-0", tmp_path / "again")
    assert not (tmp_path / "again").exists()


def test_release_that_the_disk_has_no_room_for_is_not_begun(
    storage: Storage, release: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    upload_release(release, "s3://lab/v1-0")
    manifest, _ = read_manifest(release)
    needed = sum(record.size for record in manifest.files)
    full = SimpleNamespace(free=needed - 1)
    monkeypatch.setattr(transfer.shutil, "disk_usage", lambda _: full)
    with pytest.raises(OilfilmError, match=rf"needs {needed} bytes, and the disk of .* has"):
        download_release("s3://lab/v1-0", tmp_path / "again")
    assert not (tmp_path / "again").exists()


class Zeros(io.RawIOBase):
    """So many bytes of an answer, made when they are read."""

    def __init__(self, left: int) -> None:
        self.left = left

    def read(self, size: int = -1) -> bytes:
        size = self.left if size < 0 else min(size, self.left)
        self.left -= size
        return bytes(size)


def test_large_object_goes_to_a_file_in_little_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = 1 << 26
    answer = {"Body": StreamingBody(Zeros(size), size), "ContentLength": size}
    client = SimpleNamespace(get_object=lambda **_: answer)
    monkeypatch.setattr(object_storage, "_client", lambda: client)
    tracemalloc.start()
    try:
        object_storage.download("s3://lab/large", tmp_path / "large", size)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert (tmp_path / "large").stat().st_size == size
    assert peak < size / 8


def test_answer_that_does_not_say_its_size_is_read_up_to_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    endless = Zeros(1 << 40)
    client = SimpleNamespace(get_object=lambda **_: {"Body": StreamingBody(endless, None)})
    monkeypatch.setattr(object_storage, "_client", lambda: client)
    with pytest.raises(OilfilmError, match="expected at most 1000"):
        object_storage.download("s3://lab/large", tmp_path / "large", 1000)


def test_release_whose_download_is_cut_leaves_nothing(
    storage: Storage, release: Path, tmp_path: Path
) -> None:
    upload_release(release, "s3://lab/v1-0")
    sizes = [path.stat().st_size for path in release.rglob("*") if path.is_file()]
    with (
        cut_after(storage, received=sum(sizes) // 2) as cut,
        in_environment(cut),
        pytest.raises(OilfilmError, match="did not answer to the end"),
    ):
        download_release("s3://lab/v1-0", tmp_path / "new" / "again")
    assert list((tmp_path / "new").iterdir()) == []


def test_manifest_that_leads_out_of_its_folder_brings_nothing(
    storage: Storage, release: Path, tmp_path: Path
) -> None:
    upload_release(release, "s3://lab/v1-0")
    manifest = (release / "manifest.json").read_text(encoding="utf-8")
    for path in ("../summary.txt", str(tmp_path / "summary.txt")):
        altered = manifest.replace('"path": "summary.txt"', f'"path": "{path}"')
        storage.put("lab", {"v1-0/manifest.json": altered.encode()})
        with pytest.raises(OilfilmError, match="expected a path below the folder"):
            download_release("s3://lab/v1-0", tmp_path / "below" / "again")
    assert [path for path in tmp_path.rglob("summary.txt") if "project" not in path.parts] == []


def test_place_of_another_release_is_left_as_it_is(storage: Storage, release: Path) -> None:
    storage.put("lab", {"v1-0/manifest.json": b"another"})
    with pytest.raises(OilfilmError, match="has another release than"):
        upload_release(release, "s3://lab/v1-0")
    assert storage.files("lab") == {"v1-0/manifest.json": b"another"}


@pytest.mark.parametrize(
    "address", ["s3://key:secret@lab/june", "lab/june", "https://lab", "s3://"]
)
def test_place_is_a_bucket_without_credentials(address: str) -> None:
    with pytest.raises(OilfilmError, match=r"storage.raw"):
        resolve(ROOT / "config", {"campaign": "demo", "storage": {"raw": address}})


@pytest.fixture
def bucket_of_a_laboratory(
    storage: Storage, config: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[Storage, str]:
    """Logs and their release are in the bucket alone; the place of the release."""
    run = measured_run(config, tmp_path / "project", {"a.csv": b"1,2\n", "b.csv": b"3,4\n"})
    upload_release(released(run), "s3://lab/releases/v1-0")
    shutil.rmtree(run.root / "results")
    for path in run.raw:
        storage.put("lab", {path.removeprefix("data/raw/"): (run.root / path).read_bytes()})
    shutil.rmtree(run.root / "data/raw")
    (run.root / "config").mkdir()
    settings = "campaign: demo\nstorage: {raw: s3://lab}\n"
    (run.root / "config/config.yaml").write_text(settings, encoding="utf-8")
    rebuilding(monkeypatch, run)
    rebuild._place_of_logs.cache_clear()
    monkeypatch.chdir(run.root)
    return storage, "s3://lab/releases/v1-0"


def test_release_in_a_bucket_is_rebuilt_from_logs_in_a_bucket(
    bucket_of_a_laboratory: tuple[Storage, str], capsys: pytest.CaptureFixture[str]
) -> None:
    storage, place = bucket_of_a_laboratory
    assert main(["verify", place, "--rebuild"]) == 0
    printed = capsys.readouterr().out
    assert "files are as released" in printed
    assert "rebuilt from the raw logs: the same bytes" in printed
    assert not Path("data/raw").exists()  # the project keeps no copy

    storage.put("lab", {"demo/b.csv": b"3,5\n"})
    assert main(["verify", place, "--rebuild"]) == 2
    assert "s3://lab/demo/b.csv: is not the log that release demo" in capsys.readouterr().err
    storage.client().delete_object(Bucket="lab", Key="demo/b.csv")
    assert main(["verify", place, "--rebuild"]) == 2
    assert "s3://lab/demo/b.csv: there is no such object" in capsys.readouterr().err


def test_release_that_was_altered_in_the_bucket_is_not_rebuilt(
    bucket_of_a_laboratory: tuple[Storage, str], capsys: pytest.CaptureFixture[str]
) -> None:
    storage, place = bucket_of_a_laboratory
    storage.put("lab", {"releases/v1-0/summary.txt": b"FINE\n"})
    assert main(["verify", place, "--rebuild"]) == 1
    printed = capsys.readouterr().out
    assert printed.startswith(f"{place}: 1 files are not as released:\nsummary.txt: differs")
    assert "rebuilt" not in printed


def test_rebuild_asks_for_the_place_of_logs_of_its_own_campaigns_only(tmp_path: Path) -> None:
    """A release of others may be of a campaign that the project does not have."""
    (tmp_path / "config").mkdir()
    settings = "campaign: demo\nstorage: {raw: s3://lab/logs}\n"
    (tmp_path / "config/config.yaml").write_text(settings, encoding="utf-8")
    assert rebuild._place_of_logs(tmp_path, "demo") == "s3://lab/logs"
    assert rebuild._place_of_logs(tmp_path, "of-others") is None


def test_place_of_the_logs_is_no_part_of_the_results() -> None:
    here = resolve(ROOT / "config", {"campaign": "demo"})
    there = resolve(ROOT / "config", {"campaign": "demo", "storage": {"raw": "s3://lab/logs"}})
    assert there.storage.raw == "s3://lab/logs"
    assert there.plain() == here.plain()
