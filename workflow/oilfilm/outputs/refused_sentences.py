"""What was refused, one sentence per gate, with what to do."""

import pandas as pd

from oilfilm.outputs.labels import gate_name
from oilfilm.outputs.plain_text import bullet, sentence


def refused_lines(quarantine: pd.DataFrame, counts: "pd.Series[int]") -> list[str]:
    """How often each gate refused something: its first case, and what to do.

    Args:
        quarantine: Table of refusals.
        counts: Number of refusals by gate, in the order of the lines.
    """
    lines = []
    for rule, count in counts.items():
        case = quarantine[quarantine["rule"] == rule].iloc[0]
        first = f" (the first of {count} cases; the table quarantine has all)" if count > 1 else ""
        gate, name = gate_name(str(rule)), case["run_id"] or case["file"]
        lines += bullet(f"{name}: {gate}{first}. {sentence(case['reason'])}", case["advice"])
    return lines
