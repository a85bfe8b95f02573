"""Write the captions of figures and tables for Snakemake's report."""

from pathlib import Path

from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.facts import film_unjudged_oils
from oilfilm.report.rst import campaign_caption, figure_caption, table_caption
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, model_of

with job(snakemake) as (settings, _):
    studies.declare_tables(settings.campaign.studies)
    campaign = settings.campaign
    outputs = snakemake.output
    unjudged = film_unjudged_oils(CampaignTables.of_job(snakemake.input).points)
    texts = {outputs.campaign: campaign_caption(campaign, unjudged)}
    texts |= {path: figure_caption(Path(path).stem, campaign, unjudged) for path in outputs.figures}
    texts |= {
        path: table_caption(model_of(Path(path).stem), campaign, unjudged)
        for path in outputs.tables
    }
    for path, text in texts.items():
        write_text(text, Path(path))
