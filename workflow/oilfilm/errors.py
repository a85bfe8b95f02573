"""The exception for a mistake of the user, and text that is safe to print."""

import re

# No name of a file that people give is so long; a message with it could not be read.
_ENDLESS = re.compile(r"\S{1000,}")


def printable(text: object) -> str:
    """Text that is safe to print: control characters and changes of direction are escaped."""
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii")
        for letter in str(text)
    )


def cut(text: object, longest: int = 200) -> str:
    """Text of unknown origin for a message: its beginning, where it is longer than is read.

    Examples:
        >>> cut("x" * 9, 5)
        'xxxxx... (9 letters)'
    """
    whole = str(text)
    return whole if len(whole) <= longest else f"{whole[:longest]}... ({len(whole)} letters)"


class OilfilmError(Exception):
    """A mistake in data or configuration, as a sentence that the user can act on.

    The message names the file, the row or key, what was found, what was expected and what to do.
    Scripts and the command line print it without a traceback. It may quote a file of unknown
    origin, so endless words are cut and
    each of its lines is made `printable`.
    """

    def __str__(self) -> str:
        message = _ENDLESS.sub(lambda word: cut(word[0]), super().__str__())
        return "\n".join(map(printable, message.split("\n")))
