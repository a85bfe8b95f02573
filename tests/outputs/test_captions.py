"""Captions: every figure has one, and it says where its data are from."""

import json

import pytest

from campaigns import ROOT
from oilfilm.outputs.captions import CAPTIONS, caption
from oilfilm.outputs.figures import FIGURES

SIMULATED = {"name": "demo", "data": "simulated"}
MEASURED = {"name": "june", "data": "measured", "film_unjudged": {"accept": True}}


@pytest.mark.parametrize("name", FIGURES)
def test_caption_is_whole_sentences_that_say_where_the_data_are_from(name: str) -> None:
    words = caption(name, SIMULATED)
    assert words.startswith(FIGURES[name].caption)
    assert FIGURES[name].caption.endswith(".")
    assert not FIGURES[name].title.endswith(".")
    assert ("SIMULATED data" in words) == CAPTIONS[name].shows_data
    if CAPTIONS[name].shows_data:
        assert caption(name, MEASURED).endswith(
            "Measured data, campaign 'june'; film thickness NOT JUDGED."
        )


def test_figures_of_the_paper_name_their_place_in_it() -> None:
    assert "Fig. 2 of Deng et al., Lubricants 14 (2026) 33." in caption("fig02", SIMULATED)
    named = {name for name, known in CAPTIONS.items() if known.paper}
    assert named == {name for name, known in CAPTIONS.items() if known.category == "Paper"}


def test_campaigns_may_ask_for_every_figure_that_is_drawn_and_for_no_other() -> None:
    schema = json.loads((ROOT / "workflow/schemas/campaign.schema.json").read_text("utf-8"))
    allowed = schema["properties"]["figures"]["items"]["enum"]
    assert allowed == list(CAPTIONS)
    assert set(allowed) == set(FIGURES)
