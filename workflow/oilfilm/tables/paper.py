"""Tables about the paper: its printed constants judged, its claims audited."""

import numpy as np
from pandera.typing.pandas import Series

from oilfilm.tables.fields import Table, count, flag, number, share, text


class PrintedJudged(Table):
    """The printed constants of one oil, beside the campaign's own fit.

    Nulls where the conditions cannot give all twelve constants, or their errors.
    """

    oil: Series[str] = text("oil")
    n_points: Series[np.int64] = count("accepted points, those of the fit")
    printed_sse: Series[float] = number(
        "sum of squared errors of mu (Eq. 10) of the printed constants", at_least=0, gaps=True
    )
    fitted_sse: Series[float] = number("the same of the fit", at_least=0, gaps=True)
    a0_distance: Series[float] = number(
        "(fitted - printed) A0 over its standard error, systematic part included", gaps=True
    )
    a1_distance: Series[float] = number("the same of A1", gaps=True)
    a2_distance: Series[float] = number("the same of A2", gaps=True)
    a3_distance: Series[float] = number("the same of A3", gaps=True)
    b0_distance: Series[float] = number("the same of B0", gaps=True)
    b1_distance: Series[float] = number("the same of B1", gaps=True)
    b2_distance: Series[float] = number("the same of B2", gaps=True)
    b3_distance: Series[float] = number("the same of B3", gaps=True)
    c0_distance: Series[float] = number("the same of C0", gaps=True)
    c1_distance: Series[float] = number("the same of C1", gaps=True)
    c2_distance: Series[float] = number("the same of C2", gaps=True)
    c3_distance: Series[float] = number("the same of C3", gaps=True)
    joint_distance: Series[float] = number(
        "Mahalanobis distance of all twelve by the fit's covariance (refits), about 3.5 by chance "
        "alone; null without one",
        at_least=0,
        gaps=True,
    )
    tested_difference: Series[float] = number(
        "printed - fitted mu where they differ most in the tested box", gaps=True
    )
    tested_traction_coefficient: Series[float] = number("fitted mu there", gaps=True)
    tested_max_hertz_pressure_gpa: Series[float] = number("P there", gaps=True)
    tested_entrainment_speed_m_s: Series[float] = number("U there", gaps=True)
    tested_inlet_temperature_c: Series[float] = number("T there", gaps=True)
    tested_slide_roll_ratio: Series[float] = number("S there", gaps=True)
    extrapolated_difference: Series[float] = number(
        "printed - fitted mu where they differ most in the extrapolated box", gaps=True
    )
    extrapolated_traction_coefficient: Series[float] = number("fitted mu there", gaps=True)
    extrapolated_max_hertz_pressure_gpa: Series[float] = number("P there", gaps=True)
    extrapolated_entrainment_speed_m_s: Series[float] = number("U there", gaps=True)
    extrapolated_inlet_temperature_c: Series[float] = number("T there", gaps=True)
    extrapolated_slide_roll_ratio: Series[float] = number("S there", gaps=True)


class Signs(Table):
    """One of the 512 sign sets of an oil's nine printed exponents, held against the paper's text.

    `printed.signs` of the configuration has the thresholds. Not judged here: claims that A0 < 0,
    B0 > 0 and C0 > 0 make true for every set (mu = 0 at S = 0, one peak, a linear start).
    """

    oil: Series[str] = text("oil")
    signs: Series[str] = text("of A1 A2 A3 B1 B2 B3 C1 C2 C3: exponents of P, U, T")
    in_use: Series[bool] = flag("true for the set in data/reference/printed_coefficients.yaml")
    rank: Series[np.int64] = count("by total, 1 the best; equals share a rank")
    rank_at_figures: Series[np.int64] = count(
        "the same where only the slips of the paper's figs 8 and 9 are asked: how much it depends "
        "on that choice"
    )
    total: Series[float] = number("weighted sum of the statements' shares: how many hold")
    near_best: Series[bool] = flag("true where total is less than near_best below the best")
    physical: Series[float] = share(
        "share of the extrapolated box where mu >= 0 (by the signs of A0, B0, C0) and no "
        "peak above gates.traction_max; section 3: 'remains non-negative under all "
        "operating conditions'"
    )
    rises_with_stress: Series[float] = share(
        "share of the extrapolated box where mu rises from each level of P to the next; "
        "section 4.3.3: 'increase with the maximum contact stress'"
    )
    linear_in_stress: Series[float] = share(
        "share of the extrapolated box where mu(P) rises along a straight line "
        "(linear_r2_min); section 4.3.3: 'an approximately linear increase'"
    )
    falls_with_speed: Series[float] = share(
        "share of the extrapolated box where mu falls from each level of U to the next; "
        "section 4.3.2: 'continues to decline as the entrainment speed increases from 20 "
        "m/s to 200 m/s'"
    )
    levels_off_with_speed: Series[float] = share(
        "share of the extrapolated box where mu falls by more over the first third of the "
        "speeds than it changes over the last; section 4.3.2: 'a clear plateau at high "
        "entrainment speeds'"
    )
    falls_with_temperature: Series[float] = share(
        "share of the extrapolated box where mu falls from each level of T to the next; "
        "section 4.3.4: 'decrease markedly in a nonlinear manner with increasing "
        "temperature'"
    )
    levels_off_with_temperature: Series[float] = share(
        "share of the extrapolated box where mu falls by more over 20-60 degC than it "
        "changes over 100-140; section 4.3.4: 'approximately 20-60 degC, the decrease is "
        "more pronounced, whereas in the high-temperature range (>100 degC), the curves "
        "flatten'"
    )
    start_falls_with_temperature: Series[float] = share(
        "share of the tested box where the slope at zero slip falls from each level of T "
        "to the next; half weight, it follows by the physics named; section 2.4: 'typical "
        "Newtonian behavior', 'temperature-induced reduction in the lubricant's base "
        "viscosity'"
    )
    rises_with_slip: Series[float] = share(
        "share of the extrapolated box where mu at the highest of slide_roll_ratio.figures is "
        "above that at the lowest; section 4.3.2: 'gradually increases as the SRR rises from 0.05 "
        "to 0.20'"
    )
    declines_slightly: Series[float] = share(
        "share of the tested box where mu peaks within the slips and loses decline_max of "
        "the peak at most; section 2.4: 'reaches a maximum value ... a slight decline'"
    )
    earlier_plateau_with_stress: Series[float] = share(
        "share of the extrapolated box where the linear range ends at smaller slip from "
        "each level of P to the next; section 4.3.1: 'the onset of nonlinearity occurs at "
        "a smaller SRR', 'reach the plateau region at relatively low SRR'"
    )
    earlier_plateau_with_speed: Series[float] = share(
        "the same from each level of U to the next, in the tested box; half weight, "
        "one reading; section "
        "2.4: 'At high entrainment speeds ... enters the saturation regime at lower SRR "
        "values'"
    )
    earlier_plateau_with_temperature: Series[float] = share(
        "the same from each level of T to the next, in the tested box; half weight, "
        "the other reading; "
        "section 2.4: 'decreasing trend with increasing oil supply temperature ... enters "
        "the saturation regime at lower SRR values'"
    )
    slip_raises_stress_effect: Series[float] = share(
        "share of the extrapolated box where over the range of P mu gains more at the highest of "
        "slide_roll_ratio.figures than it changes at the lowest; section 4.3.3: 'the increase is "
        "more pronounced at a high SRR of 0.20'"
    )
    speed_mutes_stress_effect: Series[float] = share(
        "share of the extrapolated box where over the range of P mu gains more at the lowest speed "
        "than it changes at the highest; section 4.3.3: 'at low speeds ... greater load "
        "sensitivity'"
    )
    speed_mutes_temperature_effect: Series[float] = share(
        "share of the extrapolated box where over the range of T mu loses more at the lowest speed "
        "than it changes at the highest; section 4.3.4: 'high-speed cases ... reduced sensitivity "
        "to temperature'"
    )
    viscosity_order: Series[float] = share(
        "share of the extrapolated box where mu is below that of the next more viscous "
        "oil and above that of the next less viscous one, the mean of both, these with "
        "the set that their own statements like best; section 4.3.1: 'the traction level "
        "of lubricant 4102 is the highest, followed by 4050, while 4010 exhibits the "
        "lowest'",
        gaps=True,
    )
    hot_convergence: Series[float] = share(
        "share of it where mu is nearer to that of each other oil at the highest "
        "temperature than at the lowest; section 4.3.4: 'in the high-temperature region, "
        "the three curves gradually converge'",
        gaps=True,
    )
    sse: Series[float] = number(
        "sum of squared errors of mu on the campaign's accepted points. CIRCULAR where they are "
        "simulated from the printed constants; simulated from anything else it says nothing of "
        "the real oils",
        at_least=0,
        gaps=True,
    )


class SignVerdicts(Table):
    """How sure the sign in use of one printed exponent is."""

    oil: Series[str] = text("oil")
    constant: Series[str] = text("exponent")
    sign: Series[str] = text("in use", one_of=("+", "-"))
    margin: Series[float] = number(
        "best total of the sets with this sign less that of the sets with the other, in statements"
    )
    weakest_margin: Series[float] = number(
        "smallest margin with any one statement left out, at the slips of the whole curve or of "
        "the paper's figures alone"
    )
    weakest_without: Series[str] = text("the statement left out there")
    weakest_slips: Series[str] = text(
        "the slips there (printed.signs.slide_roll_ratio)", one_of=("curve", "figures")
    )
    near_best_share: Series[float] = share("share of the near-best sets that have this sign")
    effect: Series[float] = number(
        "largest change of mu over the tested box if this sign alone is turned, over the largest "
        "mu there",
        at_least=0,
    )
    least_sse: Series[float] = number(
        "least SSE of the sets with this sign; the same caution as for the column sse of signs",
        at_least=0,
        gaps=True,
    )
    least_sse_turned: Series[float] = number(
        "the same of the sets with the other sign", at_least=0, gaps=True
    )
    verdict: Series[str] = text(
        "settled: every near-best set has this sign, whichever statement is left out and at either "
        "slips; probable: with every statement, at the slips of the whole curve; against: every "
        "one has the other sign; open: some have either; without effect: it moves mu by "
        "no_effect_max at most",
        one_of=("settled", "probable", "open", "against", "without effect"),
    )


class Claims(Table):
    """One claim of the paper on one basis: what would make it hold, and what was found."""

    claim: Series[str] = text("id of the claim in data/reference/claims.yaml")
    section: Series[str] = text("where the paper makes it")
    statement: Series[str] = text("what the claim comes to")
    wording: Series[str] = text("the paper's own words")
    basis: Series[str] = text(
        "refit: the campaign's own fits and points; printed: the paper's constants, signs restored",
        one_of=("refit", "printed"),
    )
    definition: Series[str] = text("what would make the claim hold")
    judged_on: Series[str] = text("where the verdict was sought")
    verdict: Series[str] = text(
        "by the share of the cases (audit.holds_share, audit.fails_share of config.yaml)",
        one_of=("holds", "holds in part", "fails", "cannot be checked"),
    )
    finding: Series[str] = text("the figures in words, or why it cannot be checked")
    cases: Series[np.int64] = count("places or rows where the claim was asked")
    share: Series[float] = number(
        "of the cases in which it holds", at_least=0, at_most=1, gaps=True
    )
    share_tested_box: Series[float] = number(
        "the same over the tested box; null where the claim has no case there",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    share_extrapolated_box: Series[float] = number(
        "the same over the box of the paper's figs 7 to 10",
        at_least=0,
        at_most=1,
        gaps=True,
    )
    worst_quantity: Series[str] = text("what the worst value is; empty where not checked")
    worst_value: Series[float] = number("in the case farthest from holding", gaps=True)
    worst_oil: Series[str] = text("oil there; empty where oils are compared")
    worst_max_hertz_pressure_gpa: Series[float] = number(
        "P there; null where the case spans all P or has none", gaps=True
    )
    worst_entrainment_speed_m_s: Series[float] = number("U there", gaps=True)
    worst_inlet_temperature_c: Series[float] = number("T there", gaps=True)
    worst_slide_roll_ratio: Series[float] = number("S there", gaps=True)


class Selection(Table):
    """One place of the operating map: the oil that the paper's rules advise, and the numbers' own.

    Lambda is that of the traction rig's contact, for oils that may be stand-ins.
    """

    basis: Series[str] = text("as in the table of claims", one_of=("refit", "printed"))
    max_hertz_pressure_gpa: Series[float] = number("P", at_least=0)
    entrainment_speed_m_s: Series[float] = number("U", at_least=0)
    inlet_temperature_c: Series[float] = number("T")
    slide_roll_ratio: Series[float] = number("S, taken for the cage slip ratio")
    rule: Series[str] = text("first rule of selection.rules that applies")
    aim: Series[str] = text(
        "what it is after and the numbers are asked for", one_of=("most traction", "least heat")
    )
    advised_oil: Series[str] = text("first oil it prefers that has enough film; empty if none has")
    contradicting_rules: Series[str] = text(
        "later rules that apply as well and advise another oil, joined by '; '"
    )
    best_oil: Series[str] = text("oil that meets the aim best of those with enough film")
    judgement: Series[str] = text(
        "agree: the advised oil is best, or within selection.indifference of it; rule has none: "
        "no oil that it prefers has enough film, another has; no film: none has",
        one_of=("agree", "disagree", "rule has none", "no film"),
    )
    loss_ratio: Series[float] = number(
        "by how much mu of the advised oil misses the aim, relative to the best one's", gaps=True
    )
    advised_lambda_ratio: Series[float] = number("of the advised oil", at_least=0, gaps=True)
    best_lambda_ratio: Series[float] = number("of the best one", at_least=0, gaps=True)
    advised_traction_coefficient: Series[float] = number("mu of the advised oil", gaps=True)
    best_traction_coefficient: Series[float] = number("mu of the best one", gaps=True)


TABLES: dict[str, type[Table]] = {
    "printed_judged": PrintedJudged,
    "signs": Signs,
    "sign_verdicts": SignVerdicts,
    "claims": Claims,
    "selection": Selection,
}
# columns that no two rows of a table share
KEYS: dict[str, tuple[str, ...]] = {
    "printed_judged": ("oil",),
    "signs": ("oil", "signs"),
    "sign_verdicts": ("oil", "constant"),
    "claims": ("claim", "basis"),
    "selection": (
        "basis",
        "max_hertz_pressure_gpa",
        "entrainment_speed_m_s",
        "inlet_temperature_c",
        "slide_roll_ratio",
    ),
}
