"""Text of the configuration on its way into source code: what is allowed, and in which form.

Names of oils and sentences of a campaign file are untrusted. As an identifier or in a comment
they must not be able to end it, so only a short list of characters passes.
"""

import hashlib
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping

# With the longest word put before it (`traction_coefficient_`) within the 63 characters that
# Fortran 2003 and MATLAB allow and that C99 tells apart.
_LONGEST = 40
# No double quote, backslash, asterisk, brace, question mark (trigraphs) or control character, and
# nothing beyond ASCII: no comment of C, Fortran or MATLAB and no string of Modelica can be ended
# by what is left.
_NOT_PLAIN = re.compile(r"[^A-Za-z0-9 .,:;()<>=+/%'_-]")


def plain(text: str) -> str:
    """The text on one line, accents dropped and '_' for all that could end a comment or string.

    Examples:
        >>> plain('*/ int x; /*')
        '_/ int x; /_'
    """
    decomposed = unicodedata.normalize("NFKD", text)
    letters = (letter for letter in decomposed if not unicodedata.combining(letter))
    return _NOT_PLAIN.sub("_", " ".join("".join(letters).split()))


def identifiers(oils: Iterable[str]) -> Mapping[str, str]:
    """What each oil is called inside identifiers and file names.

    Lower case, because Fortran and some file systems know no other; names that would become the
    same, or too long, carry a digest of the whole name.

    Examples:
        >>> identifiers(["4102", "Ester 5"])
        {'4102': '4102', 'Ester 5': 'ester_5'}
    """
    cleaned = {oil: re.sub(r"[^a-z0-9]+", "_", oil.lower()).strip("_") for oil in oils}
    uses = Counter(cleaned.values())
    for oil, name in cleaned.items():
        if not name or uses[name] > 1 or len(name) > _LONGEST:
            digest = hashlib.sha256(oil.encode()).hexdigest()[:8]
            cleaned[oil] = f"{name[: _LONGEST - 9]}_{digest}".strip("_")
    return cleaned
