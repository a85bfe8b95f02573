"""Draw a family of figures and keep exactly what each draws."""

from pathlib import Path

from oilfilm import tables
from oilfilm.outputs.figures import FIGURES, Results, style
from oilfilm.run.job import job
from oilfilm.settings.load import load_checked

with job(snakemake) as provenance:
    config, given = dict(snakemake.params.config), dict(snakemake.input.items())
    if "paper_tables" in given:
        config["paper_tables"] = load_checked(Path(given.pop("paper_tables")), "paper_tables")
    results = Results.read(given)
    made = snakemake.output
    for png, svg, kept in zip(made.png, made.svg, made.drawn, strict=True):
        drawing = FIGURES[Path(png).stem]
        figure, drawn = drawing.draw(results, config)
        tables.write(drawn, drawing.table, Path(kept), provenance)
        style.save(figure, Path(png), Path(svg))
