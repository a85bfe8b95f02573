"""The encoding of a text log, and its text as UTF-8 with LF line ends.

Decides: in which encoding a text log is read.
"""

import re
from contextlib import suppress
from itertools import islice

HEAD_SEARCHED = 1 << 16
_EMPTY_LINES = re.compile(rb"\n\n+")
_HIGH_BYTES = re.compile(rb"[\x80-\xff]+")
_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
# So many runs of bytes of 128 and above tell the encoding.
_RUNS_SEARCHED = 10_000
# Nearly all Chinese characters in use are in level 1 of GB 2312, whose first bytes are below.
_LEVEL_2 = 0xD8


def encodings_of(content: bytes) -> list[str]:
    """The encodings that a text may have, the most likely first.

    A mark, zeros (UTF-16) or valid UTF-8 leave one. In a damaged text most bytes of 128 and above
    are as its encoding wants them all the same: UTF-8 is hardly ever met by chance; common Chinese
    characters have two such bytes in GB18030; western letters of Windows-1252 have one between
    others.
    """
    if content.startswith(_UTF8_MARK):
        return ["utf-8"]
    if content.startswith(_UTF16_MARKS):
        return ["utf-16"]
    head = content[:2000]
    zeros = head[1::2].count(0), head[0::2].count(0)
    if max(zeros) > len(head) / 4:
        return ["utf-16-le" if zeros[0] > zeros[1] else "utf-16-be"]
    if content.isascii():
        return ["ascii"]
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return ["utf-8"]
    runs = [match[0] for match in islice(_HIGH_BYTES.finditer(content), _RUNS_SEARCHED)]
    letters = b" ".join(runs).decode("utf-8", "replace").replace(" ", "")
    chinese = sum(len(run) % 2 == 0 and run[0] < _LEVEL_2 for run in runs)
    likely = "gb18030" if chinese > len(runs) / 2 else "cp1252"
    if letters.count("\ufffd") <= len(letters) / 2:
        likely = "utf-8"
    return sorted(("cp1252", "utf-8", "gb18030"), key=lambda encoding: encoding != likely)


def normalise(content: bytes, encoding: str | None = None) -> bytes:
    """The text as UTF-8 with LF line ends, whatever it was written in.

    Empty lines are left out. Bytes that are not valid in the encoding become the replacement
    character, so that the rows that hold them are refused.

    Args:
        content: The file's bytes, or the first of them.
        encoding: Its encoding; the most likely one if not given.
    """
    encoding = encoding or encodings_of(content)[0]
    if encoding != "ascii":
        content = content.decode(encoding, "replace").encode("utf-8")
    content = content.removeprefix(_UTF8_MARK)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return _EMPTY_LINES.sub(b"\n", content).lstrip(b"\n")


def count_rows(text: bytes, start: int = 0) -> int:
    """Lines of a text without empty lines; the last one counts without a line end too."""
    return text.count(b"\n", start) + (len(text) > start and not text.endswith(b"\n"))
