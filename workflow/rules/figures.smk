# One job draws a family: to import what draws takes longer than to draw a figure. Inputs are named
# after their tables.
rule configured_figures:
    "The rigs and what is configured, as PNG and SVG, and exactly what each draws."
    input:
        paper_tables="data/reference/paper_tables.yaml",
    output:
        **drawn("fig01", "tab01", "tab03", "fig05"),
    log:
        "<logs>/configured-figures.log",
    params:
        code=code("figures.py"),
        config=part("oils", "rigs", "bearings", campaign=("film_unjudged", "torque")),
    script:
        "../scripts/figures.py"


rule data_figures:
    "The curves, what they cover and how far the fit is off, drawn in the same way."
    input:
        points=rules.collect.output.points,
        runs=rules.collect.output.runs,
        coefficients=rules.fits.output.coefficients,
        coverage=rules.coverage.output.coverage,
        paper_tables="data/reference/paper_tables.yaml",
    output:
        **drawn("tab02", "fig02", "fig03", "coverage", "curves", "residuals"),
    log:
        "<logs>/data-figures.log",
    params:
        code=code("figures.py"),
        config=part(
            "oils", "rigs", "figures", "same_set_point", campaign=("matrix", "film_unjudged")
        ),
    script:
        "../scripts/figures.py"


rule law_figures:
    "Fitted laws: constants, how sure they are, and mu far and wide."
    input:
        points=rules.collect.output.points,
        coefficients=rules.fits.output.coefficients,
        fit_quality=rules.fits.output.fit_quality,
        refits=rules.fits.output.refits,
        correlations=rules.fits.output.correlations,
        profiles=rules.fits.output.profiles,
        comparison=rules.comparisons.output.comparison,
        law_coefficients=rules.comparisons.output.law_coefficients,
        extrapolation=EXTRAPOLATION[:1],
    output:
        **drawn(
            "eqs11-13",
            "fig04",
            "fig07",
            "fig08",
            "fig09",
            "fig10",
            "identifiability",
            "extrapolation",
        ),
    log:
        "<logs>/law-figures.log",
    params:
        code=code("figures.py"),
        config=part(
            "oils",
            "rigs",
            "figures",
            "extrapolation",
            "same_set_point",
            campaign=("film_unjudged",),
        ),
    script:
        "../scripts/figures.py"


rule claims_figures:
    "What the paper says in words, held against the numbers."
    input:
        signs=rules.signs.output.signs,
        sign_verdicts=rules.signs.output.verdicts,
        claims=rules.audit.output.claims,
        selection=rules.audit.output.selection,
    output:
        **drawn("claims", "signs", "selection"),
    log:
        "<logs>/claims-figures.log",
    params:
        code=code("figures.py"),
        config=part("oils", "printed", campaign=("film_unjudged",)),
    script:
        "../scripts/figures.py"


rule bearing_figures:
    "The bearing: torque on each basis, cage slip, size effect, a published power loss."
    input:
        torque=rules.torque.output.torque,
        cage_slip=rules.bearing_maps.output.cage_slip,
        slip_advice=rules.bearing_maps.output.slip_advice,
        size_effect=rules.bearing_maps.output.size_effect,
        power_loss=rules.bearing_maps.output.power_loss,
    output:
        **drawn("fig06", "cage-slip", "size-effect", "power-loss"),
    log:
        "<logs>/bearing-figures.log",
    params:
        code=code("figures.py"),
        config=part("oils", "bearing", "figures", "selection"),
    script:
        "../scripts/figures.py"


rule figures:
    "Every figure and table of the paper that the campaign asks for, and those beyond it."
    input:
        expand(
            "<figures>/{figure}.{kind}", figure=CAMPAIGN["figures"], kind=("png", "svg", "parquet")
        ),
