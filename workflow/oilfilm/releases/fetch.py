"""Copy a release from object storage; its folder appears when every file is as released."""

from pathlib import Path

import pyarrow as arrow
from pyarrow import fs

from oilfilm.atomic_write import atomic_folder
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.verify import verify


def fetch_release(address: str, folder: Path) -> None:
    """Copy a release and check every file of it.

    Args:
        address: Its place, as s3://bucket/releases/june/v1-0123456789ab. Credentials and server
            come from the environment, as for every S3 client.
        folder: A folder that does not exist yet.

    Raises:
        OilfilmError: The storage fails, it is no release, or a file is not as it was released.
    """
    if folder.exists():
        raise OilfilmError(f"{folder}: exists already. Name a new folder.")
    if not address.startswith("s3://") or "@" in address or "?" in address:
        # not quoted: it may hold a key
        raise OilfilmError(
            "The address of the release: expected s3://BUCKET/PLACE, without a key or a server. "
            "They are read from AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_ENDPOINT_URL_S3."
        )
    with atomic_folder(folder) as temporary:
        try:
            storage, place = fs.FileSystem.from_uri(address.rstrip("/"))
            fs.copy_files(place, str(temporary), storage, fs.LocalFileSystem())
        except (OSError, arrow.ArrowException) as error:
            raise OilfilmError(
                f"{address}: cannot be copied ({printable(error)[:300]}). Check the address, "
                "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_ENDPOINT_URL_S3 and the network, "
                "then try again."
            ) from None
        try:
            complaints = verify(temporary)
        except OilfilmError as fault:
            raise OilfilmError(str(fault).replace(str(temporary), address)) from None
        if complaints:
            raise OilfilmError(f"{address}: is not as it was released: {complaints[0]}")
