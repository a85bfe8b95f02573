"""Captions: every figure has one, and it says where its data are from."""

import json
import subprocess
import sys

import pytest

from campaigns import ROOT
from oilfilm.figure_catalogue import figures
from oilfilm.report.captions import caption
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings


def campaign(config: Settings, **keys: str | None) -> Campaign:
    """The demonstration with other keys."""
    plain = {**config.plain()["campaign"], "torque": None, **keys}
    return Settings.of({**config.plain(), "campaign": plain}).campaign


@pytest.mark.parametrize("name", figures())
def test_caption_is_complete_sentences_that_say_where_the_data_are_from(
    config: Settings, name: str
) -> None:
    figure, text = figures()[name], caption(name, config.campaign, [])
    assert text.startswith(figure.caption)
    assert figure.caption.endswith(".")
    assert not figure.title.endswith(".")
    assert ("SIMULATED data (rig twin, campaign 'demo')" in text) == figure.shows_data
    measured = campaign(config, name="june", data="measured", twin=None, credit="ours")
    if figure.shows_data:
        assert caption(name, measured, ["x"]).endswith(
            "Measured data (ours), campaign 'june'; film thickness NOT JUDGED: x."
        )


def test_captions_of_the_papers_figures_name_their_number(config: Settings) -> None:
    text = caption("fig02", config.campaign, [])
    assert "Made after Fig. 2 of Deng et al., Lubricants 14 (2026) 33." in text
    assert all(bool(figure.paper) == (figure.category == "Paper") for figure in figures().values())


def test_campaigns_may_ask_for_every_figure_that_is_drawn_and_for_no_other() -> None:
    schema = json.loads((ROOT / "workflow/schemas/campaign.schema.json").read_text("utf-8"))
    allowed = schema["properties"]["figures"]["items"]["enum"]
    assert set(allowed) == set(figures())


def test_declarations_are_read_without_importing_what_draws() -> None:
    code = (
        "import sys; from oilfilm.figure_catalogue import figures; print(len(figures())); "
        "print({'matplotlib', 'pandas', 'numpy'} & set(sys.modules))"
    )
    path = {"PYTHONPATH": str(ROOT / "workflow")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=path, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == [str(len(figures())), "set()"]
