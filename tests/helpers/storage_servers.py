"""S3-compatible storage on this machine for tests: a server, and what a bucket holds."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import boto3
import pytest
from botocore.config import Config
from moto.server import ThreadedMotoServer

KEY, SECRET = "key-never-to-be-printed", "never-to-be-printed"
# All results in a bucket; the place is to follow.
IN_BUCKET = ("--default-storage-provider", "s3", "--default-storage-prefix")


@dataclass(frozen=True)
class Storage:
    """A running server and a key that it takes."""

    endpoint: str

    @property
    def environment(self) -> Mapping[str, str]:
        return {
            "AWS_ENDPOINT_URL_S3": self.endpoint,
            "AWS_ACCESS_KEY_ID": KEY,
            "AWS_SECRET_ACCESS_KEY": SECRET,
        }

    def client(self) -> Any:
        return boto3.client(
            "s3",
            endpoint_url=self.endpoint,
            aws_access_key_id=KEY,
            aws_secret_access_key=SECRET,
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


def files_with_a_key(folder: Path) -> list[Path]:
    """Files in which the key or its secret can be read."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return [
        path for path in files if any(word.encode() in path.read_bytes() for word in (KEY, SECRET))
    ]


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
def in_environment(storage: Storage) -> Iterator[None]:
    """The library of this process finds the storage, as by variables of a user."""
    with pytest.MonkeyPatch.context() as patch:
        for name in [name for name in os.environ if name.startswith("AWS_")]:
            patch.delenv(name)
        for name, value in storage.environment.items():
            patch.setenv(name, value)
        yield
