"""Every Python that starts with this folder on its path can neither reach a network nor unpickle.

What it refuses it also writes to the file of OILFILM_GUARD. Snakemake hands a script its own
parameters as a pickle, made a moment before by the same user: classes of Snakemake are let through.
"""

import os
import sys
from collections.abc import Sequence
from typing import Any

_LOOPBACK = {"", "localhost", "127.0.0.1", "::1", "0.0.0.0", "::"}
_CONNECTS = {"socket.connect", "socket.sendto", "socket.sendmsg", "socket.bind"}
_LOOKS_UP = {"socket.getaddrinfo", "socket.gethostbyname", "socket.gethostbyaddr"}
_MAY_BE_UNPICKLED = {"snakemake", "builtins", "pathlib"}


def _refused(event: str, given: Sequence[Any]) -> str:
    if event in _CONNECTS:
        address = given[1]
        # the address of a Unix socket is a path
        if isinstance(address, tuple) and str(address[0]) not in _LOOPBACK:
            return f"{event} {address}"
    elif event in _LOOKS_UP:
        host = given[0]
        host = host.decode() if isinstance(host, bytes) else host
        if host is not None and host not in _LOOPBACK:
            return f"{event} {host}"
    elif event == "pickle.find_class" and given[0].split(".")[0] not in _MAY_BE_UNPICKLED:
        return f"{event} {given[0]}.{given[1]}"
    return ""


def _guard(event: str, given: tuple[Any, ...]) -> None:
    refused = _refused(event, given)
    if refused:
        with open(os.environ["OILFILM_GUARD"], "a", encoding="utf-8") as log:  # noqa: PTH123
            log.write(f"{sys.argv[0] if sys.argv else '-'}: {refused}\n")
        raise PermissionError(f"refused by the tests' guard: {refused}")


if "OILFILM_GUARD" in os.environ:
    sys.addaudithook(_guard)
