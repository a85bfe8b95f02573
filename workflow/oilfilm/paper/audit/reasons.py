"""Why a claim cannot be checked: the codes of the table of claims, and what they say."""

REASONS = {
    "no law": "an oil that it needs has no law of pressure, speed and temperature",
    "no film": "the film that it needs cannot be calculated, or is nowhere thick enough",
    "no lambda": "no point of an oil of the paper has a lambda",
    "no condition": "the box has no condition that the claim is about",
    "not printed": "the paper prints no constants, or no measured values, for it",
    "no comparison": "no law of that form was fitted to an oil of the paper",
    "no fit by the paper's law": "the comparison has no fit by the paper's own law",
    "tie": "the paper's own law made the SIMULATED points, and both laws tie by construction",
    "no torque": "there are no torque tests of an oil of the paper",
    "no torque by the law": "no torque was calculated from the law",
    "two truths": "the SIMULATED rigs have two truths, whose mu differ by more than "
    "audit.twin_misfit_max",
    "positive control": "the fitted law itself made the SIMULATED logs of both rigs: a positive "
    "control of the code",
}
