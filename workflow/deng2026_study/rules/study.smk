# What a campaign with `studies: [deng2026_study]` has beside its figures.

STUDY_SCRIPTS = studies.folder("deng2026_study") / "scripts"


rule paper:
    "The paper's constants, signs and claims beside the fit; fits beside a simulated truth."
    input:
        **finished(
            "points",
            "runs",
            *FIT_TABLE_NAMES,
            "surface_sizes",
            "torque",
            "torque_control",
            "cage_slip",
        ),
        printed=reference_file("printed_coefficients"),
        claims=reference_file("claims"),
    output:
        **written("printed_judged", "signs", "sign_verdicts", "claims", "claim_numbers"),
        **written("extrapolation", "extrapolation_errors"),
        truth_grid="<results>/twin/truth_grid.parquet" if SIMULATED else [],
        made=step_listing("paper"),
    log:
        "<logs>/paper.log",
    localrule: True
    params:
        code=lambda wildcards: script_digest(
            STUDY_SCRIPTS / "paper.py", tables=rules.paper.output.keys()
        ),
        config=settings_part(
            *("film", "gates", "oils", "rigs", "same_set_point", "studies"),
            campaign=("matrix", "oils", "twin"),
        ),
    script:
        "../scripts/paper.py"


if CAMPAIGN.torque is not None:

    rule slip_advice:
        "The paper's advice on oils beside the best oil by cage slip, and published bearing tests."
        input:
            **finished("cage_slip", *FIT_TABLE_NAMES),
            published=reference_file("bearing_tests"),
            printed=reference_file("printed_coefficients"),
        output:
            **written("slip_advice", "true_cage_slip", "advice_band", "published_tests"),
            made=step_listing("slip-advice"),
        log:
            "<logs>/slip-advice.log",
        priority: 1
        params:
            code=lambda wildcards: script_digest(
                STUDY_SCRIPTS / "slip_advice.py", tables=rules.slip_advice.output.keys()
            ),
            config=settings_part(
                *("rigs", "oils", "bearings", "bearing", "gates", "studies"),
                campaign=("oils", "torque", "twin"),
            ),
        script:
            "../scripts/slip_advice.py"
