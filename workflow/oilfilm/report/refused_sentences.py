"""What was refused, one sentence per gate, with what to do."""

import pandas as pd

from oilfilm.logs.run_sheet import REMARKS
from oilfilm.report.labels import gate_name
from oilfilm.report.plain_text import bullet, sentence


def refused_lines(quarantine: pd.DataFrame, table: str) -> list[str]:
    """How often each gate refused something: its first case, and what to do. Most cases first.

    Args:
        quarantine: Table of refusals. Remarks on the run sheet refuse nothing and are left out.
        table: Its name.
    """
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    lines = []
    for rule, count in quarantine["rule"].value_counts().items():
        case = quarantine[quarantine["rule"] == rule].iloc[0]
        first = f" (the first of {count} cases; the table {table} has all)" if count > 1 else ""
        gate, name = gate_name(str(rule)), case["run_id"] or case["file"]
        lines += bullet(f"{name}: {gate}{first}. {sentence(case['reason'])}", case["advice"])
    return lines
