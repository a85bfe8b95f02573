"""What the keys of a campaign file must not say against each other, one named check each."""

from collections.abc import Iterator

from oilfilm.figure_catalogue import figures
from oilfilm.settings.resolved import Settings

Contradiction = tuple[tuple[object, ...], str]


def contradictions(settings: Settings) -> Iterator[Contradiction]:
    """Every contradiction: the key of the campaign file to blame, and a sentence."""
    for find in (
        _oils_are_named_once,
        _figures_show_oils_of_the_campaign,
        _rigs_with_semantics_are_rigs_of_the_campaign,
        _twin_has_what_it_needs,
        _simulator_is_named_once,
        _torque_twin_has_what_it_needs,
        _figures_have_what_they_show,
    ):
        yield from find(settings)


def _oils_are_named_once(settings: Settings) -> Iterator[Contradiction]:
    known, unknown = settings.campaign.oils, settings.campaign.oils_without_properties
    if not [*known, *unknown]:
        yield ("oils",), "the campaign names no oil; list at least one under `oils`."
    for oil in known:
        if oil in unknown:
            yield (
                ("oils_without_properties",),
                f"the oil {oil!r} is listed under `oils` too; keep it in one of the two.",
            )


def _figures_show_oils_of_the_campaign(settings: Settings) -> Iterator[Contradiction]:
    campaign = settings.campaign
    shown = settings.figures.fig02.oil
    if "fig02" in campaign.figures and shown not in (
        *campaign.oils,
        *campaign.oils_without_properties,
    ):
        yield (
            ("figures",),
            f"fig02 shows the oil {shown!r} (figures.fig02.oil of config.yaml), which the campaign "
            "does not have; name one of its own under `settings: {figures: {fig02: {oil: ...}}}`.",
        )
    shown = settings.figures.extrapolation.oil
    if "extrapolation" in campaign.figures and campaign.twin and shown not in campaign.oils:
        yield (
            ("figures",),
            f"extrapolation shows the oil {shown!r} (figures.extrapolation.oil of config.yaml), "
            "which the twin does not simulate; name one of its own under `settings: {figures: "
            "{extrapolation: {oil: ...}}}`.",
        )


def _rigs_with_semantics_are_rigs_of_the_campaign(settings: Settings) -> Iterator[Contradiction]:
    rigs = settings.campaign.rigs
    for rig in settings.campaign.semantics_of_rig:
        if rig not in rigs:
            yield (
                ("semantics_of_rig", rig),
                f"{rig!r} is none of the campaign's rigs ({', '.join(rigs)}).",
            )


def _twin_has_what_it_needs(settings: Settings) -> Iterator[Contradiction]:
    campaign = settings.campaign
    if campaign.twin is None:
        return
    if campaign.data != "simulated":
        yield ("data",), "the rig twin simulates these logs: say `data: simulated`, or drop `twin`."
    if len(campaign.rigs) != 1:
        yield ("rigs",), "the rig twin simulates logs of one rig; name one."
    if campaign.matrix is None:
        yield ("twin",), "the rig twin needs a `matrix` of conditions."


def _simulator_is_named_once(settings: Settings) -> Iterator[Contradiction]:
    campaign = settings.campaign
    if campaign.simulated_by is None:
        return
    if campaign.data != "simulated":
        yield (
            ("simulated_by",),
            "these logs are simulated: say `data: simulated`, or drop this key.",
        )
    if campaign.twin is not None:
        yield ("simulated_by",), "the rig twin simulates these logs: drop this key, or `twin`."


def _torque_twin_has_what_it_needs(settings: Settings) -> Iterator[Contradiction]:
    campaign = settings.campaign
    if campaign.torque is None or campaign.torque.twin is None:
        return
    if campaign.data != "simulated":
        yield (
            ("data",),
            "the torque rig's twin simulates logs: say `data: simulated`, or drop `twin`.",
        )
    if campaign.twin is None:
        yield ("torque",), "the torque rig's twin needs the truth of the rig twin: add `twin`."
    for defect in campaign.torque.twin.defects:
        if defect.oil not in campaign.oils:
            yield (
                ("torque", "twin", "defects"),
                f"a planted defect names the oil {defect.oil!r}, which the campaign does not have.",
            )


def _figures_have_what_they_show(settings: Settings) -> Iterator[Contradiction]:
    for name in settings.campaign.figures:
        study, needed = figures()[name].study, figures()[name].requires
        if needed and getattr(settings.campaign, needed) is None:
            yield (
                ("figures",),
                f"the figure `{name}` needs `{needed}`, which the campaign does not have; add it, "
                "or leave the figure out.",
            )
        if study and study not in settings.campaign.studies:
            yield (
                ("figures",),
                f"the figure `{name}` belongs to the study {study!r}; add `studies: [{study}]`, or "
                "leave the figure out.",
            )
