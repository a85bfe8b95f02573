"""The finished tables of one campaign, read when they are first used."""

from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.tables import read
from oilfilm.tables.dictionary import TABLES
from oilfilm.tables.table_needs import FIT_TABLES, NOT_IN_EVERY_CAMPAIGN

# Tables whose rows are those of another table.
_SAME_COLUMNS = {"torque_quarantine": "quarantine"}
# Tables whose file is not `tables/<name>.parquet`.
_FILES = {"refused_pages": "refused/index.parquet"}


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
    def of_job(cls, inputs: Any) -> "CampaignTables":
        """The tables among the named inputs of a Snakemake job."""
        files = {}
        for name in set(inputs.keys()) & set(_known_names()):
            paths = [inputs[name]] if isinstance(inputs[name], str) else inputs[name]
            files[name] = [_file(Path(path)) for path in paths]
        return cls(files)

    @classmethod
    def in_folder(cls, results: Path) -> "CampaignTables":
        """The tables in the results folder of a campaign, as `results/demo`."""
        paths = {
            name: results / _FILES.get(name, f"tables/{name}.parquet") for name in _known_names()
        }
        files: dict[str, list[Path]] = {}
        for name, path in paths.items():
            is_left_out = name in NOT_IN_EVERY_CAMPAIGN and not path.exists()
            files[name] = [] if is_left_out else [path]
        return cls(files)

    @classmethod
    def in_memory(cls, **frames: pd.DataFrame) -> "CampaignTables":
        """Tables that are in memory; every other table is empty."""
        return cls(dict.fromkeys(_known_names(), ()), frames)

    def replace(self, **frames: pd.DataFrame) -> "CampaignTables":
        """The same tables with some of them replaced."""
        return CampaignTables(self._files, {**self._frames, **frames})

    def table(self, name: str) -> pd.DataFrame:
        """One table.

        Raises:
            OilfilmError: It is not among the inputs, or as `tables.read`.
        """
        if name not in self._frames:
            if name not in self._files:
                raise OilfilmError(
                    f"the table {name!r} is not among the inputs of this job; list it under "
                    f"`input:` of the rule. Listed: {', '.join(sorted(self._files)) or 'none'}."
                )
            self._frames[name] = read(model_of(name), *self._files[name])
        return self._frames[name]

    @cached_property
    def configured(self) -> "CampaignTables":
        """The same with the fits of the configured law alone (`fit.law`), read when used."""
        return _TablesOfConfiguredLaw(self)

    def __getattr__(self, name: str) -> pd.DataFrame:
        if name.startswith("_"):
            raise AttributeError(name)
        return self.table(name)


class _TablesOfConfiguredLaw(CampaignTables):
    def __init__(self, every_law: CampaignTables) -> None:
        super().__init__({})
        self._every_law = every_law

    def table(self, name: str) -> pd.DataFrame:
        if name not in self._frames:
            frame = self._every_law.table(name)
            if name in FIT_TABLES:
                quality = self._every_law.fit_quality
                laws = quality.loc[quality["configured"], ["oil", "law"]]
                frame = frame.merge(laws, on=["oil", "law"])
            self._frames[name] = frame
        return self._frames[name]


def _file(path: Path) -> Path:
    """The Parquet file itself; the pages of refused runs are a folder with their table in it."""
    return path / "index.parquet" if path.is_dir() else path


def _known_names() -> list[str]:
    return [*TABLES, *_SAME_COLUMNS]


def model_of(name: str) -> str:
    """Name of the model that a campaign's table follows."""
    return _SAME_COLUMNS.get(name, name)
