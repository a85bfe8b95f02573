rule printed:
    "The printed constants beside the fit: errors, distances, largest differences in mu."
    input:
        **finished("points", "coefficients", "fit_quality", "refits"),
        printed=reference_file("printed_coefficients"),
    output:
        **finished("printed_judged"),
    log:
        "<logs>/printed.log",
    localrule: True
    params:
        code=code("printed.py"),
        oils=OILS,
        config=part("printed"),
    script:
        "../scripts/printed.py"


rule signs:
    "All sign sets of the printed exponents, compared with the paper's text."
    input:
        **finished("points"),
        printed=reference_file("printed_coefficients"),
    output:
        **finished("signs", "sign_verdicts"),
    log:
        "<logs>/signs.log",
    localrule: True
    params:
        code=code("signs.py"),
        oils=OILS,
        traction_max=SETTINGS.gates.traction_max,
        config=part("printed"),
    script:
        "../scripts/signs.py"
