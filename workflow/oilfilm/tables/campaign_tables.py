"""The finished tables of one campaign, read when they are first used."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.tables import empty_table, read, read_blocks
from oilfilm.tables.dictionary import TABLES
from oilfilm.tables.table_needs import FIT_TABLES, OPTIONAL_TABLES

# Columns of `points` with what was measured and at which conditions. Read only these where they are
# enough: the table has three times as many, and is the largest one of a large campaign.
CURVE_COLUMNS = (
    *("run_id", "oil", "first_row", "accepted"),
    *("max_hertz_pressure_gpa", "load_n", "entrainment_speed_m_s", "inlet_temperature_c"),
    *("slide_roll_ratio", "slide_roll_ratio_se"),
    *("traction_coefficient", "traction_coefficient_se"),
)
# The same with the calibration of the sensors, for a fit.
FIT_POINT_COLUMNS = (
    *CURVE_COLUMNS,
    *("load_systematic_n", "traction_force_systematic_n"),
    *("entrainment_speed_systematic_m_s", "inlet_temperature_systematic_c"),
    "traction_force_n",
)
# The declaration that a table follows, where it is not that of the same name.
_DECLARATION_BY_TABLE = {"torque_quarantine": "quarantine"}
# The file of a table below the results, where it is not `tables/<name>.parquet`.
_FILE_BY_TABLE = {"refused_pages": "refused/index.parquet"}


class CampaignTables:
    """The finished tables of one campaign: `campaign_tables.points` is the table of points.

    A table is read and checked when it is first used, and kept. A table without files is empty:
    a campaign without torque logs has no rows of torque.
    """

    def __init__(
        self, files: Mapping[str, Iterable[Path]], frames: Mapping[str, pd.DataFrame] | None = None
    ) -> None:
        """Take the files of each table, and tables that are in memory already.

        Args:
            files: Parquet files by the name of the table; none where the campaign has no such
                table.
            frames: Tables in memory; they win over files.
        """
        self._files = {name: tuple(paths) for name, paths in files.items()}
        self._frames = dict(frames or {})

    @classmethod
    def from_job(cls, inputs: Any) -> "CampaignTables":
        """The tables among the named inputs of a Snakemake job."""
        files = {}
        for name in set(inputs.keys()) & set(_table_names()):
            paths = [inputs[name]] if isinstance(inputs[name], str) else inputs[name]
            files[name] = [_parquet_file(Path(path)) for path in paths]
        return cls(files)

    @classmethod
    def from_folder(cls, results: Path) -> "CampaignTables":
        """The tables in the results folder of a campaign, as `results/demo`."""
        paths = {
            name: results / _FILE_BY_TABLE.get(name, f"tables/{name}.parquet")
            for name in _table_names()
        }
        files: dict[str, list[Path]] = {}
        for name, path in paths.items():
            is_left_out = name in OPTIONAL_TABLES and not path.exists()
            files[name] = [] if is_left_out else [path]
        return cls(files)

    @classmethod
    def from_frames(cls, **frames: pd.DataFrame) -> "CampaignTables":
        """Tables that are in memory; every other table is empty."""
        return cls(dict.fromkeys(_table_names(), ()), frames)

    def replace(self, **frames: pd.DataFrame) -> "CampaignTables":
        """The same tables with some of them replaced."""
        return CampaignTables(self._files, {**self._frames, **frames})

    def table(
        self, name: str, columns: Sequence[str] | None = None, **row_filter: str
    ) -> pd.DataFrame:
        """One table, or some of its columns and rows.

        A whole table is kept. Of a long one, as `points`, read only what is needed: columns and
        rows that are not asked for take no memory.

        Args:
            name: Name of the table.
            columns: The columns; all if not given.
            row_filter: The value of some columns in the rows, as `oil="4102"`; all rows if none.

        Raises:
            OilfilmError: It is not among the inputs, or as `tables.read`.
        """
        if name not in self._frames:
            if name not in self._files:
                raise OilfilmError(
                    f"the table {name!r} is not among the inputs of this job; list it under "
                    f"`input:` of the rule. Listed: {', '.join(sorted(self._files)) or 'none'}."
                )
            if columns is not None or row_filter:
                return read(
                    declaration_name(name),
                    *self._files[name],
                    columns=columns,
                    row_filter=row_filter,
                )
            self._frames[name] = read(declaration_name(name), *self._files[name])
        return _selection(self._frames[name], columns, row_filter)

    def blocks(self, name: str, columns: Sequence[str] | None = None) -> Iterator[pd.DataFrame]:
        """The rows of a table in blocks, so that not all are in memory at once.

        Args:
            name: Name of the table.
            columns: The columns; all if not given.

        Raises:
            OilfilmError: As `table`.
        """
        if name in self._frames:
            yield _selection(self._frames[name], columns, {})
        else:
            # a table without rows has one block, so that blocks can be joined
            yield _selection(empty_table(declaration_name(name)), columns, {})
            yield from read_blocks(declaration_name(name), *self._files[name], columns=columns)

    def blocks_of_runs(
        self, name: str, columns: Sequence[str] | None = None
    ) -> Iterator[pd.DataFrame]:
        """The rows of a table in blocks as of `blocks`; all rows of a run are in one block.

        Args:
            name: Name of a table whose rows of one run are together, as of `points`.
            columns: The columns, `run_id` among them; all if not given.

        Raises:
            OilfilmError: As `table`.
        """
        rows_of_last_run = None
        for block in self.blocks(name, columns):
            rows = (
                block
                if rows_of_last_run is None
                else pd.concat([rows_of_last_run, block], ignore_index=True)
            )
            if rows.empty:
                rows_of_last_run = rows
                continue
            is_of_last_run = (rows["run_id"] == rows["run_id"].iloc[-1]).to_numpy()
            rows_of_last_run = rows[is_of_last_run]
            yield rows[~is_of_last_run]
        if rows_of_last_run is not None:
            yield rows_of_last_run

    @cached_property
    def configured_fits(self) -> "CampaignTables":
        """The same tables with only the fits of the configured law (`fit.law`), read when used."""
        return _TablesOfConfiguredLaw(self)

    def __getattr__(self, name: str) -> pd.DataFrame:
        if name.startswith("_"):
            raise AttributeError(name)
        return self.table(name)


class _TablesOfConfiguredLaw(CampaignTables):
    def __init__(self, every_law: CampaignTables) -> None:
        super().__init__({})
        self._every_law = every_law

    def table(
        self, name: str, columns: Sequence[str] | None = None, **row_filter: str
    ) -> pd.DataFrame:
        if name not in FIT_TABLES:
            return self._every_law.table(name, columns, **row_filter)
        if name not in self._frames:
            frame = self._every_law.table(name)
            quality = self._every_law.fit_quality
            laws = quality.loc[quality["configured"], ["oil", "law"]]
            self._frames[name] = frame.merge(laws, on=["oil", "law"])
        return _selection(self._frames[name], columns, row_filter)

    def blocks(self, name: str, columns: Sequence[str] | None = None) -> Iterator[pd.DataFrame]:
        if name in FIT_TABLES:
            yield self.table(name, columns)
        else:
            yield from self._every_law.blocks(name, columns)


def _selection(
    frame: pd.DataFrame, columns: Sequence[str] | None, row_filter: Mapping[str, str]
) -> pd.DataFrame:
    """Some columns and rows of a table; the table itself if neither is limited."""
    for name, value in row_filter.items():
        frame = frame[frame[name] == value].reset_index(drop=True)
    if columns is None:
        return frame
    # points of plain arrays have no standard errors
    return frame[[name for name in columns if name in frame]]


def _parquet_file(path: Path) -> Path:
    """The Parquet file itself; the pages of refused runs are a folder with their table in it."""
    return path / "index.parquet" if path.is_dir() else path


def _table_names() -> list[str]:
    return [*TABLES, *_DECLARATION_BY_TABLE]


def declaration_name(table_name: str) -> str:
    """Name of the declaration that a campaign's table follows; mostly its own name."""
    return _DECLARATION_BY_TABLE.get(table_name, table_name)
