"""Raw traction-rig logs to validated tables, fitted constants and figures: see workflow/Snakefile."""


include: "workflow/Snakefile"
