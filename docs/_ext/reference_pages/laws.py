"""The reference page of all traction laws."""

from oilfilm.traction import ALL_LAWS, LAWS
from oilfilm.traction.law import QUANTITIES, Law
from oilfilm.traction.typeset import mathml

_HEAD_OF_PAGE = """\
# Traction laws

For readers who choose a law or program one. Look up its equation, signs and source.

Generated from the laws in `workflow/oilfilm/traction/laws` by `make schemas`; do not edit.
S is the slide-roll ratio. A coefficient X without a formula of its own is
X0 times powers of the operating conditions, or exponentials of them where the formula has an e; the
fit gives X0 and the exponents X1, X2, X3. All constants are numbers without a unit. The sign of X0
is part of the law.
"""

_NEEDS_OIL = (
    "Needs the oil's properties (`config/oils`). It is fitted beside the others (`compare.laws`); "
    "`fit.law` cannot name it."
)


def page() -> str:
    """The text of the page."""
    return _HEAD_OF_PAGE + "".join(map(_section, ALL_LAWS))


def _section(law: Law) -> str:
    rows = "\n".join(
        f"| {coefficient.name} | {'+' if coefficient.sign > 0 else '-'} | "
        f"{coefficient.smallest:g} to {coefficient.largest:g} |"
        for coefficient in law.coefficients
    )
    quantities = (QUANTITIES[group] for group in law.groups)
    groups = "; ".join(f"{quantity.symbol}: {quantity.meaning}" for quantity in quantities)
    needs = "" if law.name in LAWS else f"\n{_NEEDS_OIL}\n"
    return f"""
## {law.name}

```{{raw}} html
<div class="equation" tabindex="0">{mathml(law)}</div>
```

`{law.formula}`

{groups}. Source: {law.source}.
{needs}
| coefficient | sign | size of X0 in the search |
| --- | --- | --- |
{rows}
"""
