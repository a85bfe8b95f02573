"""How often a change of the rig over its runs is named, and how often a steady campaign is accused.

Campaigns of 24 runs (29 with reference runs) are simulated as points and fitted with Deng's law.
The law is true for the oil `own` and wrong for all others.

    python benchmarks/steadiness.py                        (20 steady campaigns, each fault once)
    python benchmarks/steadiness.py clean [FIRST LAST]     (campaigns 0 to 299: alarms)
    python benchmarks/steadiness.py bad ORDER [SEEDS] [TRUTH ...]
                                                   (ten faults; random, conditions or references)

A fault is named right if the course of the named change over the runs resembles the planted one: a
correlation of 0.9, which one wrong run of 24 leaves; 0.8 for faults that grow, or come and go. The
columns of `bad`:

    right        campaigns with an alarm that names the right runs
    alarm        campaigns with an alarm
    above        campaigns whose fault is larger than the smallest change that is printed
    right above  those of them that are named right
    told         campaigns that are named right, or whose fault is below the printed size
    effects      the effect that was named in the right ones, and how often

Takes 3 minutes; `clean` takes 20, `bad` 5 for each order.
"""

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.surface.label_swap import swapped_temperatures
from oilfilm.surface.misreading import misread_runs
from oilfilm.surface.steadiness import largest_change, smallest_changes, smallest_seen
from oilfilm.surface.surface import Surface, fit_surface

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from bad_campaigns import FAULTS, GRADUAL, WITHOUT_LABEL, BadCampaign, bad_campaign, day_and_night
from lawless_truths import TRUTHS
from surface_campaigns import SLIPS, fitted_law

WRONG = ("jt", "ect", "sol", "rat", "mix", "pw")
SEEDS = 5


def judged(campaign: BadCampaign) -> tuple[str, np.ndarray, float, bool, Surface]:
    """What is named: the effect, its course over the curves, its score, whether it is an alarm."""
    surface = fit_surface(campaign.measured, fitted_law(campaign.measured))
    change = largest_change(surface.misfit_covariance, campaign.order)
    swap, misreading = swapped_temperatures(surface), misread_runs(surface)
    if misreading is not None and misreading.is_alarm:
        return "factor", misreading.members.astype(float), misreading.score, True, surface
    if swap is not None and swap.is_alarm and (change is None or swap.score > change.score):
        members = np.isin(np.arange(len(campaign.order)), swap.curves).astype(float)
        return "labels", members, swap.score, True, surface
    if change is None:
        return "none", np.zeros(len(campaign.order)), 0.0, False, surface
    effect = f"{change.effect} {change.kind} {change.size:.3g}"
    return effect, change.pattern, change.score, change.is_alarm, surface


def clean(first: int, last: int) -> None:
    """Print the alarms of steady campaigns."""
    rows = []
    for number in range(first, last):
        is_true = number % 2 == 0
        truth = "own" if is_true else WRONG[number // 2 % len(WRONG)]
        # each oil in both orders
        order = ("random", "conditions")[(number // 2 + number // 2 // len(WRONG)) % 2]
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


def printed_size(campaign: BadCampaign, surface: Surface, fault: object) -> float:
    """The smallest change that is printed for the effect and the course of the fault.

    Sizes are printed for a trend and a step. That of day and night is found in the same way. It is
    infinite for runs that nothing tells apart but mu: no size is printed for these.
    """
    smallest = smallest_changes(surface.misfit_covariance, campaign.order)
    effect = campaign.planted.effect
    if not effect:
        return 0.0
    if fault in WITHOUT_LABEL:
        return np.inf
    if fault is day_and_night:
        # it has a course of its own, which goes from -1 to 1
        return smallest_seen(surface.misfit_covariance, effect, campaign.pattern / 2)
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
        case ["bad", order, *rest]:
            seeds = int(rest[0]) if rest else SEEDS
            bad(order, seeds, tuple(rest[1:]) or ("own", "jt"))
        case _:
            raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
