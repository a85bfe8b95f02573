"""Draw a page a refused run, and list which page shows which run."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import atomic_folder
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.refused_runs import draw_page, listing
from oilfilm.run.job import job

with job(snakemake) as provenance:
    found, config = snakemake.input, snakemake.params.config
    points = tables.read("points", Path(found.points))
    runs = tables.read("runs", Path(found.runs))
    quarantine = tables.read("quarantine", Path(found.quarantine))
    pages = listing(runs, points, quarantine, config["refused_pages_max"])
    by_name = runs.set_index("run_id", drop=False)
    with atomic_folder(Path(snakemake.output.pages)) as folder:
        for entry in pages[pages["page"] != ""].to_dict("records"):
            run_id = entry["run_id"]
            run = by_name.loc[run_id].to_dict()
            samples = tables.read_run("samples", [Path(path) for path in found.samples], run_id)
            of_run = points[points["run_id"] == run_id]
            page = draw_page(entry, run, samples, of_run, config["campaign"])
            style.save(page, folder / entry["page"])
        tables.write(pages, "refused_pages", folder / "index.parquet", provenance)
