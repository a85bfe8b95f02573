"""Run the script of one rule in this process, without a Snakemake run: for a debugger or a prompt.

    .venv/bin/python -m pdb workflow/stand_in.py fit oil=4102
    .venv/bin/python workflow/stand_in.py figures figure=fig02 campaign=thermal

Inputs must exist from an earlier run. In a Python prompt at the top folder:

    >>> sys.path.insert(0, "workflow")
    >>> from stand_in import stand_in
    >>> snakemake = stand_in("fit", {"oil": "4102"})
    >>> snakemake.input.points
    'results/demo/parts/collect/4102/points.parquet'
"""

import runpy
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace

from snakemake.api import ConfigSettings, OutputSettings, ResourceSettings, SnakemakeApi
from snakemake.jobs import Job
from snakemake.script import Snakemake
from snakemake.workflow import Workflow


def stand_in(
    rule: str, wildcards: Mapping[str, str] | None = None, campaign: str = "demo"
) -> Snakemake:
    """The object that a script of the workflow knows as `snakemake`.

    Args:
        rule: Name of the rule.
        wildcards: Its wildcards by name, as `oil`.
        campaign: Name of the campaign.
    """
    return _job_object(rule, wildcards or {}, campaign)[0]


def _job_object(name: str, wildcards: Mapping[str, str], campaign: str) -> tuple[Snakemake, Path]:
    """The object for the script and the path of the script."""
    workflow = _workflow(campaign)
    rule = workflow.get_rule(name)
    # a job needs no more of the DAG than its workflow
    job = Job(rule, SimpleNamespace(workflow=workflow), dict(wildcards))
    script = Path(rule.basedir, rule.script).resolve()
    return Snakemake(
        job.input,
        job.output,
        job.params,
        job.wildcards,
        1,
        job.resources,
        job.log,
        workflow.config,
        name,
        None,
        script.parent,
    ), script


@cache
def _workflow(campaign: str) -> Workflow:
    """The parsed workflow: its rules are read once for all jobs of a process."""
    with SnakemakeApi(OutputSettings(quiet=set())) as api:
        return api.workflow(
            resource_settings=ResourceSettings(cores=1),
            config_settings=ConfigSettings(config={"campaign": campaign}),
            snakefile=Path("Snakefile"),
        )._workflow


def main(arguments: list[str]) -> None:
    """Run the script of `rule wildcard=value ... [campaign=name]`."""
    rule, *assignments = arguments
    wildcards = dict(assignment.split("=", 1) for assignment in assignments)
    snakemake, script = _job_object(rule, wildcards, wildcards.pop("campaign", "demo"))
    for path in (*snakemake.output, *snakemake.log):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    runpy.run_path(str(script), {"snakemake": snakemake}, run_name="__main__")


if __name__ == "__main__":
    main(sys.argv[1:])
