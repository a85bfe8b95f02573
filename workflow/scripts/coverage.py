"""Count what a campaign covers and what each gate refused."""

from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    counted = {
        "coverage": coverage(results.runs, settings),
        "gate_counts": gate_counts(results.runs, results.points, results.quarantine),
    }
    write_tables(counted, snakemake.output, provenance)
