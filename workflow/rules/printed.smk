rule printed:
    "The printed constants beside the fit: errors, distances, largest differences in mu."
    input:
        points=rules.collect.output.points,
        coefficients=rules.fits.output.coefficients,
        quality=rules.fits.output.fit_quality,
        refits=rules.fits.output.refits,
        printed="data/reference/printed_coefficients.yaml",
    output:
        judged="<tables>/printed_judged.parquet",
    log:
        "<logs>/printed.log",
    params:
        code=code("printed.py"),
        oils=OILS,
        config=part("printed"),
    script:
        "../scripts/printed.py"


rule signs:
    "All sign sets of the printed exponents, held against the paper's text."
    input:
        points=rules.collect.output.points,
        printed="data/reference/printed_coefficients.yaml",
    output:
        signs="<tables>/signs.parquet",
        verdicts="<tables>/sign_verdicts.parquet",
    log:
        "<logs>/signs.log",
    params:
        code=code("signs.py"),
        oils=OILS,
        traction_max=SETTINGS.gates.traction_max,
        config=part("printed"),
    script:
        "../scripts/signs.py"
