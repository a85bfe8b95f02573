"""Draw a family of figures and keep exactly what each draws."""

from pathlib import Path

from oilfilm import tables
from oilfilm.outputs.figures import FIGURES, style
from oilfilm.run.job import job
from oilfilm.settings.load import load_checked
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as provenance:
    config, inputs, outputs = dict(snakemake.params.config), snakemake.input, snakemake.output
    if "paper_tables" in inputs.keys():
        config["paper_tables"] = load_checked(Path(inputs.paper_tables), "paper_tables")
    results = CampaignTables.of_job(inputs)
    for png, svg, kept in zip(outputs.png, outputs.svg, outputs.drawn, strict=True):
        drawing = FIGURES[Path(png).stem]
        figure, drawn = drawing.draw(results, config)
        tables.write(drawn, drawing.table, Path(kept), provenance)
        style.save(figure, Path(png), Path(svg))
