"""Simulate the logs of a demonstration campaign."""

from hashlib import sha256
from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.logs.raw_files import listing
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.simulate import simulate_campaign
from oilfilm.run.job import job

with job(snakemake) as (settings, provenance):
    outputs = snakemake.output
    paths = {Path(path).name: Path(path) for path in outputs.logs}
    constants = printed_constants(Path(snakemake.input.printed))
    truth, digests = [], {}
    for run, content, row in simulate_campaign(settings, constants):
        paths[run.name].write_bytes(content)
        digests[run.name] = sha256(content).hexdigest()
        truth.append(row)
    write_text(listing(dict(sorted(digests.items()))), Path(outputs.listing))
    tables.write(tables.from_rows(truth, "truth"), "truth", Path(outputs.truth), provenance)
