"""Points of which the motion is not known, or may be one of two."""

from typing import Any

import pandas as pd
import pytest

from oilfilm.torque.torque_control import (
    bistable_points_text,
    drop_bistable_plateaus,
    is_bistable,
    undecided_plateau_count,
)


@pytest.mark.parametrize("dtype", ["boolean", object])
def test_unknown_motions_are_neither_left_out_nor_taken_for_known_ones(dtype: Any) -> None:
    # plateau a: rolls or skids by one law; b: not known by one law; c: known
    flags = {"a": [True, None], "b": [None, False], "c": [False, False]}
    torque = pd.DataFrame(
        [
            {"run_id": run, "first_row": 0, "oil": "4102", "inner_speed_rpm": 9e3}
            | {"axial_load_n": 5e3, "inlet_temperature_c": 70.0, "bistable": flag}
            for run, of_run in flags.items()
            for flag in of_run
        ]
    ).astype({"bistable": dtype})
    assert is_bistable(torque).tolist() == [True, False, False, False, False, False]
    assert drop_bistable_plateaus(torque)["run_id"].tolist() == ["b", "b", "c", "c"]
    assert undecided_plateau_count(torque) == 1
    assert bistable_points_text(torque) == "4102 at 9000 rpm, 5000 N, 70 degC"
