"""Write the captions of figures and tables for Snakemake's report."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.outputs.rst import campaign_caption, figure_caption, table_caption
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import model_of

with job(snakemake) as (settings, _):
    campaign = settings.campaign
    outputs = snakemake.output
    texts = {outputs.campaign: campaign_caption(campaign)}
    texts |= {path: figure_caption(Path(path).stem, campaign) for path in outputs.figures}
    texts |= {path: table_caption(model_of(Path(path).stem), campaign) for path in outputs.tables}
    for path, text in texts.items():
        write_text(text, Path(path))
