# One job draws them all: to import what draws takes longer than to draw.
rule figures:
    "The figures of the campaign, as PNG and SVG, and exactly what each draws."
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
        comparison=rules.comparisons.output.comparison,
        law_coefficients=rules.comparisons.output.law_coefficients,
    output:
        png=expand("<figures>/{figure}.png", figure=TRACTION_FIGURES),
        svg=expand("<figures>/{figure}.svg", figure=TRACTION_FIGURES),
        drawn=expand("<figures>/{figure}.parquet", figure=TRACTION_FIGURES),
    log:
        "<logs>/figures.log",
    params:
        code=code("figures.py"),
        figures=TRACTION_FIGURES,
        config=part("oils", "rigs", "figures", "printed", campaign=("matrix", "film_unjudged")),
    script:
        "../scripts/figures.py"
