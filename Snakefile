"""Raw traction-rig logs to validated tables, fitted constants and figures: see workflow/Snakefile."""


include: "workflow/Snakefile"


# Snakemake takes no default target from an included file.
workflow.default_target = "all"
