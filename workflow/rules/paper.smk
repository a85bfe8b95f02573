# What a campaign with `studies: [paper]` has beside its figures.


rule printed:
    "The printed constants beside the fit, and all sets of their lost signs beside the paper's text."
    input:
        **finished("points", "coefficients", "fit_quality", "refits"),
        printed=reference_file("printed_coefficients"),
    output:
        **finished("printed_judged", "signs", "sign_verdicts"),
    log:
        "<logs>/printed.log",
    localrule: True
    params:
        code=code("printed.py"),
        oils=OILS,
        traction_max=SETTINGS.gates.traction_max,
        config=part("printed"),
    script:
        "../scripts/printed.py"


if SIMULATED:

    rule extrapolation:
        "Fitted laws beside the simulated truth at the conditions of Figs 7-10."
        input:
            **finished(*FITTED),
            printed=reference_file("printed_coefficients"),
        output:
            **finished("extrapolation", "extrapolation_errors"),
            truth_grid="<results>/twin/truth_grid.parquet",
        log:
            "<logs>/extrapolation.log",
        localrule: True
        params:
            code=code("extrapolation.py"),
            config=part(
                "extrapolation", "oils", "rigs", "same_set_point", campaign=("oils", "twin")
            ),
        script:
            "../scripts/extrapolation.py"


if CAMPAIGN.torque is not None:

    rule slip_advice:
        "The paper's advice on oils beside the best oil by cage slip, and published bearing tests."
        input:
            **finished("cage_slip", *FITTED),
            published=reference_file("bearing_tests"),
        output:
            **finished("slip_advice", "advice_band", "published_tests"),
        log:
            "<logs>/slip-advice.log",
        params:
            code=code("slip_advice.py"),
            config=part(
                *("rigs", "oils", "bearings", "bearing", "gates", "selection"),
                campaign=("torque",),
            ),
        script:
            "../scripts/slip_advice.py"


rule audit:
    "The paper's claims and its advice on oils, checked with the campaign and the printed constants."
    input:
        **finished("points", "runs", "coefficients", "fit_quality", "torque", "torque_control"),
        printed=reference_file("printed_coefficients"),
        claims=reference_file("claims"),
    output:
        **finished("claims", "claim_numbers", "selection"),
    log:
        "<logs>/audit.log",
    localrule: True
    params:
        code=code("audit.py"),
        config=part(
            "audit",
            "film",
            "gates",
            "oils",
            "printed",
            "rigs",
            "same_set_point",
            "selection",
            campaign=("matrix", "twin"),
        ),
    script:
        "../scripts/audit.py"
