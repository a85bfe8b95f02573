# Decides: what reruns when one log or its row of the run sheet changes.


rule points:
    "Samples of one share of the raw logs, and its steady plateaus with every gate's verdict."
    input:
        listing=rules.twin.output.listing if SIMULATED else [],
        logs=lambda wildcards: raw_logs(
            RAW_FOLDER, LOG_NAMES_OF_SHARE.get(int(wildcards.share), [])
        ),
    output:
        samples=SAMPLE_FILES,
        points="<parts>/points/{share}/points.parquet",
        runs="<parts>/points/{share}/runs.parquet",
        quarantine="<parts>/points/{share}/quarantine.parquet",
        logs="<parts>/points/{share}/logs.sha256",
        made=step_listing("points-{share}", share=SHARES),
    log:
        "<logs>/points/{share}.log",
    params:
        code=lambda wildcards: script_digest("points.py", tables=rules.points.output.keys()),
        files=lambda wildcards: digests_of_logs(
            RAW_FOLDER, LOG_NAMES_OF_SHARE.get(int(wildcards.share), [])
        ),
        sheet=lambda wildcards: sheet_rows(
            RAW_FOLDER,
            LOG_NAMES_OF_SHARE.get(int(wildcards.share), []),
            remarks=int(wildcards.share) == SHARES[0],
        ),
        config=settings_part(
            *("rigs", "oils", "logged_twice", "same_set_point", "same_condition"),
            *("film", "curation", "gates"),
            campaign=(
                *("columns", "header", "oil_aliases", "film_unjudged"),
                *("semantics", "semantics_of_rig", "set_points"),
            ),
        ),
    script:
        "../scripts/points.py"


# A checkpoint, because only its result shows which oils have other points than before. Snakemake
# then compares `points_by_oil` with what each fit has read. The fits of all other oils stay as they
# are.
# It runs where the folder is: it compares the logs with data/first_seen, and adds those that are new.
checkpoint collect:
    "All runs and points of the campaign, judged by the gates that compare runs; what it covers."
    input:
        **{
            table: expand(f"<parts>/points/{{share}}/{table}.parquet", share=SHARES)
            for table in ("points", "runs", "quarantine")
        },
        digests=expand("<parts>/points/{share}/logs.sha256", share=SHARES),
    output:
        **written("points", "runs", "quarantine", "coverage", "gate_counts"),
        spreadsheet="<tables>/quarantine.csv",
        points_by_oil=expand("<parts>/collect/{oil}/points.parquet", oil=OILS),
        runs_by_oil=expand("<parts>/collect/{oil}/runs.parquet", oil=OILS),
        made=step_listing("collect"),
    log:
        "<logs>/collect.log",
    localrule: True
    params:
        code=lambda wildcards: script_digest("collect.py", tables=rules.collect.output.keys()),
        oils=OILS,
        measured=not SIMULATED,
        acknowledged=ACKNOWLEDGED_CHANGES,
        first_seen=FIRST_SEEN_FOLDER,
        # here and not in `points`, where each share depends on its own rows alone
        run_sheet={
            path: digest[:16]
            for path, digest in digests_of_sheets().items()
            if Path(path).parent == RAW_FOLDER
        },
        config=settings_part(
            *("film", "gates", "oils", "rigs", "same_set_point"),
            campaign=("matrix", "repeated_conditions", "rigs"),
        ),
    script:
        "../scripts/collect.py"


rule run_plan:
    "Runs that the campaign lacks, in the order in which to make them."
    input:
        **finished("points", "runs"),
    output:
        **written("run_plan"),
        made=step_listing("run-plan"),
    log:
        "<logs>/run-plan.log",
    localrule: True
    params:
        code=lambda wildcards: script_digest("run_plan.py", tables=rules.run_plan.output.keys()),
        config=settings_part(
            *("film", "gates", "oils", "plan", "rigs"),
            *("same_condition", "same_set_point", "seed"),
            campaign=("matrix",),
        ),
    script:
        "../scripts/run_plan.py"
