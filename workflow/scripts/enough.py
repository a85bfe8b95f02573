"""Write down the accepted runs; end the run where there are too few."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.report.enough import accepted_runs_text
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, _):
    results = CampaignTables.of_job(snakemake.input)
    text = accepted_runs_text(results, settings.campaign)
    write_text(text, Path(snakemake.output.accepted_runs))
