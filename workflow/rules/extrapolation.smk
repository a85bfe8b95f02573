if SIMULATED:

    rule extrapolation:
        "Fitted laws beside the truth at the conditions of Figs 7-10; it decides on no real oil."
        input:
            **finished("law_coefficients", "law_refits", "law_fit_quality"),
            truth_grid=rules.truth.output.truth_grid,
        output:
            **finished(*EXTRAPOLATION_TABLES),
        log:
            "<logs>/extrapolation.log",
        localrule: True
        params:
            code=code("extrapolation.py"),
            config=part("oils", "rigs", "same_set_point"),
        script:
            "../scripts/extrapolation.py"
