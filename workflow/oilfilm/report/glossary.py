"""What the words of verdicts and of the report mean; `glossary.yaml` beside this module has them.

Decides: the meaning of each word of a verdict.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import yaml


def meanings(text: str, *more: Mapping[str, str]) -> list[tuple[str, str]]:
    """The words of a text that need a meaning, each with its meaning, in one order.

    Args:
        text: What is shown.
        more: Meanings of further words.
    """
    known = dict(
        yaml.safe_load(Path(__file__).with_name("glossary.yaml").read_text(encoding="utf-8"))
    )
    for words in more:
        known |= words
    return [(word, meaning) for word, meaning in known.items() if _occurs(word, text)]


def _occurs(word: str, text: str) -> bool:
    if not word[-1].isalpha():
        return word in text.replace("\N{PLUS-MINUS SIGN}", "+-")
    # "steps" is no plural of the verdict "in step"
    ending = "s?" if word.islower() and word.isalpha() else ""
    return re.search(rf"(?<![\w-]){re.escape(word)}{ending}(?![\w-])", text) is not None
