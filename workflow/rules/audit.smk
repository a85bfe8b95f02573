rule audit:
    "The paper's claims and its advice on oils, checked with the campaign and the printed constants."
    input:
        **finished("points", "runs", "coefficients", "comparison", "torque", "torque_control"),
        printed=reference_file("printed_coefficients"),
        claims=reference_file("claims"),
    output:
        **finished("claims", "selection"),
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
