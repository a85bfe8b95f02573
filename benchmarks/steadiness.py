"""How often a change of the rig over its runs is named, and how often a steady campaign is accused.

Campaigns of 24 runs (29 with reference runs) are simulated as points and fitted with Deng's law.
The law is true for the oil `own` and wrong for all others.

    python benchmarks/steadiness.py                        (20 steady campaigns, each fault once)
    python benchmarks/steadiness.py clean [FIRST LAST]     (campaigns 0 to 299: alarms)
    python benchmarks/steadiness.py bad ORDER [SEEDS] [TRUTH ...]
                                                   (ten faults; random, conditions or references)
    python benchmarks/steadiness.py seen [FIRST LAST]
                                                   (changes of the size that is printed: how many
                                                   are named; campaigns 0 to 159)

A fault is named right if the course of the named change over the runs resembles the planted one: a
correlation of 0.9, which one wrong run of 24 leaves; 0.8 for faults that grow, or come and go. The
columns of `bad`:

    right        campaigns with an alarm that names the right runs
    alarm        campaigns with an alarm
    above        campaigns whose fault is larger than the smallest change that is printed
    right above  those of them that are named right
    told         campaigns that are named right, or whose fault is below the printed size
    effects      the effect that was named in the right ones, and how often

`seen` plants a trend, or a step from any run on, and compares its size with the one that is
printed for the campaign with it, as a laboratory sees it.

Takes 2 minutes; `clean` takes 5, `bad` 3 for each order, `seen` 10.
"""

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.surface.effects import EFFECT_NAMES
from oilfilm.surface.label_swap import likeliest_swap
from oilfilm.surface.misreading import likeliest_misreading
from oilfilm.surface.steadiness import (
    LARGEST_CHANGES,
    SteadinessLimits,
    largest_change,
    smallest_visible_changes,
    smallest_visible_size,
)
from oilfilm.surface.surface import Surface, fit_surface

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from bad_campaigns import (
    FAULTS,
    GRADUAL,
    WITHOUT_LABEL,
    BadCampaign,
    Fault,
    bad_campaign,
    day_and_night,
    no_fault,
)
from lawless_truths import TRUTHS
from surface_campaigns import SLIPS, fitted_law

# Truths for which Deng's law is wrong.
TRUTHS_OF_NO_LAW = ("jt", "ect", "sol", "rat", "mix", "pw")
SEEDS = 5
RUNS = 24
FEWEST_RUNS = SteadinessLimits().fewest_runs
# Sizes of planted changes over the one that the same campaign without it prints.
MULTIPLES = (1.0, 1.5, 2.0, 2.6)
# Limits of size over what the campaign with the change prints.
RATIOS = (0.0, 0.75, 1.0, 1.25, np.inf)


def judged(campaign: BadCampaign) -> tuple[str, np.ndarray, float, bool, Surface]:
    """What is named, and the surface it follows from.

    Returns:
        The effect, its course over the curves, its score, whether it is an alarm, and the surface.
    """
    surface = fitted_surface(campaign)
    change = largest_change(surface.misfit_covariance, campaign.position)
    swap, misreading = likeliest_swap(surface), likeliest_misreading(surface)
    if misreading is not None and misreading.is_alarm:
        return "factor", misreading.is_misread.astype(float), misreading.score, True, surface
    if swap is not None and swap.is_alarm and (change is None or swap.score > change.score):
        members = np.isin(np.arange(len(campaign.position)), swap.curve_indices).astype(float)
        return "labels", members, swap.score, True, surface
    if change is None:
        return "none", np.zeros(len(campaign.position)), 0.0, False, surface
    effect = f"{change.effect_name} {change.kind} {change.size:.3g}"
    return effect, change.pattern, change.score, change.is_alarm, surface


def clean(first: int, last: int) -> None:
    """Print the alarms of steady campaigns."""
    rows = []
    for number in range(first, last):
        is_true = number % 2 == 0
        truth = "own" if is_true else TRUTHS_OF_NO_LAW[number // 2 % len(TRUTHS_OF_NO_LAW)]
        # each oil in both orders
        order = ("random", "conditions")[(number // 2 + number // 2 // len(TRUTHS_OF_NO_LAW)) % 2]
        random = generator(23, "steady", str(number))
        campaign = bad_campaign(TRUTHS[truth], None, order, random, SLIPS)
        what, _, score, is_alarm, surface = judged(campaign)
        rows.append({"law": is_true, "order": order, "alarm": is_alarm})
        if is_alarm:
            kappa = surface.verdict.kappa
            print(f"{number} {truth} {order}: {what}, score {score:.1f}, kappa {kappa:.3f}")
    table = pd.DataFrame(rows)
    print(table.groupby(["law", "order"])["alarm"].agg(["sum", "count"]).to_string())


def bad(order: str, seeds: int, truths: tuple[str, ...]) -> None:
    """Print how often faults are named."""
    rows = []
    for truth in truths:
        for fault in FAULTS:
            for seed in range(seeds):
                random = generator(23, "fault", truth, fault.__name__, order, str(seed))
                campaign = bad_campaign(TRUTHS[truth], fault, order, random, SLIPS)
                what, pattern, score, is_alarm, surface = judged(campaign)
                likeness = 0.0
                if np.ptp(pattern) > 0:
                    likeness = abs(np.corrcoef(pattern, campaign.pattern)[0, 1])
                right = is_alarm and likeness > (0.8 if fault in GRADUAL else 0.9)
                smallest = printed_size(campaign, surface, fault)
                rows.append(
                    {
                        "truth": truth,
                        "fault": fault.__name__,
                        "right": right,
                        "alarm": is_alarm,
                        "above": campaign.size > smallest,
                        "right above": right and campaign.size > smallest,
                        "told": right or campaign.size <= smallest,
                        "effects": what.rsplit(" ", 1)[0] if right else "",
                    }
                )
                print(
                    f"{truth} {fault.__name__} {seed}: {what}, score {score:.1f}, "
                    f"likeness {likeness:.2f}, planted {campaign.size:.3g}, seen {smallest:.3g}",
                    file=sys.stderr,
                    flush=True,
                )
    table = pd.DataFrame(rows)
    numbers = ["right", "alarm", "above", "right above", "told"]
    for group in (["truth", "fault"], ["truth"]):
        grouped = table.groupby(group, sort=False)
        summary = grouped[numbers].sum()
        summary["of"] = grouped.size()
        if len(group) > 1:
            counts = [Counter(filter(None, column)) for _, column in grouped["effects"]]
            summary["effects"] = [
                ", ".join(f"{name} {n}" for name, n in count.most_common()) for count in counts
            ]
        print(summary.to_string(), end="\n\n")


def seen(first: int, last: int) -> None:
    """Print how many changes are named, over their size in units of the printed one."""
    rows = []
    for number in range(first, last):
        truth = "own" if number % 2 == 0 else TRUTHS_OF_NO_LAW[number // 2 % len(TRUTHS_OF_NO_LAW)]
        order = ("random", "conditions")[number // 2 % 2]
        effect = EFFECT_NAMES[number // 4 % len(EFFECT_NAMES)]
        course = ("trend", "step")[number // 16 % 2]
        random = generator(23, "seen change", str(number))
        begin = int(random.integers(FEWEST_RUNS, RUNS - FEWEST_RUNS + 1))
        sign = float(random.choice([-1, 1]))
        steady = seen_campaign(truth, order, number, None)
        printed = printed_change(fitted_surface(steady), steady, effect, course)
        sizes = np.array(MULTIPLES) * printed
        # no rig has a larger one
        for size in sizes[sizes <= LARGEST_CHANGES.size_of(effect)].tolist():
            fault = change_of(effect, course, begin, sign * size)
            campaign = seen_campaign(truth, order, number, fault)
            _, pattern, _, is_alarm, surface = judged(campaign)
            likeness = 0.0
            if np.ptp(pattern) > 0:
                likeness = abs(np.corrcoef(pattern, campaign.pattern)[0, 1])
            right = is_alarm and likeness > (0.8 if course == "trend" else 0.9)
            over_printed = size / printed_change(surface, campaign, effect, course)
            rows.append(
                {"law": truth == "own", "order": order, "size/printed": over_printed}
                | {"alarm": is_alarm, "right": right}
            )
    table = pd.DataFrame(rows)
    table["size/printed"] = pd.cut(table["size/printed"], RATIOS)
    for group in (["law", "order", "size/printed"], ["size/printed"]):
        grouped = table.groupby(group, observed=True)
        summary = grouped[["alarm", "right"]].mean().round(2)
        summary["of"] = grouped.size()
        print(summary.to_string(), end="\n\n")


def fitted_surface(campaign: BadCampaign) -> Surface:
    """The surface about Deng's law."""
    return fit_surface(campaign.measured, fitted_law(campaign.measured))


def printed_change(surface: Surface, campaign: BadCampaign, effect: str, course: str) -> float:
    """The smallest change of a course that is printed for a campaign."""
    sizes = smallest_visible_changes(surface.misfit_covariance, campaign.position)
    return float(getattr(sizes, course)[effect])


def seen_campaign(truth: str, order: str, number: int, fault: Fault | None) -> BadCampaign:
    """The campaign of this number; its errors are the same with any fault."""
    return bad_campaign(TRUTHS[truth], fault, order, generator(23, "seen", str(number)), SLIPS)


def change_of(effect: str, course: str, begin: int, size: float) -> Fault:
    """A fault that changes one effect of runs.

    Args:
        effect: The effect.
        course: trend or step.
        begin: Position of the first run of a step.
        size: Size in the unit of the effect.
    """

    def fault(conditions, position, random):
        if course == "trend":
            pattern = position / (len(position) - 1)
        else:
            pattern = (position >= begin).astype(float)
        planted = no_fault(conditions, pattern, effect, size)
        planted.true_conditions[:, 2] += size * pattern * (effect == "temperature_k")
        return replace(
            planted,
            gain=np.exp(size * pattern * (effect == "gain")),
            zero=size * pattern * (effect == "zero"),
            slip_factor=np.exp(size * pattern * (effect == "slip_scale")),
        )

    return fault


def printed_size(campaign: BadCampaign, surface: Surface, fault: object) -> float:
    """The smallest change that is printed for the effect and the course of the fault.

    Sizes are printed for a trend and a step. That of day and night is found in the same way. It is
    infinite for runs that nothing tells apart but mu: no size is printed for these.
    """
    smallest = smallest_visible_changes(surface.misfit_covariance, campaign.position)
    effect = campaign.planted.effect
    if not effect:
        return 0.0
    if fault in WITHOUT_LABEL:
        return np.inf
    if fault is day_and_night:
        # it has a course of its own, which goes from -1 to 1
        return smallest_visible_size(surface.misfit_covariance, effect, campaign.pattern / 2)
    grows = np.unique(campaign.pattern).size > 2
    return (smallest.trend if grows else smallest.step)[effect]


def main(arguments: list[str]) -> None:
    """Print the table that the arguments ask for."""
    match arguments:
        case []:
            clean(0, 20)
            bad("random", 1, ("own", "jt"))
        case ["clean", first, last]:
            clean(int(first), int(last))
        case ["clean"]:
            clean(0, 300)
        case ["seen", first, last]:
            seen(int(first), int(last))
        case ["seen"]:
            seen(0, 160)
        case ["bad", order, *rest]:
            seeds = int(rest[0]) if rest else SEEDS
            bad(order, seeds, tuple(rest[1:]) or ("own", "jt"))
        case _:
            raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
