"""The summary tells the counts, the refusals and each fit's verdict."""

from campaigns import Campaign
from oilfilm.curation.coverage import coverage
from oilfilm.summary import summarise


def text_of(campaign: Campaign, oil: str) -> str:
    fit = campaign.fit(oil, bootstrap=20, searches=2)
    coefficients, quality = fit.coefficients, fit.fit_quality
    return summarise(
        runs=campaign.curated.runs,
        points=campaign.curated.points,
        quarantine=campaign.curated.quarantine,
        coverage=coverage(campaign.curated.runs, campaign.config),
        coefficients=coefficients,
        quality=quality,
        campaign=campaign.config["campaign"],
        oils=campaign.config["oils"],
        film=campaign.config["film"],
        gates=campaign.config["gates"],
    )


def test_summary_of_the_demonstration(demo: Campaign) -> None:
    text = text_of(demo, "4010")
    assert "SIMULATED" in text
    assert "212 accepted of 218" in text
    assert "certified: 2 of 2 searches agree" in text
    assert "stuck_sensor 31" in text
    assert "218 read of 218" in text
    assert "STAND-IN properties for 4102, 4050" in text
    assert "212 of 216 conditions of the matrix accepted, 4 refused; missing: none" in text
    assert "outside it: 1 tested" in text
    assert "results/demo/refused" in text


def test_summary_says_what_was_not_judged_and_not_identifiable(etm: Campaign) -> None:
    text = text_of(etm, "unrecorded-oil")
    assert "FILM NOT JUDGED for 20482 accepted points" in text
    assert "not identifiable from these conditions" in text
    assert "measured" in text
    assert "1 of 1 conditions tested accepted (no matrix is given" in text
