"""What the keys of a campaign file must not say against each other.

Decides: which keys of a campaign contradict each other, and what a figure needs to be drawn.
"""

from collections.abc import Iterator

from oilfilm import studies
from oilfilm.figure_catalogue import figures
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings

Contradiction = tuple[tuple[object, ...], str]


def contradictions(settings: Settings) -> Iterator[Contradiction]:
    """Every contradiction: the key of the campaign file to blame, and a sentence."""
    campaign = settings.campaign
    if not [*campaign.oils, *campaign.oils_without_properties]:
        yield ("oils",), "the campaign names no oil; list at least one under `oils`."
    for oil in set(campaign.oils) & set(campaign.oils_without_properties):
        sentence = f"the oil {oil!r} is listed under `oils` too; keep it in one of the two."
        yield ("oils_without_properties",), sentence
    for rig in campaign.semantics_of_rig.keys() - set(campaign.rigs):
        known = ", ".join(campaign.rigs)
        yield ("semantics_of_rig", rig), f"{rig!r} is none of the campaign's rigs ({known})."
    yield from _named_twice(campaign)
    yield from _simulation(campaign)
    yield from _figures(settings)


def _named_twice(campaign: Campaign) -> Iterator[Contradiction]:
    """One name of a log for two of the project's."""
    torque = campaign.torque.columns if campaign.torque else {}
    of_columns = {("columns", key): column.name for key, column in campaign.columns.items()}
    of_torque = {("torque", "columns", key): column.name for key, column in torque.items()}
    of_header = {("header", key): names for key, names in campaign.header.items()}
    for named in (of_columns, of_torque, of_header):
        first: dict[str, tuple[str, ...]] = {}
        for steps, names in named.items():
            for name in names:
                other = first.setdefault(name, steps)
                if other != steps:
                    sentence = f"{name!r} is listed for {other[-1]!r} too; leave it with one."
                    yield steps, f"`{'.'.join(steps)}`: {sentence}"


def _simulation(campaign: Campaign) -> Iterator[Contradiction]:
    """What simulates the logs, and what it needs."""
    twin, torque_twin = campaign.twin, campaign.torque.twin if campaign.torque else None
    simulates = "twin" if twin or torque_twin else "simulated_by" if campaign.simulated_by else ""
    if simulates and campaign.data != "simulated":
        at = "data" if simulates == "twin" else simulates
        yield (at,), f"`{simulates}` simulates these logs: say `data: simulated`, or drop this key."
    if twin is not None and len(campaign.rigs) != 1:
        yield ("rigs",), "the rig twin simulates logs of one rig; name one."
    if twin is not None and campaign.matrix is None:
        yield ("twin",), "the rig twin needs a `matrix` of conditions."
    if twin is not None and campaign.simulated_by is not None:
        yield ("simulated_by",), "the rig twin simulates these logs: drop this key, or `twin`."
    if torque_twin is not None and twin is None:
        yield ("torque",), "the torque rig's twin needs the truth of the rig twin: add `twin`."
    for oil in {defect.oil for defect in torque_twin.defects} if torque_twin else ():
        if oil not in campaign.oils:
            sentence = f"a planted defect names the oil {oil!r}, which the campaign does not have."
            yield ("torque", "twin", "defects"), sentence


def _figures(settings: Settings) -> Iterator[Contradiction]:
    """Figures that do not exist, or that lack what they show."""
    campaign = settings.campaign
    for key, names, known in (
        ("figures", campaign.figures, [*figures()]),
        ("studies", campaign.studies, [*studies.available()]),
    ):
        for number, name in enumerate(names):
            if name not in known:
                allowed = ", ".join(map(repr, known))
                sentence = f"`{key}.{number}`: found {name!r}, expected one of {allowed}."
                yield (key, number), sentence
    for figure in (figures()[name] for name in campaign.figures if name in figures()):
        lacks = ""
        if figure.requires and getattr(campaign, figure.requires) is None:
            lacks = f"needs `{figure.requires}`; add it"
        elif figure.study and figure.study not in campaign.studies:
            lacks = f"belongs to the study {figure.study!r}; add `studies: [{figure.study}]`"
        if lacks:
            yield ("figures",), f"the figure `{figure.name}` {lacks}, or leave the figure out."
    shown = settings.figures.fig02.oil
    if "fig02" in campaign.figures and shown not in settings.oils:
        own = "name one of its own under `settings: {figures: {fig02: {oil: ...}}}`"
        yield ("figures",), f"fig02 shows the oil {shown!r}, which the campaign lacks; {own}."
