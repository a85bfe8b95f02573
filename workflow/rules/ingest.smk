if SIMULATED:

    rule twin:
        "SIMULATED logs of the whole campaign, and the truth behind them."
        input:
            printed=reference_file("printed_coefficients"),
        output:
            logs=directory("<raw>"),
            truth="<results>/twin/truth.parquet",
            listing="<results>/twin/logs.sha256",
        log:
            "<logs>/twin.log",
        localrule: True
        params:
            code=code("twin.py"),
            config=part("seed", *TRUTH, campaign=("oils", "matrix", "twin")),
        script:
            "../scripts/twin.py"


rule ingest:
    "Samples of one share of the raw logs; what cannot be read goes to quarantine."
    input:
        **({"listing": rules.twin.output.listing, "logs": "<raw>"} if SIMULATED else {}),
        measured=lambda wildcards: measured_logs_of(wildcards.shard),
    output:
        samples=SAMPLES,
        runs="<parts>/ingest/{shard}/runs.parquet",
        quarantine="<parts>/ingest/{shard}/quarantine.parquet",
        files="<parts>/ingest/{shard}/samples.json",
    log:
        "<logs>/ingest/{shard}.log",
    params:
        code=code("ingest.py"),
        files=lambda wildcards: logs_as_found(wildcards.shard)["states"],
        sheet=lambda wildcards: logs_as_found(wildcards.shard)["sheet"],
        config=part(
            "rigs",
            "oils",
            "logged_twice",
            "same_set_point",
            campaign=(
                "columns",
                "header",
                "oil_aliases",
                "semantics",
                "semantics_of_rig",
                "set_points",
            ),
        ),
    script:
        "../scripts/ingest.py"
