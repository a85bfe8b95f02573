rule fit:
    "One oil's constants, with their errors and the certificate."
    input:
        points=rules.collect.output.points,
        printed="data/reference/printed_coefficients.yaml",
    output:
        coefficients="<parts>/fit/{oil}/coefficients.parquet",
        quality="<parts>/fit/{oil}/fit_quality.parquet",
    log:
        "<logs>/fit-{oil}.log",
    params:
        code=code("fit.py"),
        config=part("fit", "seed"),
    script:
        "../scripts/fit.py"


rule fits:
    "The fits of all oils in two tables."
    input:
        coefficients=expand(rules.fit.output.coefficients, oil=OILS),
        quality=expand(rules.fit.output.quality, oil=OILS),
    output:
        coefficients="<tables>/coefficients.parquet",
        quality="<tables>/fit_quality.parquet",
    log:
        "<logs>/fits.log",
    params:
        code=code("fits.py"),
        config=part(),
    script:
        "../scripts/fits.py"
