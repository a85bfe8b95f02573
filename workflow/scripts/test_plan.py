"""Choose the rig conditions to test next."""

from oilfilm.run.job import job
from oilfilm.studies.next_tests import plan_table
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    plan, reasons = plan_table(CampaignTables.of_job(snakemake.input), settings)
    for reason in reasons:
        print(f"no plan: {reason}")
    write_tables({"test_plan": plan}, snakemake.output, provenance)
