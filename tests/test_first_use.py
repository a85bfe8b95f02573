"""A laboratory comes from `oilfilm init` to mu within 2 % of the truth, or to a true reason."""

from pathlib import Path

import pytest

from first_use import LABORATORIES, first_use
from nights import quick_ones

BY_NAME = {laboratory.name: laboratory for laboratory in LABORATORIES}
WITHOUT_ARM = "torque in mN m without an arm"
COMPLETE = [name for name in BY_NAME if name != WITHOUT_ARM]


@pytest.mark.slow
@pytest.mark.parametrize("name", quick_ones(COMPLETE, ["torque in N m"]))
def test_laboratory_comes_to_mu_by_answers_alone(name: str, tmp_path: Path) -> None:
    outcome = first_use(BY_NAME[name], tmp_path)
    assert outcome.accepted > 30, outcome.printed
    assert outcome.error < 0.02
    assert outcome.inside > 0.9
    assert outcome.questions <= 8


def test_torque_without_its_arm_is_not_used(tmp_path: Path) -> None:
    outcome = first_use(BY_NAME[WITHOUT_ARM], tmp_path)
    assert outcome.accepted == 0
    assert outcome.left_open == 1
    assert "torque_arm_m" in outcome.printed
