"""Colours that figures and the report share."""

from collections.abc import Sequence

# Okabe and Ito's colours, which stay apart for every kind of colour vision.
_PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
EXTRAPOLATED = "#ececec"  # behind what no test reaches


def oil_colour(oil: str, oils: Sequence[str]) -> str:
    """The colour of an oil: its place in the campaign decides, everywhere alike."""
    return _PALETTE[list(oils).index(oil) % len(_PALETTE)]
