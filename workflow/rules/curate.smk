# Decides: what reruns when one log or its row of the run sheet changes.


rule curate:
    "Steady plateaus of one share of the runs, with every gate's verdict."
    input:
        samples=rules.ingest.output.samples,
        runs=rules.ingest.output.runs,
    output:
        points="<parts>/curate/{shard}/points.parquet",
        runs="<parts>/curate/{shard}/runs.parquet",
        quarantine="<parts>/curate/{shard}/quarantine.parquet",
    log:
        "<logs>/curate/{shard}.log",
    params:
        code=code("curate.py"),
        config=part(
            "rigs",
            "oils",
            "film",
            "curation",
            "gates",
            campaign=("film_unjudged", "semantics", "semantics_of_rig", "set_points"),
        ),
    script:
        "../scripts/curate.py"


# A checkpoint: which oils' points are other than before is known only when it is done. Snakemake then
# compares `of_oil` with what each fit has read, and the fits of all other oils stay as they are.
checkpoint collect:
    "All runs and points of the campaign, judged by the gates that compare runs."
    input:
        points=expand("<parts>/curate/{shard}/points.parquet", shard=SHARDS),
        runs=expand("<parts>/curate/{shard}/runs.parquet", shard=SHARDS),
        quarantine=expand(
            "<parts>/{stage}/{shard}/quarantine.parquet", stage=["ingest", "curate"], shard=SHARDS
        ),
    output:
        **finished("points", "runs", "quarantine"),
        spreadsheet="<tables>/quarantine.csv",
        of_oil=expand("<parts>/collect/{oil}/points.parquet", oil=OILS),
    log:
        "<logs>/collect.log",
    params:
        code=code("collect.py"),
        oils=OILS,
        shares=SHARDS,
        # here and not in `ingest`, where each share depends on its own rows alone
        run_sheet=run_sheet_of(RAW),
        config=part(
            *("film", "gates", "oils", "rigs", "same_set_point"),
            campaign=("matrix", "repeated_conditions"),
        ),
    script:
        "../scripts/collect.py"
