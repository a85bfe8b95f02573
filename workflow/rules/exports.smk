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
        config=part("fit", "exports", "printed", campaign=("credit", "description")),
    script:
        "../scripts/exports.py"
