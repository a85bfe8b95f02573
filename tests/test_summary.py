"""The summary tells the counts, the refusals and each fit's verdict."""

from campaigns import Campaign
from oilfilm.summary import summarise


def text_of(campaign: Campaign, oil: str) -> str:
    coefficients, quality = campaign.fit(oil, bootstrap=20, searches=2)
    return summarise(
        runs=campaign.curated.runs,
        points=campaign.curated.points,
        quarantine=campaign.curated.quarantine,
        coefficients=coefficients,
        quality=quality,
        campaign=campaign.config["campaign"],
        oils=campaign.config["oils"],
    )


def test_summary_of_the_demonstration(demo: Campaign) -> None:
    text = text_of(demo, "4010")
    assert "SIMULATED" in text
    assert "212 accepted of 218" in text
    assert "certified: 2 of 2 searches agree" in text
    assert "stuck_sensor 31" in text
    assert "218 read of 218" in text
    assert "STAND-IN properties for 4102, 4050" in text


def test_summary_says_what_was_not_judged_and_not_identifiable(etm: Campaign) -> None:
    text = text_of(etm, "unrecorded-oil")
    assert "FILM NOT JUDGED for 20482 accepted points" in text
    assert "not identifiable from these conditions" in text
    assert "measured" in text
