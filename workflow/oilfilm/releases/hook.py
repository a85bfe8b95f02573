"""Send the summary of a scheduled run: to a webhook, or to a command such as a mail program."""

import shlex
import subprocess
import urllib.error
import urllib.request
from http.client import HTTPException
from typing import Any
from urllib.parse import urlsplit

from oilfilm.errors import OilfilmError

_TIMEOUT_S = 30
_HERE = {"localhost", "127.0.0.1", "::1"}


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A redirect could lead the summary to another host, or off https."""

    def redirect_request(self, *_: Any) -> None:
        return None


def send(hook: str, payload: str, text: str) -> None:
    """Send a summary once.

    Args:
        hook: An address, to which the JSON is posted, or a command, which reads the text. The
            command is split as a shell splits it, and no shell runs.
        payload: The summary as JSON.
        text: The summary for people.

    Raises:
        OilfilmError: It was not taken. An address may be a secret: only its host is named.
    """
    if "://" in hook.split(" ", maxsplit=1)[0]:
        _post(hook, payload)
    else:
        _pipe(hook, text)


def _post(address: str, payload: str) -> None:
    try:
        parts = urlsplit(address)
        host, scheme = parts.hostname or "", parts.scheme
    except ValueError:
        host, scheme = "", ""
    allowed = scheme == "https" or (scheme == "http" and host in _HERE)
    if not host or not allowed or not address.isascii() or " " in address:
        raise OilfilmError(
            f"--hook: found an address of {host or 'no host'} with {scheme or 'no scheme'!r}; "
            "expected https://HOST/... in ASCII without blanks (http only for this computer)."
        )
    headers = {"Content-Type": "application/json", "User-Agent": "oilfilm"}
    request = urllib.request.Request(  # noqa: S310 - the scheme is checked above
        address, payload.encode(), headers, method="POST"
    )
    try:
        with urllib.request.build_opener(_NoRedirect).open(request, timeout=_TIMEOUT_S):
            pass
    except urllib.error.HTTPError as error:
        raise OilfilmError(
            f"--hook: {host} answers {error.code} ({error.reason}), expected 2xx; check the "
            "address."
        ) from None
    except (OSError, ValueError, HTTPException) as error:
        # the text of some errors has the whole address
        reason = getattr(error, "reason", type(error).__name__)
        raise OilfilmError(
            f"--hook: {host} cannot be reached ({reason}). Check the address and the network."
        ) from None


def _pipe(command: str, text: str) -> None:
    try:
        arguments = shlex.split(command)
        done = subprocess.run(  # noqa: S603 - the user's own command, without a shell
            arguments or [""],
            input=text,
            text=True,
            errors="backslashreplace",
            capture_output=True,
            timeout=_TIMEOUT_S,
            check=False,
        )
    except (OSError, ValueError, subprocess.TimeoutExpired) as error:
        raise OilfilmError(f"--hook: {command!r} cannot be run ({error}).") from None
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines()[-1:] or ["it printed nothing"]
        raise OilfilmError(f"--hook: {command!r} ends with exit code {done.returncode}: {last[0]}")
