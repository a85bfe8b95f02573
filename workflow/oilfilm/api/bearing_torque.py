"""Friction of a bearing from the fits of a campaign or of a table, in Python or as a command.

Decides: which operating points of a bearing are refused; how an answer is printed.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.api.arrays import ArrayFit
from oilfilm.api.axes import given_or_new_axes
from oilfilm.api.folders import config_folder
from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.bearing.resistance import HEAT_TERMS
from oilfilm.settings.resolve import campaign_names, named_content, resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.answers import (
    CAUSE_BY_NAME,
    Answers,
    calculate_answers,
    operating_point_table,
    range_text,
    three_digit_text,
    what_to_measure,
)
from oilfilm.torque.bearing_torque import OilInBearing, oils_with_uncertainty
from oilfilm.torque.best_oil import NOT_KNOWN

# Unit of plain numbers, and the bounds of what a bearing with oil may have: above the lower one, up
# to the upper one.
_UNIT_AND_BOUNDS_BY_QUANTITY = {
    "axial_load": ("N", 0.0, 1e7),
    "speed": ("rpm", 0.0, 1e6),
    "temperature": ("degC", -60.0, 300.0),
}
# Shares below this are not printed.
_MIN_PRINTED_SHARE = 0.005
# If the shares of variance add up to more, causes act together; the error of the shares alone does
# not make so much.
_SHARE_SUM_OF_JOINT_CAUSES = 1.4
# Answers at an operating point, as they are printed: name, column, unit of the printed value, and
# the factor that converts the column to it.
_PRINTED_ANSWERS = (
    ("friction torque", "torque_n_m", "N m", 1.0),
    ("power loss", "power_w", "W", 1.0),
    ("cage slip", "cage_slip", "%", 100.0),
)
_FRAME_COLUMNS = [
    *("oil", "bearing", "axial_load_n", "inner_speed_rpm", "inlet_temperature_c"),
    *("torque_n_m", "torque_n_m_lower", "torque_n_m_upper"),
    *("power_w", "power_w_lower", "power_w_upper"),
    *("cage_slip", "cage_slip_lower", "cage_slip_upper"),
    *("best_oil", "best_share", "bistable", "lambda_ratio", "no_equilibrium"),
]


@dataclass(frozen=True)
class BearingTorque:
    """Friction of a bearing at operating points.

    Attributes:
        oil: The oil of the summary; empty for all oils.
        answers: Results of every oil at every point, and the shares of variance.
        about: Origin of the answers in a sentence: law, campaign and data; also what is assumed.
    """

    oil: str
    answers: Answers
    about: str

    def to_frame(self) -> pd.DataFrame:
        """One row per oil and operating point: torque, power loss, cage slip, best oil."""
        return self._rows_of_oil(self.answers.points)[_FRAME_COLUMNS].reset_index(drop=True)

    def parts(self) -> pd.DataFrame:
        """Parts of the friction torque in N m, one row per oil and operating point.

        `traction` is sliding in the contacts, `rolling` the oil squeezed into them, `hysteresis`
        that of the steel, `drag` that of the oil between the balls, `pocket` and `land` the cage,
        `momentum` the oil that the inner ring carries along. They add up to the torque.
        """
        points = self._rows_of_oil(self.answers.points)
        key_columns = ["oil", "axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
        torque_by_part = points[[f"{part}_torque_n_m" for part in HEAT_TERMS]].set_axis(
            HEAT_TERMS, axis=1
        )
        return points[key_columns].join(torque_by_part).reset_index(drop=True)

    def shares(self) -> pd.DataFrame:
        """Share of the variance of torque and cage slip by each cause, and its range of draws."""
        return self._rows_of_oil(self.answers.shares).drop(columns="point").reset_index(drop=True)

    def summary(self) -> str:
        """Each operating point in sentences, its shares of variance, and what to measure next."""
        return "\n".join(self._summary_lines())

    def plot(self, axes: Any = None) -> Any:
        """Draw torque with its interval over speed, or over the load or temperature that varies.

        Args:
            axes: Axes of matplotlib to draw into; new ones if not given.

        Returns:
            The axes. `plot().figure.savefig(FILE)` writes a file.

        Raises:
            OilfilmError: `axes` are no axes, or matplotlib is missing.
        """
        axes = given_or_new_axes(axes)
        label_by_column = {
            "inner_speed_rpm": "Speed of the inner ring (rpm)",
            "axial_load_n": "Axial load (N)",
            "inlet_temperature_c": "Oil temperature (degC)",
        }
        answer_rows = self.to_frame()
        varied_columns = [name for name in label_by_column if answer_rows[name].nunique() > 1]
        abscissa_column = varied_columns[0] if varied_columns else "inner_speed_rpm"
        series_columns = ["oil", *varied_columns[1:]]
        for series_values, rows_of_series in answer_rows.groupby(series_columns, sort=False):
            sorted_rows = rows_of_series.sort_values(abscissa_column)
            label = ", ".join(
                f"{value:g}" if not isinstance(value, str) else value for value in series_values
            )
            (line,) = axes.plot(
                sorted_rows[abscissa_column], sorted_rows["torque_n_m"], marker="o", label=label
            )
            axes.fill_between(
                sorted_rows[abscissa_column],
                sorted_rows["torque_n_m_lower"],
                sorted_rows["torque_n_m_upper"],
                color=line.get_color(),
                alpha=0.2,
                linewidth=0,
            )
        axes.set(xlabel=label_by_column[abscissa_column], ylabel="Friction torque (N m)")
        axes.legend(fontsize="small", title="Band: 95 % interval")
        return axes

    def __repr__(self) -> str:
        return self.summary()

    def _rows_of_oil(self, frame: pd.DataFrame) -> pd.DataFrame:
        """The rows of a table that are of the oil of the summary; all rows if it names none."""
        return frame[frame["oil"] == self.oil] if self.oil else frame

    def _share_of_best(self, row: "pd.Series[Any]") -> float:
        """Share of the draws in which the best oil of a row's point is the best one.

        NaN where it is not known.
        """
        points = self.answers.points
        is_best_oil_here = points["oil"] == row["best_oil"]
        for column in ("axial_load_n", "inner_speed_rpm", "inlet_temperature_c"):
            is_best_oil_here &= points[column] == row[column]
        return float(points.loc[is_best_oil_here, "best_share"].sum(min_count=1))

    def _summary_lines(self) -> Iterator[str]:
        """The lines of the summary."""
        for point, row in self._rows_of_oil(self.answers.points).iterrows():
            yield from _lines_of_point(row, self._share_of_best(row))
            shares = self.answers.shares[self.answers.shares["point"] == point]
            yield from _lines_of_shares(shares)
            yield ""
        yield self.about


def _lines_of_point(row: "pd.Series[Any]", share_of_best: float) -> Iterator[str]:
    """Answers at one operating point.

    Args:
        row: Row of `Answers.points`.
        share_of_best: Share of the draws in which the best oil is the best one; NaN where it is not
            known.
    """
    yield (
        f"{row['bearing']}, oil {row['oil']}: {row['axial_load_n']:g} N, "
        f"{row['inner_speed_rpm']:g} rpm, oil at {row['inlet_temperature_c']:g} degC"
    )
    if not row["converged"]:
        reasons = {
            "contacts too wide": "the contacts would be wider than the balls; check the load",
            "out of balance": "no motion was found in which all forces balance",
        }
        yield f"  NOT KNOWN: {reasons[row['no_equilibrium']]}"
        return
    for name, column, unit, factor in _PRINTED_ANSWERS:
        value, lower, upper = (
            factor * row[f"{column}{suffix}"] for suffix in ("", "_lower", "_upper")
        )
        interval = "no interval, because the law has too few refits or draws have no equilibrium"
        if np.isfinite(lower):
            interval = (
                f"95 % interval {three_digit_text(lower)} to {three_digit_text(upper)} {unit}"
            )
        yield f"  {name:<16}{three_digit_text(value)} {unit}, {interval}"
    if row["bistable"] is True:
        yield "  the cage may roll or skid here; the numbers are those of the faster cage"
    elif pd.isna(row["bistable"]):
        yield "  it is not known whether the cage may skid here"
    best_oil = row["best_oil"]
    if best_oil == "":
        yield "  best oil        none: no oil has a full film"
    elif best_oil == NOT_KNOWN:
        yield "  best oil        not known: an oil has no steady motion or no known film"
    elif np.isnan(share_of_best):
        yield f"  best oil        {best_oil}, share of the draws not known"
    else:
        yield f"  best oil        {best_oil}, in {share_of_best:.0%} of the draws"
    if row["pressure_verdict"] != "within":
        yield f"  contact pressure {row['pressure_verdict']} limit (bearing.pressure_limits_gpa)"
    shares_beyond_tests = [
        f"{name} {row[f'share_beyond_{name}']:.0%}"
        for name in ("pressure", "speed", "temperature", "slip")
        if row[f"share_beyond_{name}"] > 0
    ]
    if shares_beyond_tests:
        yield f"  heat of traction beyond the tests of the law: {', '.join(shares_beyond_tests)}"
    if row["below_law_floor"] is True:
        yield "  the law is evaluated at its smallest level of a condition (bearing.law_floor)"


def _lines_of_shares(shares: pd.DataFrame) -> Iterator[str]:
    """Shares of variance with their ranges, and what to measure next."""
    largest_share = shares[["torque_share", "slip_share"]].max(axis=1)
    shown_shares = shares[largest_share >= _MIN_PRINTED_SHARE].sort_values(
        "torque_share", ascending=False
    )
    if shown_shares.empty:
        return
    yield f"  {'share of variance':<42}{'torque':>8}{'slip':>8}  drawn from"
    for _, row in shown_shares.iterrows():
        meaning = CAUSE_BY_NAME[row["variance_cause"]].meaning
        torque_share, slip_share = row["torque_share"], row["slip_share"]
        yield f"  {meaning:<42}{torque_share:>8.0%}{slip_share:>8.0%}  {range_text(row)}"
    for cause in shares.loc[largest_share.isna(), "variance_cause"]:
        yield f"  {CAUSE_BY_NAME[cause].meaning:<42}{'not known':>16}"
    share_sums = shares[["torque_share", "slip_share"]].sum()
    if share_sums.max() > _SHARE_SUM_OF_JOINT_CAUSES:
        yield "  The shares add up to more than 100 %: causes act together, near a jump of the cage"
    for column, name in (("torque_share", "torque"), ("slip_share", "cage slip")):
        causes = what_to_measure(shares, column)
        if causes:
            measures = ", then ".join(measure for _, measure in causes[:3])
            yield f"  To know the {name} better, measure {measures}"


def bearing_torque(
    bearing: str,
    axial_load: Any,
    speed: Any,
    temperature: Any,
    oil: str = "",
    results: Path | str | ArrayFit = "results/demo",
    config: Path | str | None = None,
    rig: str = "",
) -> BearingTorque:
    """Friction torque, power loss, cage slip and best oil of a bearing, each with its interval.

    The traction is that of a campaign's fitted laws, or of a fit of a table or of arrays. Loads,
    speeds and temperatures broadcast.

    Args:
        bearing: Name of a file of `config/bearings`.
        axial_load: Axial load in N, or a quantity of pint.
        speed: Speed of the inner ring in rpm.
        temperature: Temperature of the oil at the inlet in degC.
        oil: The oil; without it all oils of the campaign. With a fit: the file of `config/oils`
            with the properties of its oil.
        results: Folder of the campaign's results; or a fit of `oilfilm.fit` or
            `oilfilm.fit_table`.
        config: Configuration folder; by default `config`, else that of oilfilm.
        rig: With a fit: the file of `config/rigs` of the rig that measured it.

    Raises:
        OilfilmError: There is no such bearing, oil, rig or campaign, or a value is impossible.

    Examples:
        ```
        answer = oilfilm.bearing_torque("mainshaft-167", 10e3, [6000, 12000], 70, oil="4102")
        print(answer.summary())
        answer.plot()
        ```
    """
    values = (axial_load, speed, temperature)
    arrays = [
        _values_in_unit(value, name)
        for value, name in zip(values, _UNIT_AND_BOUNDS_BY_QUANTITY, strict=True)
    ]
    try:
        axial_load_n, inner_speed_rpm, inlet_temperature_c = np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise OilfilmError(
            f"axial_load, speed, temperature: found the shapes {shapes}, which do not broadcast; "
            "give one value, or as many of each."
        ) from None
    settings_folder = config_folder(None if config is None else Path(config))
    bearing_file = named_content(settings_folder, "bearing", bearing, "the bearing")
    if isinstance(results, ArrayFit):
        source = _source_of_fit(results, oil, rig, settings_folder)
    else:
        source = _source_of_folder(Path(results), rig, settings_folder)
    oils_in_bearing = oils_with_uncertainty(source.tables, source.settings)
    _refuse_unknown_oil(oil, oils_in_bearing, source.name)
    geometry = bearing_file.bearing(bearing)
    points = operating_point_table(
        geometry, axial_load_n, inner_speed_rpm, inlet_temperature_c
    ).drop_duplicates()
    # `stress`: the law whose load variable is the maximum Hertz pressure
    about = f"law {oils_in_bearing[0].laws['stress'].fitted.law.name} {source.origin}"
    stand_in_names = [
        oil_in_bearing.name
        for oil_in_bearing in oils_in_bearing
        if oil_in_bearing.properties.stand_in
    ]
    if stand_in_names:
        about += f"; properties of {', '.join(stand_in_names)} are those of similar oils"
    if bearing_file.assumed:
        about += f"; assumed in the bearing's file: {', '.join(bearing_file.assumed)}"
    answered_oil_names = (
        [oil] if oil else [oil_in_bearing.name for oil_in_bearing in oils_in_bearing]
    )

    def needs_shares(answer_rows: pd.DataFrame) -> BoolArray:
        """Whether the oil of each row of `Answers.points` was asked for, shape (rows,)."""
        return np.asarray(answer_rows["oil"].isin(answered_oil_names), dtype=bool)

    all_answers = calculate_answers(
        oils_in_bearing, geometry, points, source.settings, needs_shares
    )
    return BearingTorque(oil, all_answers, about)


class _Source(NamedTuple):
    """The fits from which the traction law of a bearing is taken.

    Attributes:
        tables: Tables of the fits.
        settings: Settings with the properties of oils and rigs.
        name: Name of the source in messages.
        origin: What the law was fitted to: campaign or table, and kind of data, in words.
    """

    tables: CampaignTables
    settings: Settings
    name: str
    origin: str


def _source_of_folder(folder: Path, rig_name: str, settings_folder: Path) -> _Source:
    """The fits of a campaign.

    Raises:
        OilfilmError: The folder has no results, or those of a campaign that is not known here.
    """
    if rig_name:
        raise OilfilmError("rig: is for a fit; a campaign names its rigs itself. Leave it out.")
    if not (folder / "tables").is_dir():
        raise OilfilmError(
            f"{folder}: has no results of a campaign: there is no {folder / 'tables'}. "
            "Run snakemake, or correct `results`."
        )
    footer = tables.read_footer(folder / "tables" / "coefficients.parquet")
    campaign_name = str(footer.get("campaign"))
    # a saved fit may have the name of a campaign, of which it has no settings
    is_saved_fit = footer.get("settings", "") is None
    if is_saved_fit or campaign_name not in campaign_names(settings_folder):
        raise OilfilmError(
            f"{folder}: has results of {campaign_name!r}, which {settings_folder / 'campaigns'} "
            "lacks. Name the configuration folder. A saved fit names no oil and no rig: give the "
            "fit itself, in Python."
        )
    data_kind = "SIMULATED" if footer.get("data") == "simulated" else str(footer.get("data"))
    return _Source(
        CampaignTables.from_folder(folder),
        resolve(settings_folder, {"campaign": campaign_name}),
        str(folder),
        f"as fitted in campaign {campaign_name}, {data_kind} data",
    )


def _source_of_fit(fit: ArrayFit, oil_name: str, rig_name: str, settings_folder: Path) -> _Source:
    """A fit of a table or of arrays, with the oil and the rig that it does not name itself.

    Raises:
        OilfilmError: Oil or rig is not named, or not known.
    """
    content_by_kind = {}
    for kind, name in (("oil", oil_name), ("rig", rig_name)):
        if not name:
            raise OilfilmError(
                f"{kind}: found nothing; a fit does not say it. Name a file of config/{kind}s."
            )
        content_by_kind[kind] = named_content(settings_folder, kind, name, f"`{kind}`").model_dump(
            mode="json", exclude_unset=True
        )
    # imported late: the report comes with it, which campaigns do not need
    from oilfilm.api.saved_fit import as_campaign  # noqa: PLC0415

    fit_tables, settings, _ = as_campaign(replace(fit, oil=oil_name), "fit")
    plain_settings = settings.plain_values()
    campaign_values = {
        **plain_settings["campaign"],
        "oils": [oil_name],
        "oils_without_properties": [],
        "rigs": [rig_name],
    }
    settings = Settings.from_plain_values(
        {
            **plain_settings,
            "campaign": campaign_values,
            "oils": {oil_name: content_by_kind["oil"]},
            "rigs": {rig_name: content_by_kind["rig"]},
        }
    )
    source_name = Path(fit.source).name or "arrays"
    return _Source(fit_tables, settings, f"the fit of {source_name}", f"as fitted to {source_name}")


def _values_in_unit(value: Any, quantity_name: str) -> FloatArray:
    """Values in the unit of `_UNIT_AND_BOUNDS_BY_QUANTITY`.

    Raises:
        OilfilmError: A quantity has another unit, or a value is impossible.
    """
    unit, lower_bound, upper_bound = _UNIT_AND_BOUNDS_BY_QUANTITY[quantity_name]
    if hasattr(value, "magnitude") and hasattr(value, "to"):
        try:
            value = value.to(unit).magnitude
        except Exception as error:
            raise OilfilmError(
                f"{quantity_name}: {error}; expected a unit such as {unit}."
            ) from error
    try:
        values: npt.NDArray[np.float64] = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise OilfilmError(
            f"{quantity_name}: found {value!r}; expected numbers in {unit}."
        ) from None
    if values.size == 0:
        raise OilfilmError(f"{quantity_name}: found no value; expected one or more in {unit}.")
    is_possible = (values > lower_bound) & (values <= upper_bound)
    if not is_possible.all():
        raise OilfilmError(
            f"{quantity_name}: found {values[~is_possible].flat[0]:g} {unit}; expected more than "
            f"{lower_bound:g} and at most {upper_bound:g} {unit}."
        )
    return values


def _refuse_unknown_oil(
    oil_name: str, oils_in_bearing: list[OilInBearing], source_name: str
) -> None:
    """Refuse a campaign without oils for a bearing, and an oil that is not among them.

    Raises:
        OilfilmError: There is none.
    """
    oil_names = [oil_in_bearing.name for oil_in_bearing in oils_in_bearing]
    if not oil_names:
        raise OilfilmError(
            f"{source_name}: no oil of the campaign can be used in a bearing. It needs a rig of "
            "known contact, properties of the oil (config/oils) and a law that follows all "
            "conditions."
        )
    if oil_name and oil_name not in oil_names:
        raise OilfilmError(
            f"{source_name}: no oil {oil_name!r} that can be used in a bearing; there are "
            f"{', '.join(oil_names)}. Name one of these."
        )
