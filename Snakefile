"""Raw traction-rig logs to validated tables, fitted constants and figures.

`snakemake` runs the campaign of config/config.yaml; `snakemake --config campaign=NAME` another.
"""


include: "workflow/rules/common.smk"
include: "workflow/rules/ingest.smk"
include: "workflow/rules/curate.smk"
include: "workflow/rules/fit.smk"
include: "workflow/rules/compare.smk"
include: "workflow/rules/extrapolation.smk"
include: "workflow/rules/exports.smk"
include: "workflow/rules/printed.smk"
include: "workflow/rules/bearing.smk"
include: "workflow/rules/quality.smk"
include: "workflow/rules/audit.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/metadata.smk"
include: "workflow/rules/summary.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/enough.smk"


report: caption_file("campaign")


rule all:
    "Everything of one campaign: tables, their description, fits, figures and the summary."
    default_target: True
    input:
        rules.enough.input.everything,
        rules.enough.output,


# Its inputs are those of `all`.
include: "workflow/rules/release.smk"


onstart:
    begin()


onsuccess:
    print_summary()


onerror:
    print(f"The run failed. The reason is printed above and in results/{CAMPAIGN.name}/logs.")
