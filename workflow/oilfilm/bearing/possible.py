"""Which bearings cannot be built. Little is imported here: the Snakefile asks it when parsed."""

import math
from collections.abc import Iterator, Mapping
from typing import Any


def impossible(config: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What cannot be built of a file of config/bearings: the key meant, and a sentence."""
    ball, pitch, cage = config["ball_diameter_m"], config["pitch_diameter_m"], config["cage"]
    if ball >= pitch / 2:
        yield (
            "ball_diameter_m",
            f"found {ball:g} m with a pitch diameter of {pitch:g} m; expected less than half of "
            "it, or there is no room for an inner ring and a shaft.",
        )
    if ball >= pitch * math.sin(math.pi / config["ball_count"]):
        room = int(math.pi / math.asin(min(ball / pitch, 1.0)))
        yield (
            "ball_count",
            f"found {config['ball_count']} balls of {ball:g} m, which overlap on a pitch diameter "
            f"of {pitch:g} m; there is room for {room}.",
        )
    land, outer = cage["land_diameter_m"], cage["guidance"] == "outer"
    if outer != (land > pitch) or abs(land - pitch) > ball:
        low, high = (pitch, pitch + ball) if outer else (pitch - ball, pitch)
        yield (
            "cage.land_diameter_m",
            f"found {land:g} m with guidance: {cage['guidance']}; expected {low:g} to {high:g} m, "
            "between the pitch diameter and the balls' far side.",
        )
    if cage["land_clearance_m"] >= ball / 2:
        yield (
            "cage.land_clearance_m",
            f"found {cage['land_clearance_m']:g} m; expected well below the balls' radius of "
            f"{ball / 2:g} m.",
        )
