rule summary:
    "What was made, how good each fit is and where to look, in one screen of text."
    input:
        **finished(
            "runs points quarantine coverage extrapolation coefficients correlations",
            "fit_quality curve_residuals law_verdicts lack_of_fit printed_judged signs sign_verdicts claims",
            "torque_runs torque_quarantine torque torque_control torque_inversion slip_advice",
            "advice_band heat_balance",
        ),
    output:
        "<results>/summary.txt",
    log:
        "<logs>/summary.log",
    localrule: True
    params:
        code=code("summary.py", *STUDIES),
        config=part(
            "oils",
            "film",
            "gates",
            campaign=(
                "description",
                "film_unjudged",
                "min_accepted_runs",
                "min_accepted_share",
                "studies",
                "torque",
                *ORIGIN,
            ),
        ),
    script:
        "../scripts/summary.py"
