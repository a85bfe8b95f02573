rule coverage:
    "What the campaign covers, condition by condition, and what each gate refused."
    input:
        points=rules.collect.output.points,
        runs=rules.collect.output.runs,
        quarantine=rules.collect.output.quarantine,
    output:
        coverage="<tables>/coverage.parquet",
        gates="<tables>/gate_counts.parquet",
    log:
        "<logs>/coverage.log",
    params:
        code=code("coverage.py"),
        config=part("rigs", "oils", "same_set_point", campaign=("rigs", "matrix")),
    script:
        "../scripts/coverage.py"


rule refused:
    "A page a refused run: its signals and the place of the trouble."
    input:
        samples=expand(rules.ingest.output.samples, shard=SHARDS),
        points=rules.collect.output.points,
        runs=rules.collect.output.runs,
        quarantine=rules.collect.output.quarantine,
    output:
        pages=directory("<results>/refused"),
    log:
        "<logs>/refused.log",
    params:
        code=code("refused.py"),
        config={
            **part(campaign=("film_unjudged", "semantics", "semantics_of_rig")),
            "refused_pages_max": CONFIG["figures"]["refused_pages_max"],
        },
    script:
        "../scripts/refused.py"
