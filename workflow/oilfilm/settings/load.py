"""Old names, for callers that are not converted yet."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from oilfilm.settings import resolve as new
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.campaign import CampaignFile
from oilfilm.settings.config import Config
from oilfilm.settings.messages import load
from oilfilm.settings.oil import OilFile
from oilfilm.settings.reference import Claims, PaperTables, PrintedCoefficients, PublishedPowerLoss
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import Rig
from oilfilm.settings.yaml_file import as_yaml, read_yaml

__all__ = ["as_yaml", "load_checked", "load_yaml", "merge", "resolve", "unresolve"]

_MODELS: dict[str, Any] = {
    "config": Config,
    "campaign": CampaignFile,
    "rig": Rig,
    "oil": OilFile,
    "bearing": BearingFile,
    "claims": Claims,
    "paper_tables": PaperTables,
    "power_loss": PublishedPowerLoss,
    "printed_coefficients": PrintedCoefficients,
}


def resolve(folder: Path, overrides: Mapping[str, Any]) -> Any:
    """Settings, which still look like a mapping."""
    return new.resolve(folder, overrides)


def unresolve(config: Mapping[str, Any]) -> dict[str, str]:
    """A configuration folder that `resolve` turns into this."""
    return new.unresolve(Settings.of(config))


def load_yaml(path: Path) -> dict[str, Any]:
    """Plain values of a YAML file."""
    return read_yaml(path).values


def load_checked(path: Path, schema_name: str) -> dict[str, Any]:
    """Plain values of a YAML file that its model accepts."""
    load(path, _MODELS[schema_name])
    return read_yaml(path).values
