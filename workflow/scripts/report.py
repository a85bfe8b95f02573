"""Write the report of a campaign as a page and as text, and a data package of its tables."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base import studies
from oilfilm.base.atomic_write import write_text
from oilfilm.report.html import html_report
from oilfilm.report.metadata import data_package
from oilfilm.report.sections.build import campaign_sections
from oilfilm.report.text import text_report

with run.job(snakemake) as job:
    studies.declare_tables(job.settings.campaign.studies)
    inputs, outputs = snakemake.input, snakemake.output
    document = campaign_sections(job.input_tables, job.settings)
    write_text(text_report(document, job.settings.campaign), Path(outputs.summary))
    png_files = [Path(png) for png in inputs.png]
    refused_pages = Path(inputs.refused_pages)
    html_page = html_report(
        document, job.input_tables, png_files, refused_pages, job.settings, job.provenance
    )
    write_text(html_page, Path(outputs.page))
    package_file = Path(outputs.package)
    table_files = [Path(inputs[name]) for name in snakemake.params.tables]
    sample_files = [Path(file) for file in inputs.samples]
    content = data_package(job.settings, package_file.parent, table_files + sample_files)
    write_text(content, package_file)
