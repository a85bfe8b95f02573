rule coverage:
    "What the campaign covers, condition by condition, and what each gate refused."
    input:
        **finished("points", "runs", "quarantine"),
    output:
        **finished("coverage", "gate_counts"),
    log:
        "<logs>/coverage.log",
    localrule: True
    params:
        code=code("coverage.py"),
        config=part("rigs", "oils", "same_set_point", campaign=("rigs", "matrix")),
    script:
        "../scripts/coverage.py"


rule refused:
    "One page per refused run, of either rig: its signals and the rows concerned."
    input:
        **(
            {"listing": rules.torque_twin.output.listing, "logs": "<torque_raw>"}
            if TORQUE_SIMULATED
            else {}
        ),
        **finished("points", "runs", "quarantine", "torque_quarantine"),
        measured=lambda wildcards: measured_logs_of("torque"),
        samples=expand(SAMPLES, shard=SHARDS),
    output:
        pages=directory("<results>/refused"),
    log:
        "<logs>/refused.log",
    params:
        code=code("refused.py"),
        files=lambda wildcards: logs_as_found("torque")["states"],
        sheet=lambda wildcards: logs_as_found("torque")["sheet"],
        pages_max=SETTINGS.figures.refused_pages_max,
        config=part(
            "oils",
            "curation",
            "torque_logs",
            campaign=(
                *ORIGIN,
                "header",
                "oil_aliases",
                "semantics",
                "semantics_of_rig",
                "torque",
            ),
        ),
    script:
        "../scripts/refused.py"
