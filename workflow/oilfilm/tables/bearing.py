"""Tables of the bearing: measured torque, torque by model, cage slip, size effect."""

import numpy as np
from pandera.typing.pandas import Series

from oilfilm.tables.fields import Table, count, flag, number, share, text

_BASES = ("stress", "load", "dimensionless_load", "wang-deng-load", "wang-deng-groups")


class TorqueRuns(Table):
    """One steady plateau of a torque log: one speed of a bearing under one axial load."""

    run_id: Series[str] = text("the log, as in the traction rig's `runs`: file, or file:group")
    oil: Series[str] = text("oil as named in config/oils")
    bearing: Series[str] = text("bearing as named in config/bearings")
    sha256: Series[str] = text("of the raw log's bytes")
    reader: Series[str] = text("format that it was read as")
    first_row: Series[np.int64] = count("first row of the settled part, in the raw log")
    last_row: Series[np.int64] = count("last row of the settled part")
    n_samples: Series[np.int64] = count("rows averaged; flagged spikes are not among them")
    n_spikes: Series[np.int64] = count("rows left out of the mean as spikes of the torque")
    time_s: Series[float] = number("middle of the settled part")
    duration_s: Series[float] = number("length of the settled part", at_least=0)
    inner_speed_rpm: Series[float] = number("mean speed of the inner ring; the outer one rests")
    axial_load_n: Series[float] = number("mean axial load")
    oil_temperature_c: Series[float] = number("mean oil temperature at the bearing's inlet")
    outer_ring_temperature_c: Series[float] = number("mean outer ring temperature")
    tare_n_m: Series[float] = number("output at rest at that time, removed from the torque")
    torque_n_m: Series[float] = number(
        "mean friction torque, tare removed: taken for what the inner ring needs"
    )
    torque_n_m_se: Series[float] = number(
        "random standard error, the tare's included; calibration is not in it", at_least=0
    )
    torque_change_n_m: Series[float] = number("second half minus first half of the plateau")
    oil_temperature_change_c: Series[float] = number("the same of the oil temperature")
    accepted: Series[bool] = flag("true where no gate refused the plateau")
    failed_gates: Series[str] = text(
        "names of the gates that refused it, joined by ';'; empty if none"
    )


class BearingFriction(Table):
    """Friction of a bearing at one operating point, term by term."""

    converged: Series[bool] = flag("false: no equilibrium was found, and all results are null")
    why: Series[str] = text("why no equilibrium was found; empty where one was")
    residual: Series[float] = number(
        "largest force or moment out of balance, over the load of a ball", gaps=True
    )
    energy_error: Series[float] = number(
        "power put in at the rings less all heat, over that power", gaps=True
    )
    quadrature_error: Series[float] = number(
        "traction heat by twice as many places in either direction, relative difference", gaps=True
    )
    torque_n_m: Series[float] = number("moment that turns the inner ring: six terms", gaps=True)
    outer_ring_torque_n_m: Series[float] = number(
        "moment of balls and cage on the outer ring: less by the drag, which the oil takes",
        gaps=True,
    )
    traction_torque_n_m: Series[float] = number("term: sliding in the contacts", gaps=True)
    rolling_torque_n_m: Series[float] = number("term: oil drawn into the contacts", gaps=True)
    hysteresis_torque_n_m: Series[float] = number("term: hysteresis of the steel", gaps=True)
    drag_torque_n_m: Series[float] = number("term: balls through oil and air", gaps=True)
    pocket_torque_n_m: Series[float] = number("term: balls in the cage's pockets", gaps=True)
    land_torque_n_m: Series[float] = number("term: cage on its guiding land", gaps=True)
    gross_torque_n_m: Series[float] = number(
        "part of traction: slip of the whole contact", gaps=True
    )
    spin_torque_n_m: Series[float] = number("part of traction: spin about the normal", gaps=True)
    differential_torque_n_m: Series[float] = number(
        "part of traction: slip across a curved contact", gaps=True
    )
    gyroscopic_torque_n_m: Series[float] = number(
        "part of traction: slip across the rolling direction", gaps=True
    )
    cage_slip: Series[float] = number(
        "by how much the cage lags behind balls that roll on both races, relative", gaps=True
    )
    inner_contact_angle_deg: Series[float] = number("inner race", gaps=True)
    outer_contact_angle_deg: Series[float] = number("outer race", gaps=True)
    inner_max_hertz_pressure_gpa: Series[float] = number("inner race", gaps=True)
    outer_max_hertz_pressure_gpa: Series[float] = number("outer race", gaps=True)
    entrainment_speed_m_s: Series[float] = number("mean of both contacts", gaps=True)
    lambda_ratio: Series[float] = number(
        "minimum film, thermally reduced, over combined Rq; the worse contact", gaps=True
    )
    largest_slide_roll_ratio: Series[float] = number("anywhere in the ellipses", gaps=True)
    mean_traction_coefficient: Series[float] = number("mean over the ellipses by load", gaps=True)
    share_beyond_slip: Series[float] = share(
        "of the traction heat, at slide-roll ratios above any tested", gaps=True
    )
    share_beyond_pressure: Series[float] = share(
        "of the traction heat, in contacts of untested pressure", gaps=True
    )
    share_beyond_speed: Series[float] = share(
        "of the traction heat, in contacts of untested entrainment speed", gaps=True
    )


class Torque(BearingFriction):
    """One plateau of a torque log and what one basis of the traction law makes of it."""

    run_id: Series[str] = text("torque log")
    first_row: Series[np.int64] = count("first row of its plateau")
    oil: Series[str] = text("oil")
    bearing: Series[str] = text("bearing")
    basis: Series[str] = text(
        "what the law takes for the load: maximum Hertz stress, load in N, or W/(E' Rx^2); or the "
        "name of a law on load fitted to the same points",
        one_of=_BASES,
    )
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    axial_load_n: Series[float] = number("axial load")
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet")
    measured_torque_n_m: Series[float] = number("as in torque_runs", gaps=True)
    measured_torque_n_m_se: Series[float] = number("as in torque_runs", at_least=0, gaps=True)
    relative_error: Series[float] = number("calculated over measured torque, less 1", gaps=True)
    palmgren_torque_n_m: Series[float] = number(
        "outside opinion, as usually quoted: Palmgren", gaps=True
    )
    skf_torque_n_m: Series[float] = number("outside opinion, as usually quoted: SKF", gaps=True)


class TorqueInversion(Table):
    """Traction at the raceways by the measured torque, the other terms being as calculated."""

    run_id: Series[str] = text("torque log")
    first_row: Series[np.int64] = count("first row of its plateau")
    oil: Series[str] = text("oil")
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    axial_load_n: Series[float] = number("axial load")
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet")
    traction_share: Series[float] = number(
        "of the calculated torque: what the traction law decides", gaps=True
    )
    law_traction_coefficient: Series[float] = number("mean in the ellipses by the law", gaps=True)
    traction_coefficient: Series[float] = number(
        "mean in the ellipses that gives the measured torque; null where none does", gaps=True
    )
    traction_coefficient_se: Series[float] = number(
        "its standard error from the torque's random one", at_least=0, gaps=True
    )
    traction_coefficient_systematic: Series[float] = number(
        "standard uncertainty from calibration and from the other terms' assumed uncertainty",
        at_least=0,
        gaps=True,
    )
    verdict: Series[str] = text(
        "undetermined: the uncertainty is as large as the value",
        one_of=("determined", "undetermined", "no solution"),
    )


class CageSlip(BearingFriction):
    """Cage slip of one oil at one speed and axial load, from the friction equilibrium."""

    oil: Series[str] = text("oil")
    bearing: Series[str] = text("bearing")
    pitch_speed_mm_rpm: Series[float] = number("pitch diameter times speed, d_m n")
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    axial_load_n: Series[float] = number("axial load")
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet")


class SlipAdvice(Table):
    """One operating point of a bearing: the oil that holds its cage, beside the paper's advice."""

    bearing: Series[str] = text("bearing")
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet")
    pitch_speed_mm_rpm: Series[float] = number("pitch diameter times speed, d_m n")
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    axial_load_n: Series[float] = number("axial load")
    oils_within_limit: Series[str] = text(
        "oils with enough film whose cage slip stays within selection.limits.slip_limit, joined by "
        "'; '; empty where none does"
    )
    rule: Series[str] = text("first rule of selection.rules that applies")
    slip_that_decides: Series[float] = number(
        "cage slip with the oil that the rules advise where nothing slips; null without film",
        gaps=True,
    )
    advised_oil: Series[str] = text(
        "oil that the rule advises: of those it prefers the first with enough film that holds the "
        "cage, the last with enough film where none does; empty where none has enough film"
    )
    advised_cage_slip: Series[float] = number("with that oil", gaps=True)
    advised_torque_n_m: Series[float] = number("friction torque with that oil", gaps=True)
    best_oil: Series[str] = text(
        "of the oils within the limit the one with the least torque; where there is none, that "
        "with the least slip; empty where no oil has enough film"
    )
    best_cage_slip: Series[float] = number("with the best oil", gaps=True)
    best_torque_n_m: Series[float] = number("friction torque with the best oil", gaps=True)
    judgement: Series[str] = text(
        "of the advised oil. agree: it is the best, or within selection.indifference of it; slips: "
        "beyond the limit while another oil does not; slips more: all do, and another less; heats "
        "more: within the limit, with more torque than another; rule has none: no oil that it "
        "prefers has enough film, another has; no film: none has",
        one_of=("agree", "slips", "slips more", "heats more", "rule has none", "no film"),
    )


class SizeEffect(BearingFriction):
    """What a basis of the traction law makes of balls of another size or closer grooves."""

    oil: Series[str] = text("oil")
    bearing: Series[str] = text("bearing that is varied")
    varied: Series[str] = text(
        "ball size: all lengths in proportion, the same pressure and surface speed; conformity: "
        "both grooves, the same load and speed",
        one_of=("ball size", "conformity"),
    )
    ball_diameter_mm: Series[float] = number("diameter of the balls")
    groove_curvature: Series[float] = number("groove radius over ball diameter")
    basis: Series[str] = text("as in torque", one_of=_BASES)
    axial_load_n: Series[float] = number("axial load")
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet")
    relative_to_stress: Series[float] = number(
        "traction torque over that of the stress basis, less 1", gaps=True
    )


class PowerLoss(BearingFriction):
    """Published power loss of a bearing beside the calculated one: plausibility, never a gate."""

    bearing: Series[str] = text("bearing")
    oil: Series[str] = text("oil whose traction was taken")
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    axial_load_n: Series[float] = number("axial load")
    inlet_temperature_c: Series[float] = number("oil temperature at the inlet")
    published_power_w: Series[float] = number("second-hand figure")
    power_w: Series[float] = number("calculated torque times speed", gaps=True)


class TorqueTruth(Table):
    """What the twin planted in a simulated torque log. Only the twin and the tests read it."""

    run_id: Series[str] = text("torque log")
    oil: Series[str] = text("oil")
    defect: Series[str] = text("planted defect; empty for a clean log")
    inner_speed_rpm: Series[float] = number("speed of the inner ring")
    axial_load_n: Series[float] = number("axial load")
    oil_temperature_c: Series[float] = number("oil temperature")
    torque_n_m: Series[float] = number("true friction torque")
    traction_torque_n_m: Series[float] = number("its term of traction")
    law_misfit: Series[float] = number(
        "root-mean-square difference of the twin's local traction from the law behind the traction "
        "rig's logs, averaged over the rig's contact, relative to the law's root-mean-square"
    )


TABLES: dict[str, type[Table]] = {
    "torque_runs": TorqueRuns,
    "torque": Torque,
    "torque_inversion": TorqueInversion,
    "cage_slip": CageSlip,
    "slip_advice": SlipAdvice,
    "size_effect": SizeEffect,
    "power_loss": PowerLoss,
    "torque_truth": TorqueTruth,
}
# columns that no two rows of a table share
KEYS: dict[str, tuple[str, ...]] = {
    "torque_runs": ("run_id", "first_row"),
    "torque": ("run_id", "first_row", "basis"),
    "torque_inversion": ("run_id", "first_row"),
    "cage_slip": ("oil", "pitch_speed_mm_rpm", "axial_load_n"),
    "slip_advice": ("pitch_speed_mm_rpm", "axial_load_n"),
    "size_effect": ("oil", "varied", "ball_diameter_mm", "groove_curvature", "basis"),
    "power_loss": ("inner_speed_rpm",),
    "torque_truth": ("run_id", "inner_speed_rpm"),
}
