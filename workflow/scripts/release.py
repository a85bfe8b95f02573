"""Put what a campaign's run has made, except its samples, into a release that never changes."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base import studies
from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import HOME
from oilfilm.logs.raw_files import read_listings
from oilfilm.releases.code_tree import code_tree_digest
from oilfilm.releases.release import FinishedRun, make_release

with run.job(snakemake) as job:
    inputs, params = snakemake.input, snakemake.params
    studies.declare_tables(job.settings.campaign.studies)
    releases, package_file = Path(params.releases), Path(inputs.package)
    if code_tree_digest(HOME) != params.tree:
        raise OilfilmError("The code has changed while it ran. Run `snakemake release` again.")
    not_released = {*inputs.digests, *inputs.simulated, *inputs.made}
    finished_run = FinishedRun(
        root=Path(),
        home=HOME,
        settings=job.settings,
        results=package_file.parents[1],
        output_paths=[Path(path) for path in inputs if path not in not_released],
        raw_digest_by_path=read_listings(*map(Path, inputs.digests)) | params.sheet_digests,
        step_listings=[Path(path) for path in inputs.made],
        copies_folder=package_file.parents[3],  # local copies of object storage; else this folder
    )
    folder, is_new = make_release(finished_run, releases)
    # a job that was killed after it had made its release runs again, and writes the same log
    Path(snakemake.log[0]).write_text(f"{folder}: the release of this run\n", encoding="utf-8")
    run.print_line(f"{folder}: {'released' if is_new else 'exists already, with the same bytes'}")
