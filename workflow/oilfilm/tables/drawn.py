"""The table of what a figure draws, the same for every figure.

Decides: what is stored of a figure.
"""

from oilfilm.tables.columns import declare_columns, number, table, text, use
from oilfilm.tables.declaration import BY_ROW

# fmt: off
_PANEL_UNIT = "unit and meaning: title and axis of the panel, which are in the file's footer"
declare_columns(
    text("panel", "letter of the panel, or column of a table that is drawn"),
    text("series", "line, symbol or row of the panel"),
    text("words", "text that is drawn, or what tells a mark apart"),
    number("x", BY_ROW, "abscissa", _PANEL_UNIT),
    number("y", BY_ROW, "ordinate", _PANEL_UNIT),
    number("y_lower", BY_ROW, "lower end of a bar or band", _PANEL_UNIT),
    number("y_upper", BY_ROW, "upper end of a bar or band", _PANEL_UNIT),
)
TABLES = (
    table(
        "drawn",
        "What a figure draws: one row per mark or vertex of a line.",
        columns="panel series oil words x y value y_lower y_upper",
        uses=(
            use("oil", "empty where the mark is of none"),
            use("value", "what a colour or a number shows"),
        ),
        no_key="Rows are in the order of drawing; two marks may be the same.",
    ),
)
# fmt: on
