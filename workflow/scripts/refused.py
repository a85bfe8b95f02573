"""Draw one page per refused run, and list which page shows which run."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import atomic_folder
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.report.figures.refused_runs import Judged, draw_pages, judged_torque_logs
from oilfilm.run.job import job, raw_logs
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_file import samples_by_run

with job(snakemake) as (settings, provenance):
    inputs = snakemake.input
    results = CampaignTables.of_job(inputs)
    samples = samples_by_run([Path(path) for path in inputs.samples])
    rigs = [Judged(TRACTION_RIG, results.runs, results.points, results.quarantine, samples)]
    if settings.campaign.torque is not None:
        refused = results.torque_quarantine
        logs = raw_logs(snakemake, f"{settings.campaign.name}-torque", provenance)
        sheet = RunSheet.of_plain(snakemake.params.sheet)
        rigs.append(judged_torque_logs(logs.only(refused["file"]), refused, settings, sheet))
    with atomic_folder(Path(snakemake.output.pages)) as folder:
        pages = draw_pages(rigs, settings, snakemake.params.pages_max, folder)
        tables.write(pages, "refused_pages", folder / "index.parquet", provenance)
