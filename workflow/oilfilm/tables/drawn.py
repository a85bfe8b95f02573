"""The table of what a figure draws, the same for every figure."""

from oilfilm.tables.columns import table, use

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
