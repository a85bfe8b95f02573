"""What the JSON export of a fitted law looks like; null where a number is not known."""

from typing import Annotated, Literal

from pydantic import Field

from oilfilm.settings.base import Group, key

Ends = Annotated[list[float | None], Field(min_length=2, max_length=2)]


class CampaignFacts(Group):
    """The campaign behind the fit."""

    name: str = key("Campaign.")
    description: str = key("What was measured or simulated.")


class LawFacts(Group):
    """The law's equation."""

    name: str = key("Law.")
    mu_for_slip_of_0_or_more: str = key(
        "mu from the coefficients, its parts and S; operators and functions as in Python."
    )
    parts_of_mu: dict[str, str] = key("Parts of mu, in the order in which they are computed.")
    mu_for_slip_below_0: Literal["-mu(-S)"] = key("mu is odd in S.")
    coefficients: str = key("How the coefficients depend on the conditions.")
    known_exponents: dict[str, list[float]] = key(
        "Exponents that the law gives, by coefficient; they are no constants of the fit."
    )
    source: str = key("Where the law was published.")


class ConditionFacts(Group):
    """An operating condition of the law, or S."""

    name: str = key("Name, ending in its unit.")
    symbol: Literal["P", "U", "T", "W", "Q", "V", "Z", "S"] = key("Symbol in the equation.")
    meaning: str = key("What it is.")
    unit: str = key("Unit.")
    role: Literal["argument", "fixed"] = key("fixed: mu is known at `level` alone.")
    level: float | None = key("The one level tested of a fixed condition.")
    reference: float | None = key("Level where its power is 1.")
    tested: Ends = key("Smallest and largest value tested; of |S| for the slide-roll ratio.")


class ConstantFacts(Group):
    """A constant of the law, sign included."""

    name: str = key("Name as in the law.")
    meaning: str = key("What it is.")
    value: float | None = key("Fitted value.")
    unit: Literal["1"] = key("Unit.")
    standard_error: float | None = key("From the bootstrap over whole runs.")
    interval_95: Ends = key("2.5 % and 97.5 % quantile of the bootstrap.")
    systematic_standard_error: float | None = key("From the calibration of the rig's sensors.")
    verdict: Literal["known", "sign unknown", "no interval", "at a bound", "not identifiable"] = (
        key("sign unknown: zero is within the errors, for all constants together.")
    )


class FitFacts(Group):
    """How good the fit is."""

    certified: bool = key("Whether the optimum is proven.")
    verdict: str = key("The certificate in a sentence.")
    points: int = key("Accepted points.", ge=0)
    runs: int = key("Runs that they come from.", ge=0)
    rms_error_of_mu: float | None = key("Root of the mean squared error.", unit="1")
    largest_error_of_mu: float | None = key("Largest error.", unit="1")
    fixed_conditions: str = key("Conditions that gave no exponent.")


class AdorePoint(Group):
    """The ADORE form at one operating point."""

    max_hertz_pressure_gpa: float | None = key("Pressure.", unit="GPa", default=None)
    load_n: float | None = key("Load, of laws on load.", unit="N", default=None)
    entrainment_speed_m_s: float | None = key("Speed.", unit="m/s")
    inlet_temperature_c: float | None = key("Temperature.", unit="degC")
    A: float = key("Constant of the form.", unit="1")
    B: float = key("Constant of the form.", unit="s/m")
    C: float = key("Constant of the form.", unit="s/m")
    D: float = key("Constant of the form.", unit="1")
    mu_at_rest: float = key("mu without slip.", unit="1")
    mu_far_beyond_peak: float = key("mu at large slip.", unit="1")
    peak_slip_velocity: float = key("Slip velocity of the peak.", unit="m/s")
    peak_mu: float = key("Largest mu.", unit="1")
    outside_tested_box: bool = key("Pressure, speed or temperature was not tested.")
    peak_outside_tested_slip: bool = key("No slip as large as the peak's was tested.")


class AdoreFacts(Group):
    """The ADORE form at single operating points."""

    form: str = key("The form.")
    units: dict[str, str] = key("Unit of each constant.")
    points: list[AdorePoint] = key("Operating points; empty where mu is unknown.")


class ProvenanceFacts(Group):
    """Digests of what the fit was made from."""

    code: str = key("Digest of the code.")
    settings: str = key("Digest of the settings.")
    inputs: dict[str, str] = key("Digest of each input.")


class ExportFile(Group):
    """results/<campaign>/exports/<oil>/traction_<oil>.json."""

    format: Literal["oilfilm traction law"] = key("Kind of file.")
    format_version: Literal[2] = key("Version of the format.")
    oil: str = key("Oil as in the configuration.")
    campaign: CampaignFacts = key("The campaign.")
    data: Literal["measured", "simulated"] = key("Whether a rig or a rig twin gave the data.")
    law: LawFacts = key("The law.")
    conditions: Annotated[list[ConditionFacts], Field(min_length=2)] = key(
        "The law's operating conditions, and S."
    )
    constants: Annotated[list[ConstantFacts], Field(min_length=1)] = key("The constants.")
    fit: FitFacts = key("How good the fit is.")
    adore: AdoreFacts = key("The ADORE form.")
    files: dict[str, str] = key("By form: the file beside this one.")
    not_written: dict[str, str] = key("By form: why there is no such file.")
    provenance: ProvenanceFacts = key("What the fit was made from.")
