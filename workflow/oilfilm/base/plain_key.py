"""Names in the form in which they are compared.

Decides: which spellings of a name are the same name.
"""

import unicodedata


def plain_key(text: str) -> str:
    """A name in the form in which names are compared: lower case, words joined by underscores.

    The forms of a letter (composed, full-width, the two signs for micro) become one.

    Examples:
        >>> plain_key("Inlet  Temperature"), plain_key("\uff2c\uff4f\uff41\uff44")
        ('inlet_temperature', 'load')
    """
    return "_".join(unicodedata.normalize("NFKC", text).casefold().split())
