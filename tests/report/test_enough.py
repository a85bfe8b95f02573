"""A run with too few accepted runs fails, and says what is lacking."""

from typing import Any

import pytest

from oilfilm.base.errors import OilfilmError
from oilfilm.report.accepted_runs import accepted_runs_text, shortfall_sentences
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from reports import rows

NOTHING: dict[str, Any] = {"file": "", "rule": "unreadable", "reason": "-", "advice": "-"}


def campaign(config: Settings, **keys: Any) -> Campaign:
    """The demonstration with other keys; without torque logs unless they are given."""
    plain = {**config.plain_values()["campaign"], "torque": None, **keys}
    return Settings.from_plain_values({**config.plain_values(), "campaign": plain}).campaign


def runs(**verdicts: str) -> CampaignTables:
    """Runs of each oil: A accepted, R refused; as many logs of `unread` that nothing can read.

    As many runs of `lost` cannot be read in the log of the first run of the oil x.
    """
    unread = len(verdicts.pop("unread", ""))
    lost_runs = len(verdicts.pop("lost", ""))
    known = [
        {
            "run_id": f"{oil}{number}",
            "file": f"{oil}{number}",
            "oil": oil,
            "verdict": {"A": "accepted", "R": "refused"}[letter],
        }
        for oil, letters in verdicts.items()
        for number, letter in enumerate(letters)
    ]
    lost = [{**NOTHING, "file": f"lost{number}"} for number in range(unread)]
    lost += [{**NOTHING, "file": "x0", "run_id": f"x0:{number}"} for number in range(lost_runs)]
    return CampaignTables.from_frames(
        runs=rows("runs", *known), quarantine=rows("quarantine", *lost)
    )


@pytest.mark.parametrize(
    ("verdicts", "keys", "lacking"),
    [
        ({"x": "A", "y": "AR"}, {}, ""),
        # nothing can be read; everything is refused
        ({"x": "RR"}, {}, "0 of 2 runs accepted, expected at least 1"),
        # one oil has logs and no accepted run; one has no logs yet, which is no failure
        ({"x": "AA", "y": "RRR"}, {}, "oil y: 0 of 3 runs accepted"),
        ({"x": "AAA", "y": "AR"}, {"min_accepted_runs": 2}, "oil y: 1 of 2 runs accepted"),
        # 3 of 5: a log that cannot be read counts as a run
        ({"x": "AAAR", "unread": "-"}, {"min_accepted_share": 0.6}, ""),
        ({"x": "AAAR", "unread": "-"}, {"min_accepted_share": 0.61}, "3 of 5 runs accepted"),
        # so does a run of a log whose other runs can be read
        ({"x": "AAA", "lost": "--"}, {"min_accepted_share": 0.61}, "3 of 5 runs accepted"),
        (
            {"x": "AR"},
            {"min_accepted_share": 0.995},
            "1 of 2 runs accepted, expected at least 99.5 % of them",
        ),
    ],
)
def test_campaign_needs_accepted_runs(
    config: Settings, verdicts: dict[str, str], keys: dict[str, Any], lacking: str
) -> None:
    told = "; ".join(shortfall_sentences(runs(**verdicts), campaign(config, **keys)))
    assert told.startswith(lacking)
    assert bool(told) == bool(lacking)


def test_enough_runs_are_counted_by_oil_and_too_few_end_the_run(config: Settings) -> None:
    with pytest.raises(OilfilmError, match=r"'laboratory'.*oil y: 0 of 1 runs accepted"):
        accepted_runs_text(runs(x="A", y="R"), campaign(config))
    text = accepted_runs_text(runs(x="AR", y="A", unread="-"), campaign(config))
    assert text == "runs: 2 of 4 accepted\n  x: 1 of 2\n  y: 1 of 1\n"


def test_torque_logs_need_accepted_runs_of_their_own(config: Settings) -> None:
    torque = config.plain_values()["campaign"]["torque"]

    def lacking(kept: list[dict[str, Any]], *refused: dict[str, Any]) -> list[str]:
        results = runs(x="A").replace(
            torque_runs=rows("torque_runs", *kept),
            torque_quarantine=rows("quarantine", *({**NOTHING, **row} for row in refused)),
        )
        return shortfall_sentences(results, campaign(config, torque=torque))

    a = {"run_id": "a", "file": "a", "oil": "x"}
    b = {"run_id": "b.xlsx:1", "file": "b.xlsx", "oil": "y"}
    # a plateau is enough for its run; a remark on a file with runs is no refusal of it
    kept = [{**a, "accepted": True}, {**a, "accepted": False}]
    assert lacking(kept, {"file": "a", "run_id": "a"}) == []
    of_y = ["oil y: 0 of 1 torque runs accepted, expected at least 1"]
    assert lacking([*kept, {**b, "accepted": False}], {"file": "b.xlsx"}) == of_y
    # a refused run of an oil leaves no plateau and counts for its oil
    of_z = [{"file": name, "run_id": name, "oil": "z"} for name in ("e", "f", "f")]
    assert lacking(kept, *of_z) == ["oil z: 0 of 2 torque runs accepted, expected at least 1"]
    assert lacking(kept, {"file": "g", "run_id": "g", "oil": "x"}, {"file": "h"}) == []
    # refused runs leave no plateau
    refused = {"file": "c", "run_id": "c"}, {"file": "d"}
    assert lacking([], *refused) == ["0 of 2 torque runs accepted, expected at least 1"]


def test_a_torque_log_with_a_colon_in_its_name_is_a_log_of_its_own(config: Settings) -> None:
    # of the clock, not of a run in a file
    kept = {"run_id": "10:15.csv", "file": "10:15.csv", "oil": "x", "accepted": True}
    unread = {"file": "10", "rule": "unreadable", "reason": "-", "advice": "-"}
    results = runs(x="A").replace(
        torque_runs=rows("torque_runs", kept), torque_quarantine=rows("quarantine", unread)
    )
    with_torque = campaign(config, torque=config.plain_values()["campaign"]["torque"])
    assert "torque runs: 1 of 2 accepted" in accepted_runs_text(results, with_torque)
