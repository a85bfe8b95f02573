"""S3-compatible storage on this machine for tests: a server, and what a bucket holds."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

KEY, SECRET = "key-never-to-be-printed", "never-to-be-printed"
# Options of Snakemake: all results are in a bucket, whose address is the next argument.
IN_BUCKET = ("--default-storage-provider", "s3", "--default-storage-prefix")


class Storage:
    """The bucket `lab` of a running server."""

    def __init__(self) -> None:
        import boto3  # noqa: PLC0415
        from botocore.config import Config  # noqa: PLC0415

        config = Config(request_checksum_calculation="when_required")
        self.client: Any = boto3.client("s3", region_name="us-east-1", config=config)
        self.client.create_bucket(Bucket="lab")

    def put(self, files: Mapping[str, bytes]) -> None:
        for key, content in files.items():
            self.client.put_object(Bucket="lab", Key=key, Body=content)

    def files(self, prefix: str) -> dict[str, bytes]:
        """Every object below a prefix that ends with a slash: name below it, content."""
        pages = self.client.get_paginator("list_objects_v2").paginate(Bucket="lab", Prefix=prefix)
        content_by_name = {}
        for page in pages:
            for entry in page.get("Contents", ()):
                key = entry["Key"]
                stored = self.client.get_object(Bucket="lab", Key=key)
                content_by_name[key.removeprefix(prefix)] = stored["Body"].read()
        return content_by_name


def files_with_a_key(folder: Path) -> list[Path]:
    """Files in which the key or its secret can be read."""
    files = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    return [path for path, content in files.items() if SECRET.encode() in content]


@contextmanager
def moto_storage() -> Iterator[Storage]:
    """A server of moto in this process, which variables of this process name; it takes any key."""
    from moto.server import ThreadedMotoServer  # noqa: PLC0415

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    with pytest.MonkeyPatch.context() as patch:
        for name in [name for name in os.environ if name.startswith("AWS_")]:
            patch.delenv(name)
        host, port = server.get_host_and_port()
        patch.setenv("AWS_ENDPOINT_URL_S3", f"http://{host}:{port}")
        patch.setenv("AWS_ACCESS_KEY_ID", KEY)
        patch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)
        try:
            yield Storage()
        finally:
            server.stop()
