rule exports:
    "Fits: Python, workbook, C, Fortran, Modelica, MATLAB, ADORE, JSON, CSV."
    input:
        **finished("points", "coefficients", "fit_quality", "soundness"),
        studies=references_of_studies("exported"),
    output:
        folder=directory("<results>/exports"),
        made=step_listing("exports"),
    log:
        "<logs>/exports.log",
    # no other rule needs it: it runs beside the report
    priority: -1
    localrule: True
    params:
        code=script_digest("exports.py", *STUDY_MODULES),
        # no digest of Python's modules covers these
        templates=sorted(map(file_digest, (PACKAGE / "exports/templates").glob("*.jinja"))),
        config=settings_part(
            "fit", "exports", "studies", campaign=("credit", "description", "studies")
        ),
    script:
        "../scripts/exports.py"
