rule refused:
    "One page per refused run, of either rig: its signals and the rows concerned."
    input:
        **finished("points", "runs", "quarantine", "torque_quarantine"),
        listing=rules.torque_twin.output.listing if TORQUE_SIMULATED else [],
        logs=raw_logs(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
        samples=expand(SAMPLE_FILES, share=SHARES),
    output:
        refused_pages=directory("<results>/refused"),
        made=step_listing("refused"),
    log:
        "<logs>/refused.log",
    params:
        code=lambda wildcards: script_digest("refused.py", tables=rules.refused.output.keys()),
        files=lambda wildcards: digests_of_logs(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
        sheet=sheet_rows(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
        pages_max=SETTINGS.figures.refused_pages_max,
        config=settings_part(
            *("oils", "rigs", "curation", "torque_logs"),
            campaign=(
                *ORIGIN_KEYS,
                *("header", "oil_aliases", "semantics", "semantics_of_rig", "torque"),
            ),
        ),
    script:
        "../scripts/refused.py"
