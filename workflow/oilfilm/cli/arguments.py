"""What several commands share: typed quantities, folders, and answers as one line of JSON.

Decides: which units a typed quantity may have; where a command looks for results.
"""

import argparse
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from oilfilm import tables
from oilfilm.api.folders import config_folder
from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import conversion
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.logs.base import LARGEST_READING
from oilfilm.settings.resolve import read_config
from oilfilm.traction.law import QUANTITIES


def results_and_footer(results: Path | None) -> tuple[Path, dict[str, str]]:
    """The folder of a campaign's results, and what the footers of its tables say of the data.

    Args:
        results: The typed folder: of results, of the project with them, or the campaign's name. By
            default that of the campaign of `config.yaml`.

    Returns:
        The folder, and a footer with `campaign` (its name) and `data` (`simulated` or `measured`).

    Raises:
        OilfilmError: There are no such results.
    """
    folder = results or Path("results", read_config(config_folder(None)).campaign)
    if results is not None:
        folder = _results_folder(results)
    if not (folder / "tables").is_dir():
        if results is None and not Path("config/config.yaml").is_file():
            raise OilfilmError(
                f"{Path.cwd()}: is no project: it has no config/config.yaml. Change to the folder "
                "of the project, or name the results with --results."
            )
        raise OilfilmError(
            f"{folder}: has no results of a campaign: there is no {folder / 'tables'}. "
            "Run snakemake, or correct --results."
        )
    # all tables of a campaign have the same two; every finished campaign has this table
    footer = tables.read_footer(folder / "tables" / "coefficients.parquet")
    return folder, {name: str(footer.get(name)) for name in ("campaign", "data")}


def _results_folder(typed_folder: Path) -> Path:
    """The folder of results that was typed, or that of the project or campaign that was typed."""
    candidates = (
        typed_folder,
        typed_folder / "results" / typed_folder.resolve().name,
        Path("results") / typed_folder,
    )
    for folder in candidates:
        if (folder / "tables").is_dir():
            return folder
    return typed_folder


def typed_conditions(options: argparse.Namespace) -> dict[str, float]:
    """The conditions that were typed, by their columns' names, in the units of the columns.

    Raises:
        OilfilmError: As in `typed_quantity`.
    """
    value_by_condition = {}
    for option, (condition, _, _) in CONDITION_OPTIONS.items():
        text = getattr(options, option.removeprefix("--"))
        if text is not None:
            value_by_condition[condition] = typed_quantity(text, QUANTITIES[condition].unit, option)
    return value_by_condition


def typed_quantity(text: str, unit: str, option: str) -> float:
    """Convert a typed number with its unit to `unit`; a bare number is in `unit` already.

    Raises:
        OilfilmError: It is no number, or its unit measures something else.
    """
    match = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*", text)
    expected = "expected a number, as 0.5 or 50%"
    if unit != "dimensionless":
        expected = f"expected a number in {unit}, as 0.5{unit}"
    if match is None:
        raise OilfilmError(f"{option}: found {text!r}; {expected}.")
    number_text, typed_unit = match.groups()
    try:
        to_unit = conversion(typed_unit or unit, (unit,))
        value = float(to_unit.convert(np.array(float(number_text))))
        if not abs(value) < LARGEST_READING:
            raise ValueError(f"no quantity is {LARGEST_READING:g} {unit} or more")
        return value
    except ValueError as error:
        raise OilfilmError(f"{option}: found {text!r}: {error}; {expected}.") from None


def json_line(values: Mapping[str, Any]) -> str:
    """Plain values as one line of JSON; NaN and infinity become null, because JSON has neither."""
    values_with_nulls = json.loads(json.dumps(values), parse_constant=lambda constant: None)
    return json.dumps(values_with_nulls)
