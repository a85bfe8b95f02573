"""Objects in S3-compatible storage: listed, read and written here and nowhere else in the library.

Credentials and the server's address come from the environment, where every S3 client looks for
them: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_ENDPOINT_URL_S3. No message quotes them. An
object appears under its name when all of it has arrived, so that none is ever half-written.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from oilfilm.errors import OilfilmError


def listing(address: str) -> dict[str, str]:
    """The objects below an address: name below it, and ETag, which changes with the content.

    Raises:
        OilfilmError: The bucket is missing, or the storage cannot be reached or refuses the key.
    """
    bucket, prefix = _place(address)
    start = f"{prefix}/" if prefix else ""
    with _in_words(address):
        pages = _client().get_paginator("list_objects_v2").paginate(Bucket=bucket, Prefix=start)
        return {
            each["Key"].removeprefix(start): each["ETag"]
            for page in pages
            for each in page.get("Contents", ())
            if not each["Key"].endswith("/")  # a folder's placeholder
        }


def need_bucket(address: str) -> None:
    """Refuse to go on where the bucket of an address cannot be used.

    Raises:
        OilfilmError: As `listing`.
    """
    bucket, prefix = _place(address)
    with _in_words(address):
        _client().list_objects_v2(Bucket=bucket, Prefix=prefix, MaxKeys=1)


def prepare(address: str) -> None:
    """Refuse to go on where nothing can be written to a place, before there is much to write.

    The object that it leaves there also keeps the bucket: Snakemake's plugin deletes one that is
    empty after it has removed an outdated result.

    Raises:
        OilfilmError: As `listing`.
    """
    bucket, prefix = _place(address)
    with _in_words(address):
        client = _client()
        # a server may make a missing bucket when an object is written: a misspelt name must not
        client.list_objects_v2(Bucket=bucket, Prefix=prefix, MaxKeys=1)
        client.put_object(Bucket=bucket, Key=f"{prefix}/.oilfilm".lstrip("/"), Body=b"")


def pieces(address: str, etag: str = "", largest: int | None = None) -> Iterator[bytes]:
    """The content of one object, a mebibyte at a time, so that it needs no memory of its size.

    Args:
        address: Where it is.
        etag: The ETag that it must have, if given.
        largest: Most bytes that are read, if given: a bucket of strangers may have any size in it.

    Raises:
        OilfilmError: It is missing, has another ETag or is larger, or as `listing`.
    """
    bucket, key = _place(address)
    read = 0
    with _in_words(address):
        answer = _client().get_object(Bucket=bucket, Key=key)
        if etag and answer["ETag"] != etag:
            raise OilfilmError(
                f"{address}: has changed since the run began. When it is complete, run snakemake "
                "again."
            )
        _refuse_larger(address, answer.get("ContentLength", 0), largest)
        for piece in answer["Body"].iter_chunks(1 << 20):
            read += len(piece)
            _refuse_larger(address, read, largest)
            yield piece


def _refuse_larger(address: str, size: int, largest: int | None) -> None:
    if largest is not None and size > largest:
        raise OilfilmError(
            f"{address}: has {size} bytes or more; expected at most {largest}. It was not read."
        )


def content(address: str, etag: str = "", largest: int | None = None) -> bytes:
    """The content of one object in memory; arguments and errors are those of `pieces`."""
    return b"".join(pieces(address, etag, largest))


def download(address: str, file: Path, largest: int) -> None:
    """Write the content of one object to a file; errors are those of `pieces`.

    Args:
        address: Where it is.
        file: The file; if an error occurs, a part of it may be left.
        largest: Most bytes that are written.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("wb") as written:
        written.writelines(pieces(address, largest=largest))


def upload(file: Path, address: str) -> None:
    """Write a file's content to an object, completely or not at all.

    Raises:
        OilfilmError: As `listing`.
    """
    with _in_words(address):
        _client().upload_file(str(file), *_place(address))


def _place(address: str) -> tuple[str, str]:
    """Bucket and key of an address such as s3://bucket/some/key."""
    bucket, _, key = address.removeprefix("s3://").partition("/")
    return bucket, key.rstrip("/")


@cache
def _client() -> Any:
    try:
        import boto3  # noqa: PLC0415 - only who keeps logs or results in a bucket has it
        from botocore.config import Config  # noqa: PLC0415
    except ModuleNotFoundError:
        raise OilfilmError(
            "Object storage needs an extra of oilfilm: pip install 'oilfilm[workflow,s3]'"
        ) from None
    # checksums that only AWS sends would be refused or stored as content elsewhere
    needed = {
        name: "when_required"
        for name in ("request_checksum_calculation", "response_checksum_validation")
    }
    try:
        # a session of its own: the default one keeps the key of an earlier environment
        return boto3.Session().client("s3", config=Config(connect_timeout=10, **needed))
    except ValueError:
        raise OilfilmError(
            "AWS_ENDPOINT_URL_S3: is not the address of a server; expected one such as "
            "https://s3.example.org."
        ) from None


class MissingObjectError(OilfilmError):
    """There is no object of this name."""


_REFUSED = {"403", "AccessDenied", "InvalidAccessKeyId", "SignatureDoesNotMatch", "ExpiredToken"}
_MISSING = {"404", "NoSuchKey"}


@contextmanager
def _in_words(address: str) -> Iterator[None]:
    """Turn what the client raises into sentences; of the answer they quote its code alone."""
    _client()
    from boto3.exceptions import Boto3Error  # noqa: PLC0415 - as in _client
    from botocore.exceptions import (  # noqa: PLC0415
        BotoCoreError,
        ClientError,
        NoCredentialsError,
        ParamValidationError,
        PartialCredentialsError,
    )

    bucket = f"s3://{_place(address)[0]}"
    try:
        yield
    except (NoCredentialsError, PartialCredentialsError):
        raise OilfilmError(
            f"{bucket}: there are no credentials. Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY."
        ) from None
    except ParamValidationError:
        # what is no name of a bucket may be a key, so it is not quoted
        raise OilfilmError(
            "The address of a place in object storage has no valid bucket name; expected "
            "s3://BUCKET/PLACE, without a key or a server."
        ) from None
    except (BotoCoreError, ClientError, Boto3Error, OSError) as error:
        # an upload says why it failed in the error that it comes from
        code = next((each for each in map(_code, (error, error.__context__)) if each), "")
        if code in _MISSING:
            raise MissingObjectError(f"{address}: there is no such object.") from None
        if code == "NoSuchBucket":
            fault = f"{bucket}: there is no such bucket. Make it, or correct its name."
        elif code in _REFUSED:
            fault = (
                f"{bucket}: the storage refuses the key ({code}). Check AWS_ACCESS_KEY_ID, "
                "AWS_SECRET_ACCESS_KEY, AWS_ENDPOINT_URL_S3 and what the key may do."
            )
        else:
            fault = (
                f"{address}: the storage did not answer to the end ({code or _kind(error)}). Check "
                "AWS_ENDPOINT_URL_S3 and the network, then run again: what is complete is kept."
            )
        raise OilfilmError(fault) from None


def _code(error: BaseException | None) -> str:
    """The code of an answer that says no; empty where there was none."""
    answer = getattr(error, "response", None)
    return str(answer.get("Error", {}).get("Code", "")) if isinstance(answer, dict) else ""


def _kind(error: BaseException) -> str:
    return type(error.__context__ or error).__name__
