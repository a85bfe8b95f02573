"""Describe the tables and figures of a campaign: a data package, and captions for a report."""

from pathlib import Path

from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.captions import film_unjudged_oils
from oilfilm.report.metadata import data_package
from oilfilm.report.rst import campaign_caption, figure_caption, table_caption
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, model_of
from oilfilm.tables.table_file import table_file

with job(snakemake) as (settings, _):
    studies.declare_tables(settings.campaign.studies)
    inputs, outputs, campaign = snakemake.input, snakemake.output, settings.campaign
    folder = Path(outputs.package).parent
    written = map(Path, (*inputs.tables, *inputs.samples))
    files = [table_file(path, folder) for path in written]
    write_text(data_package(settings, files), Path(outputs.package))
    unjudged = film_unjudged_oils(CampaignTables.of_job(inputs).points)
    write_text(campaign_caption(campaign, unjudged), Path(outputs.campaign))
    for path in map(Path, outputs.figures):
        write_text(figure_caption(path.stem, campaign, unjudged), path)
    for path in map(Path, outputs.captions):
        write_text(table_caption(model_of(path.stem), campaign, unjudged), path)
