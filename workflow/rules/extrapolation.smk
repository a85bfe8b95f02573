if SIMULATED:

    rule extrapolation:
        "Fitted laws beside the truth at the conditions of Figs 7-10; it decides on no real oil."
        input:
            truth=rules.truth.output.grid,
            coefficients=rules.comparisons.output.law_coefficients,
            refits=rules.comparisons.output.law_refits,
            quality=rules.comparisons.output.law_fit_quality,
        output:
            compared="<tables>/extrapolation.parquet",
            errors="<tables>/extrapolation_errors.parquet",
        log:
            "<logs>/extrapolation.log",
        params:
            code=code("extrapolation.py"),
            config=part("oils", "rigs", "same_set_point"),
        script:
            "../scripts/extrapolation.py"


# Empty for measured campaigns, of which no truth is known.
EXTRAPOLATION = rules.extrapolation.output if SIMULATED else []
