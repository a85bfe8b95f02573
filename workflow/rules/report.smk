# The page itself, beside the code that fills it.
PAGE = Path(workflow.basedir, "workflow/oilfilm/report/page")


rule report:
    "What a reader wants to know of the campaign, in one HTML file that needs no network."
    input:
        **(
            {
                "torque_quarantine": rules.torque_runs.output.quarantine,
                "torque": rules.torque.output.torque,
                "torque_inversion": rules.torque.output.inversion,
            }
            if "torque" in CAMPAIGN
            else {}
        ),
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
        png=expand("<figures>/{figure}.png", figure=CAMPAIGN["figures"]),
        svg=expand("<figures>/{figure}.svg", figure=CAMPAIGN["figures"]),
    output:
        page="<results>/report.html",
    log:
        "<logs>/report.log",
    params:
        code=code("report.py"),
        # no digest of Python's modules covers these
        page=[input_digest(PAGE.with_suffix(end)) for end in (".html", ".css", ".js")],
        config=CONFIG,
    script:
        "../scripts/report.py"
