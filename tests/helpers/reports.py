"""Results that a report can be made of in a second, with names that would break a careless page."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from PIL import Image

from campaigns import rows
from fit_points import make_points, matrix
from oilfilm.base.randomness import generator
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.surface_search import with_surface
from oilfilm.report.document import Section
from oilfilm.report.html import html_report
from oilfilm.report.sections.build import campaign_sections
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import SURFACE_TABLES

OILS = ("4102", "4050", "4010")
PROVENANCE = {"code": "0123", "settings": "4567", "inputs": {"results/x.parquet": "89ab"}}
CONDITIONS = matrix([1.0, 1.25, 1.5], [25.0, 40.0], [25.0, 70.0, 120.0])
# What a log or a campaign file may bring.
HOSTILE = [
    *("<script>alert(1)</script>", "</script><img src=x onerror=alert(2)>"),
    *("\" onmouseover='alert(3)' x=\"", "{{ 7 * 7 }}{% raw %}", "-->\u2028]]><!--"),
    *("&lt;b&gt;&amp;", "=HYPERLINK(1)", "\u6cb9\u819c\u62d6\u52a8\u8bd5\u9a8c", "long" * 100),
    # right to left, with its override
    "\u202e\u0645\u0644\u0641 \u05e9\u05dc\u05d5\u05dd",
]


def points_with_calibration(oil: str) -> pd.DataFrame:
    """Points with errors of whole curves and a calibration, so that intervals have both parts."""
    points = make_points(oil, CONDITIONS, noise=1e-4)
    gain = 1 + 0.01 * generator(3, "gain", oil).standard_normal(len(CONDITIONS))
    curve = points["run_id"].str.removeprefix("run").astype(int)
    return points.assign(
        run_id=oil + "-" + points["run_id"],
        traction_coefficient=points["traction_coefficient"] * gain[curve],
        load_systematic_n=0.4,
        traction_force_systematic_n=0.01,
        entrainment_speed_systematic_m_s=0.03,
        inlet_temperature_systematic_c=0.5,
        lambda_ratio=7.0,
        failed_gates=[()] * len(points),
    )


def results_of(config: Settings, oils: tuple[str, ...] = OILS) -> CampaignTables:
    """Three oils fitted; one run, one log and one torque log refused."""
    points = pd.concat([points_with_calibration(oil) for oil in oils], ignore_index=True)
    settings = config.fit.model_copy(update={"searches": 2, "bootstrap": 40})
    fits = []
    for oil in oils:
        fit = fit_oil(points, oil, settings, config.seed).replace(points=points)
        fits.append(with_surface(fit, oil, config))
    together = {
        name: pd.concat([fit.table(name) for fit in fits], ignore_index=True)
        for name in ("coefficients", "fit_quality", "refits", *SURFACE_TABLES)
    }
    beside = rows("fit_quality", {"oil": "4102", "law": "eyring", "n_constants": 13})
    together["fit_quality"] = pd.concat([together["fit_quality"], beside], ignore_index=True)
    names = points["run_id"].unique()
    runs = [
        {"run_id": name, "file": name, "oil": name.partition("-")[0], "verdict": "accepted"}
        for name in names
    ]
    sound = {"optimum_confirmed": True, "law_verdict": "adequate", "campaign_verdict": "steady"}
    changed = {"law_verdict": "none fits", "misfit": 0.06, "run_scatter": 0.004}
    changed |= {"campaign_verdict": "changed", "change": "traction force", "change_size": 0.08}
    changed |= {"change_course": "from", "changed_runs": ("b", "c")}
    stuck = {"run_id": "stuck.csv", "file": "stuck.csv", "verdict": "refused"}
    runs.append({**stuck, "rule": "stuck_sensor", "reason": "the force stays"})
    about = {"rule": "stuck_sensor", "reason": "the force stays", "advice": "Check the sensor."}
    unread = {"rule": "unreadable", "reason": "no data", "advice": "Log again."}
    torque = {"oil": "4102", "torque_n_m": 1.0, "traction_torque_n_m": 0.2, "converged": True}
    return CampaignTables.from_frames(
        runs=rows("runs", *runs),
        points=points,
        quarantine=rows(
            "quarantine",
            {"file": "stuck.csv", "run_id": "stuck.csv", **about},
            {"file": "empty.csv", **unread},
        ),
        coverage=rows("coverage", {"oil": "4102", "state": "accepted", "planned": True}),
        gate_counts=rows("gate_counts", {"gate": "stuck_sensor", "what": "run", "points": 31}),
        refused_pages=rows(
            "refused_pages",
            {"file": "stuck.csv", "run_id": "stuck.csv", "page": "stuck.png", **about},
        ),
        **together,
        soundness=rows(
            "soundness",
            {"oil": "4102", "sound": True, **sound},
            {"oil": "4050", **sound, **changed},
        ),
        torque_runs=rows(
            "torque_runs", {"run_id": "torque2.csv", "file": "torque2.csv", "accepted": True}
        ),
        torque_quarantine=rows("quarantine", {"file": "torque.csv", "rule": "zero_drift"}),
        torque=rows(
            "torque",
            *({**torque, "load_variable": "stress", "relative_error": e} for e in (0.1, -0.3)),
        ),
        torque_inversion=rows("torque_inversion", {"oil": "4102", "verdict": "determined"}),
    )


def report_of(
    results: CampaignTables,
    config: Settings,
    folder: Path,
    names: Sequence[str] = ("curves", "coverage"),
) -> str:
    """A report with small pictures in place of the figures and of the page of the refused run."""
    pngs = [folder / f"{name}.png" for name in (*names, "stuck")]
    for png in pngs:
        Image.new("RGB", (300, 200), "white").save(png)
        png.with_suffix(".svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    made = campaign_sections(results, config)
    return html_report(made, results, pngs[:-1], folder, config, PROVENANCE)


def with_hostile_names(results: CampaignTables) -> CampaignTables:
    """The same results with every name of a log replaced by a hostile one."""
    names = dict(zip(results.points["run_id"].unique(), HOSTILE, strict=False))
    renamed = results.points.assign(run_id=results.points["run_id"].replace(names))
    refused = rows(
        "quarantine",
        *({"file": n, "run_id": n + "?", "rule": n, "reason": n, "advice": n} for n in HOSTILE),
    )
    pages = results.refused_pages.assign(run_id=HOSTILE[0], reason=HOSTILE[1], rule=HOSTILE[2])
    return results.replace(
        points=renamed, quarantine=refused, torque_quarantine=refused, refused_pages=pages
    )


def by_anchor(results: CampaignTables, config: Settings) -> dict[str, Section]:
    return {section.anchor: section for section in campaign_sections(results, config)}


def sentences(section: Section) -> str:
    """All sentences of a section."""
    return " ".join(f"{fact.text} {fact.advice}" for fact in section.facts)


def cells(section: Section, table: str, first: str) -> dict[str, str]:
    """The row of a table that begins with a text, by heading."""
    (shown,) = (each for each in section.tables if each.name == table)
    (row,) = (row for row in shown.rows if row[0] == first)
    return dict(zip((column.heading for column in shown.columns), row, strict=True))
