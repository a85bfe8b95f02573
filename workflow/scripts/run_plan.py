"""Plan the runs that the campaign lacks."""

import oilfilm.run.job as run
from oilfilm.torque.run_plan import run_plan_table

with run.job(snakemake) as job:
    plan, reasons = run_plan_table(job.input_tables, job.settings)
    for reason in reasons:
        run.print_line(f"no plan of runs: {reason}")
    job.write({"run_plan": plan})
