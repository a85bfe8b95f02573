"""Check the paper's claims and its advice on oils against the refit and the printed constants."""

from pathlib import Path

from oilfilm.paper.audit.audit import audit_campaign
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    inputs = snakemake.input
    results = CampaignTables.of_job(inputs)
    judged = audit_campaign(results, Path(inputs.printed), Path(inputs.claims), settings)
    write_tables(judged, snakemake.output, provenance)
