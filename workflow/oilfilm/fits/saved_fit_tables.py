"""Whether the tables of a saved fit belong together.

Each table was checked by itself when it was read. A stranger's tables may still contradict each
other or the law.

Decides: which tables make one fit.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError, cut
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import Law

# Advice at the end of each message.
_ADVICE = "Fit again, or copy the whole folder again from where it was made."
# Exceptions that NumPy, SciPy and pandas raise for numbers and names that no fit has.
_CONTRADICTIONS = (ValueError, LookupError, ArithmeticError, TypeError)


@contextmanager
def explaining_contradictions(folder: str, oil: str) -> Iterator[None]:
    """Turn what fails on tables that contradict each other into a sentence.

    Args:
        folder: Folder of the results, for the message.
        oil: The oil.

    Raises:
        OilfilmError: A computation failed on the tables.
    """
    try:
        yield
    except OilfilmError:
        raise
    except _CONTRADICTIONS as error:
        reason = cut(repr(error), 300)
        raise OilfilmError(
            f"{folder}: the tables of the fit of oil {oil!r} do not belong together: mu cannot be "
            f"computed from them ({reason}). {_ADVICE}"
        ) from error


def refuse_contradictions(results: CampaignTables, folder: str, oil: str) -> None:
    """Refuse tables that do not hold one whole fit of an oil.

    Args:
        results: Tables `coefficients`, `refits`, `fit_quality`, `soundness` and `surfaces`.
        folder: Folder of the results, for the message.
        oil: The oil.

    Raises:
        OilfilmError: A row is missing or there twice, there is no such law, or a constant of the
            law is missing or has the wrong sign.
    """
    configured_tables = results.configured_fits
    for complaint in _complaints(results, configured_tables, oil):
        raise OilfilmError(f"{folder}: fit of oil {oil!r}: {complaint}. {_ADVICE}")


def _complaints(
    results: CampaignTables, configured_tables: CampaignTables, oil: str
) -> Iterator[str]:
    """Each contradiction as a clause, in the order of the checks; nothing for a whole fit.

    Args:
        results: As in `refuse_contradictions`.
        configured_tables: The same with the configured law of each oil alone.
        oil: The oil.
    """
    quality = _rows_of_oil(configured_tables.fit_quality, oil)
    if len(quality) != 1:
        yield f"fit_quality has {len(quality)} configured laws; expected one"
    verdict_count = len(_rows_of_oil(results.soundness, oil))
    if verdict_count != 1:
        yield f"soundness has {verdict_count} rows; expected one"
    surfaces = _rows_of_oil(results.surfaces, oil)
    if len(surfaces) > 1:
        yield f"surfaces has {len(surfaces)} rows; expected one at most"
    for table_name, rows_of_oil in (("fit_quality", quality), ("surfaces", surfaces)):
        for law_name in rows_of_oil["law"]:
            if law_name not in LAWS:
                shown_name = cut(repr(law_name))
                yield f"{table_name} names the law {shown_name}; the laws are {', '.join(LAWS)}"
    law = LAWS[quality["law"].iloc[0]]
    coefficients = _rows_of_oil(configured_tables.coefficients, oil)
    yield from _constant_complaints(coefficients["constant"], law)
    for table_name, rows_of_oil in (
        ("coefficients", coefficients),
        ("refits", _rows_of_oil(configured_tables.refits, oil)),
    ):
        yield from _sign_complaints(table_name, rows_of_oil, law)


def _rows_of_oil(table: pd.DataFrame, oil: str) -> pd.DataFrame:
    """The rows of a table that belong to an oil."""
    return table[table["oil"] == oil]


def _constant_complaints(found_names: pd.Series, law: Law) -> Iterator[str]:
    """Complaints about constants that the law has not, that are there twice, or that are missing.

    The table has A0 of a fit over conditions, or the coefficient A of a fit of one condition.
    """
    constant_names = [constant.name for constant in law.constants]
    for constant_name in found_names[~found_names.isin([*constant_names, *law.coefficient_names])]:
        yield f"coefficients has the constant {cut(repr(constant_name))}, which {law.name} has not"
    for constant_name in found_names[found_names.duplicated()]:
        yield f"coefficients has the constant {constant_name} twice"
    present_names = set(found_names)
    for x0_name, coefficient_name in zip(_x0_names(law), law.coefficient_names, strict=True):
        if not {x0_name, coefficient_name} & present_names:
            yield f"coefficients lacks the constant {x0_name}"


def _x0_names(law: Law) -> list[str]:
    """Names of the constants X0 of the law's coefficients."""
    return [constant.name for constant in law.constants if constant.group is None]


def _sign_complaints(table_name: str, rows: pd.DataFrame, law: Law) -> Iterator[str]:
    """Complaints about constants whose sign is not that of the law; unknown ones have none."""
    sign_by_name = {constant.name: constant.sign for constant in law.constants}
    # a coefficient X has the sign of its X0
    for x0_name, coefficient_name in zip(_x0_names(law), law.coefficient_names, strict=True):
        sign_by_name[coefficient_name] = sign_by_name[x0_name]
    signs = rows["constant"].map(sign_by_name).fillna(0).to_numpy(dtype=float)
    values = rows["value"].to_numpy(dtype=float)
    is_wrong = (signs != 0) & ~np.isnan(values) & ~(signs * values > np.finfo(float).tiny)
    for row_index in np.flatnonzero(is_wrong):
        constant_name = rows["constant"].iloc[row_index]
        expected = "above" if signs[row_index] > 0 else "below"
        value_text = f"{table_name} has {constant_name} = {values[row_index]:g}"
        yield f"{value_text}; {law.name} needs it {expected} 0"
