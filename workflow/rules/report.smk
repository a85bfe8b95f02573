# The page itself, beside the code that fills it.
PAGE = Path(workflow.basedir, "workflow/oilfilm/report/page")


rule report:
    "What a reader wants to know of the campaign, in one HTML file that needs no network."
    input:
        runs=rules.collect.output.runs,
        points=rules.collect.output.points,
        quarantine=rules.collect.output.quarantine,
        coverage=rules.coverage.output.coverage,
        gate_counts=rules.coverage.output.gates,
        refused=rules.refused.output.pages,
        coefficients=rules.fits.output.coefficients,
        fit_quality=rules.fits.output.fit_quality,
        refits=rules.fits.output.refits,
        comparison=rules.comparisons.output.comparison,
        claims=rules.audit.output.claims,
        # none of these in campaigns without torque logs
        torque_runs=TORQUE and [rules.torque_runs.output.runs],
        torque_quarantine=TORQUE and [rules.torque_runs.output.quarantine],
        torque=TORQUE and [rules.torque.output.torque],
        torque_inversion=TORQUE and [rules.torque.output.inversion],
        slip_advice=TORQUE and [rules.bearing_maps.output.slip_advice],
        png=expand("<figures>/{figure}.png", figure=CAMPAIGN["figures"]),
        svg=expand("<figures>/{figure}.svg", figure=CAMPAIGN["figures"]),
    output:
        page="<results>/report.html",
    log:
        "<logs>/report.log",
    params:
        code=code("report.py"),
        # no digest of Python's modules covers these
        page=[file_digest(PAGE.with_suffix(end)) for end in (".html.jinja", ".css", ".js")],
        config=CONFIG,
    script:
        "../scripts/report.py"
