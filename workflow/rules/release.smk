# No output: the name of a release depends on its content, and Snakemake deletes what it remakes.
rule release:
    "Everything the run has made, and what it was made from, in a folder that never changes."
    input:
        rules.enough.input.everything,
        rules.enough.output,
        tables=[path for path in TABLE_FILES.values() if path],
        samples=rules.report.input.samples,
        package=rules.report.output.package,
        digests=[
            *expand("<parts>/points/{share}/logs.sha256", share=SHARES),
            *([rules.torque_runs.output.logs] if CAMPAIGN.torque is not None else []),
        ],
        made=STEP_LISTINGS,
        simulated=[
            *(raw_logs(RAW_FOLDER, LOG_NAMES) if SIMULATED else []),
            *(raw_logs(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES) if TORQUE_SIMULATED else []),
        ],
    log:
        "<logs>/release.log",
    localrule: True
    params:
        code=script_digest("release.py"),
        # the code when the run began; the script refuses a release if it has changed since
        tree=code_tree_digest(HOME),
        releases=prefixed("results/releases", CAMPAIGN.name).as_posix(),
        sheet_digests=digests_of_sheets(),
        config=SETTINGS.plain_values(),
    script:
        "../scripts/release.py"
