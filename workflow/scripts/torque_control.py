"""Say what the comparison with simulated torque can show."""

from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.torque_control import torque_control

with job(snakemake) as (settings, provenance):
    control = torque_control(CampaignTables.of_job(snakemake.input), settings)
    write_tables({"torque_control": control}, snakemake.output, provenance)
