"""What a power failure could leave, by replaying the system calls of a program.

The disk is taken at its worst. Content that was not flushed since it was written may be lost or
torn. A name that was made, changed or removed may be there or not until its folder is flushed. A
name with a dot in front, or below such a one, is no promise to anybody.
"""

import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

CALLS = (
    "openat,write,pwrite64,writev,ftruncate,sendfile,copy_file_range,fsync,fdatasync,"
    "rename,renameat,renameat2,unlink,unlinkat,mkdir,mkdirat,symlink,symlinkat"
)
_CALL = re.compile(r"^\d+ +(?P<name>\w+)\((?P<arguments>.*)\) += (?P<result>\d+)")
_OPENED = re.compile(r"(?:\d+|AT_FDCWD)<(?P<path>[^>]*)>")
_QUOTED = re.compile(r'"(?P<path>[^"]*)"')
_WRITES = {"write", "pwrite64", "writev", "ftruncate", "sendfile"}


def traceable() -> bool:
    """Whether system calls of a program can be listed here."""
    if shutil.which("strace") is None:
        return False
    return subprocess.run(["strace", "-o", "/dev/null", "true"], check=False).returncode == 0


def trace(program: str, folder: Path, record: Path) -> list[str]:
    """The system calls of a Python program in a folder."""
    strace = ["strace", "-f", "-y", "-s", "4096", "-e", f"trace={CALLS}", "-o", str(record)]
    subprocess.run([*strace, sys.executable, "-c", program], cwd=folder, check=True)
    return record.read_text(encoding="utf-8", errors="replace").splitlines()


@dataclass
class Disk:
    """The worst that is on the disk below a folder.

    Attributes:
        root: The folder, below the one that the program ran in.
        torn: Files with content that is not flushed.
        loose: Names, made or removed, of which the disk may not know.
        renames: How many names were given by a rename.
        faults: What a power failure after one of the calls would break.
    """

    root: PurePosixPath
    torn: set[PurePosixPath] = field(default_factory=set)
    loose: set[PurePosixPath] = field(default_factory=set)
    renames: int = 0
    faults: list[str] = field(default_factory=list)

    def visible(self, path: PurePosixPath) -> bool:
        """Whether somebody relies on a name."""
        return not any(part.startswith(".") for part in path.relative_to(self.root).parts)

    def replay(self, calls: list[str]) -> None:
        """Follow a program, with a power failure after each of its calls."""
        for line in calls:
            if call := _CALL.match(line):
                self._follow(call["name"], call["arguments"])
                self.faults += [
                    f"torn: {path} after {line}" for path in self.torn if self.visible(path)
                ]
        self.faults += [f"may be missing: {path}" for path in self.loose if self.visible(path)]

    def _follow(self, name: str, arguments: str) -> None:
        opened = [PurePosixPath(each["path"]) for each in _OPENED.finditer(arguments)]
        named = [
            PurePosixPath(opened[0] if opened else self.root.parent, each["path"])
            for each in _QUOTED.finditer(arguments)
        ]
        if name in _WRITES:
            self._note(self.torn, opened[0])
        elif name == "copy_file_range":
            self._note(self.torn, opened[1])
        elif name == "openat" and "O_CREAT" in arguments:
            self._note(self.loose, named[0])
            if "O_TRUNC" in arguments:
                self._note(self.torn, named[0])
        elif name in {"fsync", "fdatasync"}:
            self.torn.discard(opened[0])
            self.loose -= {path for path in self.loose if path.parent == opened[0]}
        elif name.startswith("rename"):
            self._rename(named[0], named[1])
        elif name.startswith(("mkdir", "symlink")):
            self._note(self.loose, named[-1])
        elif name.startswith("unlink"):
            self.torn = {path for path in self.torn if not path.is_relative_to(named[0])}
            self.loose = {path for path in self.loose if not path.is_relative_to(named[0])}

    def _rename(self, old: PurePosixPath, new: PurePosixPath) -> None:
        if not new.is_relative_to(self.root):
            return
        self.renames += 1
        if self.visible(new):
            inside = {path for path in self.loose if path != old and path.is_relative_to(old)}
            self.faults += [f"renamed with {path} not flushed" for path in inside]
            before = {path for path in self.loose if path.parent == new.parent and path != old}
            self.faults += [
                f"{new} may be there without {path}" for path in before if self.visible(path)
            ]
        for known in (self.torn, self.loose):
            moved = {path for path in known if path.is_relative_to(old)}
            known.difference_update(moved)
            known.update(new / path.relative_to(old) for path in moved)
        self.loose.add(new)

    def _note(self, known: set[PurePosixPath], path: PurePosixPath) -> None:
        if path.is_relative_to(self.root):
            known.add(path)
