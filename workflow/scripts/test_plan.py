"""Choose the rig conditions to test next."""

import oilfilm.run.job as run
from oilfilm.torque.next_tests import plan_table

with run.job(snakemake) as job:
    plan, reasons = plan_table(job.input_tables, job.settings)
    for reason in reasons:
        run.print_line(f"no plan: {reason}")
    job.write({"test_plan": plan})
