"""Runs that an earlier accepted one repeats: copies, names given twice, conditions run twice."""

import pandas as pd

from oilfilm.curation.gate import Finding
from oilfilm.curation.refusals import refusal
from oilfilm.curation.rig_kind import RigKind
from oilfilm.readers.base import Refusal

# Rule -> the columns of the table of runs that the two share, and the sentence.
_RULES = {
    "duplicate_log": (
        ["content_sha256"],
        "the log has the same content as {}, which is kept",
    ),
    "repeated_label": (
        ["label"],
        "the header gives the run the name that {} has, which is kept",
    ),
    "duplicate_condition": (
        [
            "oil",
            "rig",
            "nominal_load_n",
            "nominal_entrainment_speed_m_s",
            "nominal_inlet_temperature_c",
        ],
        "the run has the oil and the set points of {}, which is kept",
    ),
}


def repeated(runs: pd.DataFrame, rule: str, kind: RigKind) -> list[Refusal]:
    """Refusals of the accepted runs that share with an earlier one what the rule compares.

    Runs without a value are not compared, and the content not within one file.
    """
    key, sentence = _RULES[rule]
    known = runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)
    candidates = runs[known & (runs["verdict"] == "accepted")].sort_values(["file", "run_id"])
    first = candidates.groupby(key)[["run_id", "file"]].transform("first")
    later = candidates["file"] != first["file"]
    if rule != "duplicate_log":
        later |= candidates["run_id"] != first["run_id"]
    return [
        refusal(rule, Finding(sentence.format(earlier)), kind, run_id)
        for run_id, earlier in zip(candidates["run_id"][later], first["run_id"][later], strict=True)
    ]
