rule exports:
    "Fits and printed constants: Python, workbook, C, Fortran, Modelica, MATLAB, ADORE, JSON, CSV."
    input:
        **finished("points", "coefficients", "fit_quality"),
        printed=reference_file("printed_coefficients"),
    output:
        folder=directory("<results>/exports"),
    log:
        "<logs>/exports.log",
    localrule: True
    params:
        code=code("exports.py"),
        # no digest of Python's modules covers these
        templates=sorted(map(file_digest, (PACKAGE / "exports/templates").glob("*.jinja"))),
        config=part("fit", "exports", "printed", campaign=("credit", "description")),
    script:
        "../scripts/exports.py"
