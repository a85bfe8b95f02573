FIT_TABLES = (
    "coefficients",
    "fit_quality",
    "refits",
    "correlations",
    "profiles",
    "curve_residuals",
)


rule fit:
    "One oil's constants, with their errors and the certificate."
    input:
        points="<parts>/collect/{oil}/points.parquet",
        printed=reference_file("printed_coefficients"),
    output:
        **{table: f"<parts>/fit/{{oil}}/{table}.parquet" for table in FIT_TABLES},
    log:
        "<logs>/fit-{oil}.log",
    params:
        code=code("fit.py"),
        config=part("fit", "seed"),
    script:
        "../scripts/fit.py"


rule fits:
    "The fits of all oils, a table each."
    input:
        **{table: expand(f"<parts>/fit/{{oil}}/{table}.parquet", oil=OILS) for table in FIT_TABLES},
        points="<tables>/points.parquet",
    output:
        **finished(*FIT_TABLES),
    log:
        "<logs>/fits.log",
    localrule: True
    params:
        code=code("fits.py"),
        config=part(),
    script:
        "../scripts/fits.py"


rule certified:
    "The certificates of all fits; a fit without one ends the run, unless config allows it."
    input:
        **finished("fit_quality"),
    output:
        "<tables>/certificates.txt",
    log:
        "<logs>/certified.log",
    localrule: True
    params:
        code=code("certified.py"),
        config=part("fit"),
    script:
        "../scripts/certified.py"
