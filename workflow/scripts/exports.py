"""Write every oil's fit in the forms that bearing codes use."""

from pathlib import Path

from oilfilm import tables
from oilfilm.exports import export_campaign
from oilfilm.job import job

with job(snakemake) as provenance:
    found = snakemake.input
    files = export_campaign(
        points=tables.read("points", Path(found.points)),
        coefficients=tables.read("coefficients", Path(found.coefficients)),
        quality=tables.read("fit_quality", Path(found.quality)),
        config=snakemake.params.config,
        provenance=provenance,
    )
    for name, text in files.items():
        path = Path(snakemake.output.folder, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="")
