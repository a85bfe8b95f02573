"""Planted constants and the evidence made of them, for the audit of claims."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from campaigns import ROOT, printed
from deng2026_study.audit.audit import printed_evidence
from deng2026_study.audit.evidence import Evidence
from deng2026_study.printed_constants import judge_signs
from deng2026_study.reference import Claim, read_claims
from deng2026_study.settings import NAME, study_settings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

CLAIMS = ROOT / "workflow/deng2026_study/reference/claims.yaml"
OILS = ("4102", "4050", "4010")
# |A|, its exponents; B, its exponents; C, its exponents: falls with U and T, rises with P
PLAIN = [-0.02, 1.0, -0.5, -0.5, 0.5, 1.0, -0.5, -0.5, 30.0, 0.0, 0.0, 0.0]


def sign_study(settings: Settings) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The study of the lost signs as its rule runs it."""
    printed_settings = study_settings(settings).printed
    return judge_signs(printed(), settings.oils, printed_settings, settings.gates.traction_max)


def with_study(config: Settings, changes: Mapping[str, Any]) -> Settings:
    """Settings with some settings of the study changed."""
    return config.with_changes({"studies": {NAME: changes}})


def claims_of(*ids: str) -> list[Claim]:
    """These claims of the paper."""
    return [claim for claim in read_claims(CLAIMS).claims if claim.id in ids]


def evidence_of(
    constants: Mapping[str, Sequence[float]],
    config: Settings,
    *,
    truth_is_law: bool = False,
    **tables: pd.DataFrame,
) -> Evidence:
    """Laws with these constants, and tables of a campaign."""
    evidence = printed_evidence({oil: np.array(row) for oil, row in constants.items()}, config)
    return replace(
        evidence,
        falling_viscosity=OILS,
        campaign_tables=CampaignTables.from_frames(**tables),
        truth_is_law=truth_is_law,
    )


def planted(size: float = 1.0, **changes: float) -> list[float]:
    """The plain constants with A0 and B0 times `size`, and others changed by name."""
    names = [f"{letter}{number}" for letter in "ABC" for number in range(4)]
    values = dict(zip(names, PLAIN, strict=True))
    values |= {"A0": values["A0"] * size, "B0": values["B0"] * size} | changes
    return list(values.values())
