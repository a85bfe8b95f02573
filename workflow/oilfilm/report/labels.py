"""Names of laws, of load variables and of quantities as a reader of the report knows them.

Decides: how laws and quantities are called in the report.
"""

import re

# Keys of the settings (`fit.law`) and of the column `law`; laws of users keep their names.
LAWS = {
    "deng2026": "Deng (Eq. 7)",
    "wang-deng-load": "load-based Wang-Deng",
    "wang-deng-critical-load": "critical-load Wang-Deng",
    "wang-deng-groups": "dimensionless Wang-Deng",
    "eyring": "Johnson-Tevaarwerk (Eyring)",
    "carreau": "Carreau",
    "tanh": "hyperbolic tangent",
}
LOAD_VARIABLES = {
    **LAWS,
    "stress": "pressure-based",
    "load": "load-based",
    "dimensionless_load": "dimensionless load",
}
# What the verdict on a claim is based on.
BASES = {"refit": "this campaign", "printed": "printed constants"}
# Where the oil that the paper advises is not the best one, by column `judgement` of `slip_advice`.
OTHER_CHOICES = {
    "slips": "Its oil exceeds the limit of cage slip, another oil does not",
    "heats more": "Its oil gives more friction heat than the best oil",
    "slips more": "Its oil gives more cage slip than the best oil",
    "rule has none": "None of its oils has enough film",
}
# Single words, such as `tanh`, read well as they are.
_KEYS = re.compile(
    r"(?<![\w-])(deng2026|wang-deng-critical-load|wang-deng-load|wang-deng-groups)(?![\w-])"
)


def law_name(key: str) -> str:
    """A law in words.

    Examples:
        >>> law_name("deng2026"), law_name("my-law")
        ('Deng (Eq. 7)', 'my-law')
    """
    return LAWS.get(key, key)


def law_names(keys: str) -> str:
    """Several laws in words, of a text such as `tanh, carreau`."""
    return ", ".join(law_name(key) for key in keys.split(", "))


def load_variable(key: str) -> str:
    """A law and what it is evaluated with in the bearing, in words.

    Examples:
        >>> load_variable("load")
        'load-based'
    """
    return LOAD_VARIABLES.get(key, key.replace("_", " "))


def gate_name(key: str) -> str:
    """A gate, or another rule of refusal, in words.

    Examples:
        >>> gate_name("stuck_sensor")
        'stuck sensor'
    """
    return key.replace("_", " ")


def in_words(sentence: str) -> str:
    """A sentence with the laws in words; what is between backticks is to be typed, and stays.

    Examples:
        >>> in_words("deng2026 is worse. Write `fit: {law: wang-deng-load}`.")
        'Deng (Eq. 7) is worse. Write `fit: {law: wang-deng-load}`.'
    """
    parts = sentence.split("`")
    parts[::2] = [_KEYS.sub(lambda match: LAWS[match.group()], part) for part in parts[::2]]
    return "`".join(parts)


# What tables write in letters that every terminal has, as it is printed; in this order.
_PRINTED = {
    r"\bmu\b": "\N{GREEK SMALL LETTER MU}",
    r"\bdegC\b": "\N{DEGREE SIGN}C",
    r"\bum\b": "\N{MICRO SIGN}m",
    r"\bR2\b": "R\N{SUPERSCRIPT TWO}",
    ">=": "\N{GREATER-THAN OR EQUAL TO}",
    # a number and its unit stay in one line
    r"(?<=\d) (?=GPa|m/s|%|\N{DEGREE SIGN}|\N{MICRO SIGN})": "\N{NO-BREAK SPACE}",
    r"(?<=\bS) (?=\d)": "\N{NO-BREAK SPACE}",
}


def printed(text: str) -> str:
    """A sentence with the symbols of print.

    Examples:
        >>> printed("mu >= 0")
        'μ ≥ 0'
    """
    for plain, sign in _PRINTED.items():
        text = re.sub(plain, sign, text)
    return text
