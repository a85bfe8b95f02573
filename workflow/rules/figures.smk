rule figure:
    "One figure, as PNG and SVG, and exactly what it draws."
    input:
        points=rules.collect.output.points,
        runs=rules.collect.output.runs,
        coefficients=rules.fits.output.coefficients,
        coverage=rules.coverage.output.coverage,
        extrapolation=EXTRAPOLATION[:1],
        signs=rules.signs.output.signs,
        sign_verdicts=rules.signs.output.verdicts,
        claims=rules.audit.output.claims,
        selection=rules.audit.output.selection,
    output:
        png="<figures>/{figure}.png",
        svg="<figures>/{figure}.svg",
        drawn="<figures>/{figure}.parquet",
    log:
        "<logs>/figure-{figure}.log",
    params:
        code=code("figure.py"),
        config=part("oils", "figures", "printed", campaign=("matrix", "film_unjudged")),
    script:
        "../scripts/figure.py"


rule figures:
    "All figures of the campaign."
    input:
        expand(rules.figure.output.png, figure=CAMPAIGN["figures"]),
