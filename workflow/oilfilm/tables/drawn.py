"""Tables of figures: exactly what each draws."""

from oilfilm.tables.columns import table, use
from oilfilm.units import ABSOLUTE_ZERO_C

# fmt: off
_DRAWN = "Rows are what is drawn, in the order of drawing: two marks may be the same."
TABLES = (
    table("coefficient_table", "Drawn in the table of constants: fitted and printed constants (Eqs "
        "11-13).",
        columns="""
            oil constant value standard_error printed_value""",
        key=("oil", "constant"),
    ),
    table("schematic", "Drawn in the schematic of a rig: one row per mark, later ones above.",
        columns="""
            panel mark kind x y to_x to_y words""",
        uses=(
            use("kind", "material or action, which gives the colour; empty where there is none"),
            use("x", "start, in units of the drawing", required=True),
            use("y", "start, in units of the drawing", required=True),
            use("to_x", "in units of the drawing"),
            use("to_y", "in units of the drawing"),
        ),
        no_key=_DRAWN,
    ),
    table("stated_values", "Drawn in the tables of oils, test matrix and bearing: one row per cell "
        "(Tables 1-3).",
        columns="""
            thing quantity unit words value source""",
        uses=(
            use("words", "text of the cell; * marks what is assumed"),
            use("value", "null where there is only text"),
        ),
        no_key=_DRAWN,
    ),
    table("curves", "Drawn in a figure of mu against slip.",
        columns="""
            panel series kind oil slide_roll_ratio traction_coefficient traction_coefficient_se""",
        uses=(
            use("kind", "measured: points; fit: line", allowed=("measured", "fit")),
            use("slide_roll_ratio", "abscissa", required=True),
            use("traction_coefficient", "ordinate", required=True),
            use("traction_coefficient_se", "the bar drawn is 1.96 times as long to either side; "
                "none where null"),
        ),
        no_key=_DRAWN,
    ),
    table("coverage_map", "Drawn in the coverage map: one row per cell, all rigs together.",
        columns="""
            panel oil nominal_inlet_temperature_c nominal_entrainment_speed_m_s
            nominal_max_hertz_pressure_gpa nominal_load_n runs_accepted runs state planned""",
        uses=(
            use("nominal_inlet_temperature_c", "of the panel"),
            use("nominal_entrainment_speed_m_s", "abscissa"),
            use("nominal_max_hertz_pressure_gpa", "ordinate"),
            use("nominal_load_n", "ordinate without pressure"),
            use("runs_accepted", "first number of the cell"),
            use("runs", "second number of the cell: all runs"),
            use("state", "symbol and colour of the cell"),
            use("planned", "false: drawn with a broken edge, if there is a matrix"),
        ),
        no_key=_DRAWN,
    ),
    table("law_panels", "Drawn in the figure of the laws' weaknesses (Fig. 4).",
        columns="""
            panel law oil kind x y""",
        uses=(
            use("kind", "zero slip: mu at zero slip at a tested condition; the others: error of a "
                "law over mu",
                allowed=("zero slip", "fitted curves", "curve left out", "end level left out")),
            use("y", "of errors: position of the row", required=True),
        ),
        no_key=_DRAWN,
    ),
    table("model_curves", "Drawn in a figure of the law's curves (Figs 7-10): one row per vertex "
        "of a line.",
        columns="""
            panel oil series max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c
            slide_roll_ratio traction_coefficient traction_coefficient_lower
            traction_coefficient_upper extrapolated""",
        uses=(
            use("oil", "colour of the line"),
            use("series", "refit: full line in its interval; printed: thin dashed line",
                allowed=("refit", "printed")),
            use("max_hertz_pressure_gpa", required=True),
            use("entrainment_speed_m_s", required=True, at_least=0),
            use("inlet_temperature_c", required=True, at_least=ABSOLUTE_ZERO_C),
            use("slide_roll_ratio", required=True, at_least=0),
            use("traction_coefficient", "ordinate", required=True),
            use("traction_coefficient_lower", "lower edge of the band, none where null"),
            use("traction_coefficient_upper", "upper edge of the band"),
        ),
        no_key=_DRAWN,
    ),
    table("residuals_drawn", "Drawn in the figure of residuals: one row per point or mean.",
        columns="""
            panel oil condition kind x y spread""",
        uses=(
            use("kind", "a plateau, or the mean of a level", allowed=("point", "mean")),
            use("y", "measured minus fitted mu, in thousandths", required=True),
        ),
        no_key=_DRAWN,
    ),
    table("identifiability", "Drawn in the figure of identifiability: one row per square or "
        "vertex.",
        columns="""
            panel oil kind constant other x value""",
        uses=(
            use("kind", "square or vertex of a line", allowed=("correlation", "profile")),
            use("x", "of a profile: distance in standard errors"),
            use("value", "colour of a square, ordinate of a profile"),
        ),
        no_key=_DRAWN,
    ),
    table("extrapolation_panels", "Drawn in the figure of the extrapolation.",
        columns="""
            panel kind law oil x y""",
        uses=(
            use("kind", "what the ordinate is: true mu, fitted mu, or a law's relative rms error",
                allowed=("true", "fit", "error")),
            use("law", "empty for the truth"),
            use("x", "S; U in m/s; P in GPa; T in degC; relative rms error in the tested box"),
            use("y", "mu, or relative rms error beyond the box"),
        ),
        no_key=_DRAWN,
    ),
    table("sign_study", "Drawn in the figure of the sign study.",
        columns="""
            panel oil series words x value weakest_margin""",
        uses=(
            use("series", "all sets, set in use, best set, or margin and its verdict"),
            use("words", "signs, statement, or exponent with its sign"),
            use("x", "rank of a total"),
            use("value", "total, share or margin", required=True),
            use("weakest_margin", "tick on the bar of a margin"),
        ),
        no_key=_DRAWN,
    ),
    table("claims_page", "Drawn on the page of claims: one row per claim and basis.",
        columns="""
            claim statement basis verdict share share_tested_box words""",
        uses=(
            use("basis", "first line refit, second printed"),
            use("verdict", "colour and symbol"),
            use("share", "length of the bar"),
            use("share_tested_box", "position of the tick"),
            use("words", "to the right of the bar"),
        ),
        key=("claim", "basis"),
    ),
    table("selection_map", "Drawn in the map of oils: one row per cell.",
        columns="""
            panel basis inlet_temperature_c slide_roll_ratio entrainment_speed_m_s
            max_hertz_pressure_gpa advised_oil best_oil judgement""",
        uses=(
            use("inlet_temperature_c", "of the panel", required=True),
            use("slide_roll_ratio", "of the panel", required=True),
            use("entrainment_speed_m_s", "abscissa", required=True, at_least=0),
            use("max_hertz_pressure_gpa", "ordinate", required=True),
            use("advised_oil", "colour of the cell; white where empty"),
            use("best_oil", "symbol, drawn where the judgement is not agree"),
            use("judgement", "as in selection"),
        ),
        no_key=_DRAWN,
    ),
    table("torque_drawn", "Drawn in a figure of torque against speed.",
        columns="""
            panel series oil axial_load_n inner_speed_rpm torque_n_m torque_n_m_se
            relative_error""",
        uses=(
            use("series", "measured, or the load variable of the law"),
            use("axial_load_n", "mean of the set of points"),
            use("inner_speed_rpm", "abscissa"),
            use("torque_n_m", "ordinate of the panels of torque"),
            use("torque_n_m_se", "the bar drawn is 1.96 times as long to either side"),
            use("relative_error", "ordinate of the panels of error"),
        ),
        no_key=_DRAWN,
    ),
    table("cage_slip_map", "Drawn in the map of cage slip: one row per cell.",
        columns="""
            panel oil pitch_speed_mm_rpm axial_load_n cage_slip advised_oil best_oil judgement""",
        uses=(
            use("oil", "of the panel; empty in the last one, which shows the advice"),
            use("pitch_speed_mm_rpm", "abscissa"),
            use("axial_load_n", "ordinate"),
            use("cage_slip", "colour of the cell, and the line at the limit"),
            use("advised_oil", "colour of the cell of the last panel"),
            use("best_oil", "symbol, drawn where the judgement is not agree"),
            use("judgement", "as in slip_advice"),
        ),
        no_key=_DRAWN,
    ),
)
