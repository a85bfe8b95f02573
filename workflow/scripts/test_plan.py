"""Choose the rig conditions to test next."""

from oilfilm.run.job import job, say
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.next_tests import plan_table

with job(snakemake) as (settings, provenance):
    plan, reasons = plan_table(CampaignTables.of_job(snakemake.input), settings)
    for reason in reasons:
        say(f"no plan: {reason}")
    write_tables({"test_plan": plan}, snakemake.output, provenance)
