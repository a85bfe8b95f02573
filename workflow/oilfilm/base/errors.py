"""The exception for a mistake of the user, and text that is safe to print."""

import re

# People give files no such long names, and a message with one could not be read.
_ENDLESS_WORD = re.compile(r"\S{1000,}")


def printable(text: object) -> str:
    """Text that is safe to print: control characters and changes of direction are escaped."""
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii")
        for letter in str(text)
    )


def cut(text: object, max_letters: int = 200) -> str:
    """Text of unknown origin for a message: only its beginning if it is longer than `max_letters`.

    Examples:
        >>> cut("x" * 9, 5)
        'xxxxx... (9 letters)'
    """
    whole_text = str(text)
    if len(whole_text) <= max_letters:
        return whole_text
    return f"{whole_text[:max_letters]}... ({len(whole_text)} letters)"


class OilfilmError(Exception):
    """A mistake in data or configuration, as a sentence that the user can act on.

    The message names the file, the row or key, what was found, what was expected and what to do.
    Scripts and the command line print it without a traceback. It may quote a file of unknown
    origin. So very long words are cut, and each line is made `printable`.
    """

    def __str__(self) -> str:
        message = _ENDLESS_WORD.sub(lambda match: cut(match[0]), super().__str__())
        return "\n".join(printable(line) for line in message.split("\n"))
