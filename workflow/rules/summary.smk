rule summary:
    "What was made, how good each fit is and where to look, in one screen of text."
    input:
        **finished(
            "runs",
            "points",
            "quarantine",
            "coverage",
            "extrapolation",
            "coefficients",
            "fit_quality",
            "printed_judged",
            "signs",
            "sign_verdicts",
            "claims",
            "torque_runs",
            "torque_quarantine",
            "torque",
            "torque_inversion",
            "slip_advice",
        ),
    output:
        "<results>/summary.txt",
    log:
        "<logs>/summary.log",
    params:
        code=code("summary.py"),
        config=part(
            "oils", "film", "gates", campaign=("credit", "description", "film_unjudged", "twin")
        ),
    script:
        "../scripts/summary.py"
