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
        claims=rules.audit.output.claims,
        # none of these in campaigns without torque logs
        torque_runs=TORQUE and [rules.torque_runs.output.runs],
        torque_quarantine=TORQUE and [rules.torque_runs.output.quarantine],
        torque=TORQUE and [rules.torque.output.torque],
        torque_inversion=TORQUE and [rules.torque.output.inversion],
        slip_advice=TORQUE and [rules.bearing_maps.output.slip_advice],
    output:
        "<results>/summary.txt",
    log:
        "<logs>/summary.log",
    params:
        code=code("summary.py"),
        config=part("oils", "film", "gates", campaign=("description", "film_unjudged", "twin")),
    script:
        "../scripts/summary.py"
