FIT_TABLES = (
    "coefficients",
    "fit_quality",
    "refits",
    "correlations",
    "profiles",
    "curve_residuals",
)


# A fit of many curves in jobs of their own, if `split` sets them: first the ends of its searches,
# then blocks of its refits and of the curves that are left out.
rule drawn:
    "A part of one law's fit to one oil."
    input:
        points="<parts>/collect/{oil}/points.parquet",
        ends=lambda wildcards: (
            []
            if wildcards.what == "ends"
            else part_file(wildcards.of, wildcards.oil, wildcards.law, "ends", 0)
        ),
    output:
        part=part_file("{of}", "{oil}", "{law}", "{what}", "{block}"),
    log:
        "<logs>/{of}-{oil}/{law}-{what}-{block}.log",
    wildcard_constraints:
        of="fit|compare",
        law="|".join(LAW_NAMES),
        what="ends|refits|left-out",
    params:
        code=lambda wildcards: code("drawn.py", LAW_FILES[wildcards.law]),
        size=lambda wildcards: SIZES[wildcards.what],
        config=lambda wildcards: (
            part("fit", "seed")
            if wildcards.of == "fit"
            else COMPARED.part("compare", "fit", "oils", "rigs", "seed")
        ),
    script:
        "../scripts/drawn.py"


rule fit:
    "One oil's constants, with their errors and the certificate."
    input:
        drawn=lambda wildcards: parts_of_fit(
            "fit", wildcards.oil, SETTINGS.fit.law, SETTINGS.fit.bootstrap
        ),
        points="<parts>/collect/{oil}/points.parquet",
        printed=reference_file("printed_coefficients"),
    output:
        **{table: f"<parts>/fit/{{oil}}/{table}.parquet" for table in FIT_TABLES},
    log:
        "<logs>/fit-{oil}.log",
    params:
        code=code("fit.py", LAW_FILES[SETTINGS.fit.law]),
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
