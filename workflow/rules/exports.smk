rule exports:
    "Every oil's fit as C, Fortran, Modelica, MATLAB, ADORE constants, JSON and CSV."
    input:
        **finished("points", "coefficients", "fit_quality"),
    output:
        folder=directory("<results>/exports"),
    log:
        "<logs>/exports.log",
    params:
        code=code("exports.py"),
        config=part("fit", "exports", campaign=("credit", "description")),
    script:
        "../scripts/exports.py"
