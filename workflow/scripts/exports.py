"""Write every oil's fit in the forms that bearing codes use."""

from pathlib import Path

from oilfilm.atomic_write import atomic_folder, write_bytes
from oilfilm.exports.campaign import export_campaign
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    files = export_campaign(results, settings, provenance)
    with atomic_folder(Path(snakemake.output.folder)) as folder:
        for name, content in files.items():
            write_bytes(content, folder / name)
