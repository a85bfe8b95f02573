"""Write the report of a campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.outputs.report.page import page
from oilfilm.outputs.report.sections import Results
from oilfilm.run.job import job

with job(snakemake) as provenance:
    found = snakemake.input
    refused = Path(found.refused)
    paths = {
        name: [Path(found[name])] if isinstance(found[name], str) else map(Path, found[name])
        for name in Results.models()
        if name in found.keys()
    }
    paths["refused_pages"] = [refused / "index.parquet"]
    models = Results.models()
    results = Results(**{name: tables.read(models[name], *paths[name]) for name in models})
    pairs = zip(map(Path, found.png), map(Path, found.svg), strict=True)
    drawn = {png.stem: (png, svg) for png, svg in pairs}
    text = page(results, drawn, refused, snakemake.params.config, provenance)
    write_text(text, Path(snakemake.output.page))
