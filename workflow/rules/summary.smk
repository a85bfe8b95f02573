rule summary:
    "What was made, how good each fit is and where to look, in one screen of text."
    input:
        runs=rules.collect.output.runs,
        points=rules.collect.output.points,
        quarantine=rules.collect.output.quarantine,
        coverage=rules.coverage.output.coverage,
        extrapolation=EXTRAPOLATION[:1],
        coefficients=rules.fits.output.coefficients,
        quality=rules.fits.output.fit_quality,
        judged=rules.printed.output.judged,
        signs=rules.signs.output.signs,
        sign_verdicts=rules.signs.output.verdicts,
    output:
        "<results>/summary.txt",
    log:
        "<logs>/summary.log",
    params:
        code=code("summary.py"),
        config=part("oils", "film", "gates", campaign=("description", "film_unjudged")),
    script:
        "../scripts/summary.py"
