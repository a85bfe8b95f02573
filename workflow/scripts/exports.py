"""Write every oil's fit in the forms that bearing codes use."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import atomic_folder, write_text
from oilfilm.outputs.exports import export_campaign
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings

with job(snakemake) as provenance:
    inputs = snakemake.input
    files = export_campaign(
        points=tables.read("points", Path(inputs.points)),
        coefficients=tables.read("coefficients", Path(inputs.coefficients)),
        quality=tables.read("fit_quality", Path(inputs.quality)),
        settings=Settings.of(snakemake.params.config),
        provenance=provenance,
    )
    with atomic_folder(Path(snakemake.output.folder)) as folder:
        for name, text in files.items():
            write_text(text, folder / name)
