"""The paper's printed constants and its claims, as tables and sentences."""

import pandas as pd

from oilfilm import tables
from oilfilm.report.facts import circular
from oilfilm.report.labels import BASES
from oilfilm.report.plain_text import bullet, section, text_table
from oilfilm.settings.campaign import Campaign
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import PAPER_LAW

_SIGN_VERDICTS = ("settled", "probable", "open", "against", "without effect")
_CLAIM_VERDICTS = ("holds", "by construction", "holds in part", "fails", "cannot be checked")
_APART = (
    "Constants of Deng et al. 2026 beside the fitted ones: sum of squared errors (SSE), and the "
    "largest difference of mu at tested conditions and beyond them."
)
_SIGNS = (
    "The signs of the nine exponents of an oil were lost in the available text of the paper. All "
    "512 sets of signs were ranked by the statements of the paper. One set is in use."
)


def printed_lines(results: CampaignTables, campaign: Campaign) -> list[str]:
    """The constants printed in the paper: distance from the fit, and how sure their signs are."""
    if results.signs.empty:
        return []
    apart = [
        [
            row["oil"],
            f"{row['printed_sse']:.3e}",
            f"{row['fitted_sse']:.3e}",
            f"{abs(row['tested_difference']):.1e}",
            f"{abs(row['extrapolated_difference']):.1e}",
        ]
        for row in tables.rows(results.printed_judged.dropna(subset=["tested_difference"]))
    ]
    header = ["oil", "SSE, printed", "SSE, fitted", "largest difference, tested"]
    return section(
        "Printed constants",
        [_APART] if apart else [],
        text_table([*header, "beyond them"], apart),
        [_SIGNS],
        _signs(results),
        _signs_by_fit(results, campaign),
    )


def _signs(results: CampaignTables) -> list[str]:
    """Rank of the signs in use, and how sure each of them is, one row per oil."""
    signs, rows = results.signs, []
    for oil, of_oil in results.sign_verdicts.groupby("oil", sort=False):
        used = signs[signs["in_use"] & (signs["oil"] == oil)].iloc[0]
        named = of_oil.groupby("verdict")["constant"].agg(" ".join)
        ranks = [str(used["rank"]), str(used["rank_at_figures"])]
        rows.append([str(oil), *ranks, *(named.get(verdict, "-") for verdict in _SIGN_VERDICTS)])
    header = ["oil", "rank of the set in use", "at slips of Figs 8 and 9", *_SIGN_VERDICTS]
    return text_table(header, rows)


def _signs_by_fit(results: CampaignTables, campaign: Campaign) -> list[str]:
    """What the fits of the campaign's own points say of the signs in use."""
    fits = results.configured.coefficients
    fits = fits[fits["law"] == PAPER_LAW.name]
    fitted = fits[["oil", "constant", "value", "verdict"]].dropna(subset="value")
    judged = fitted.merge(results.sign_verdicts[["oil", "constant", "sign"]])
    if judged.empty:
        return []
    same = (judged["value"] < 0) == (judged["sign"] == "-")
    known, names = judged["verdict"] == "known", judged["oil"] + " " + judged["constant"]
    line = f"The fits confirm {(known & same).sum()} of {len(judged)} signs in use."
    for label, chosen in (("The other sign", known & ~same), ("Sign not known", ~known)):
        if chosen.any():
            line += f" {label}: {', '.join(names[chosen])}."
    if campaign.truth_is_law:
        line += " CIRCULAR: the points were simulated with these very signs."
    elif campaign.twin is not None:
        line += " The points were SIMULATED by other physics: this says nothing of printed signs."
    elif campaign.data == "simulated":
        line += " The points were SIMULATED: this says nothing of the real oils."
    return [line]


def claim_lines(claims: pd.DataFrame, campaign: Campaign) -> list[str]:
    """How many of the paper's claims hold, by basis, which fail, and what that is worth."""
    if claims.empty:
        return []
    counts = [
        [BASES[str(basis)], *(str((rows["verdict"] == each).sum()) for each in _CLAIM_VERDICTS)]
        for basis, rows in claims.groupby("basis", sort=False)
    ]
    given = claims.loc[claims["verdict"] == "by construction", "statement"].unique()
    notes = [f"- By construction, because of the law's equation: {each}." for each in given]
    if circular(campaign):
        notes += bullet(circular(campaign))
    about = "The table claims.parquet has definitions, shares and worst cases."
    return section(
        "Claims of the paper",
        [about],
        text_table(["constants", *_CLAIM_VERDICTS], counts),
        _failing(claims),
        notes,
    )


def _failing(claims: pd.DataFrame) -> list[str]:
    """Claims that fail for some constants, with the verdict for each."""
    bases = list(claims["basis"].unique())
    rows = []
    for statement, of_claim in claims.groupby("statement", sort=False):
        verdicts = of_claim.set_index("basis")["verdict"]
        if (verdicts == "fails").any():
            rows.append(
                [str(statement), *(str(verdicts.get(basis, "not judged")) for basis in bases)]
            )
    return text_table(["claim that fails", *(BASES[str(basis)] for basis in bases)], rows)
