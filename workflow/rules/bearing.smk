rule torque_runs:
    "Steady plateaus of the torque logs, zero removed, with every gate's verdict."
    input:
        listing=rules.torque_twin.output.listing if TORQUE_SIMULATED else [],
        logs=raw_logs(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
    output:
        **written("torque_runs", "torque_quarantine"),
        logs="<parts>/torque_runs/logs.sha256",
        made=step_listing("torque-runs"),
    log:
        "<logs>/torque-runs.log",
    localrule: True
    params:
        code=lambda wildcards: script_digest(
            "torque_runs.py", tables=rules.torque_runs.output.keys()
        ),
        files=lambda wildcards: digests_of_logs(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
        acknowledged=ACKNOWLEDGED_CHANGES,
        first_seen=FIRST_SEEN_FOLDER,
        sheet=sheet_rows(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
        config=settings_part(
            "oils", "rigs", "torque_logs", "curation", campaign=("header", "oil_aliases", "torque")
        ),
    script:
        "../scripts/torque_runs.py"


rule torque:
    "Measured torque beside the law with each load variable; how hot the oil leaves the bearing."
    input:
        **finished("torque_runs", "cage_slip", "points", "surface_sizes", *FIT_TABLE_NAMES),
        torque_truth=rules.torque_twin.output.torque_truth if TORQUE_SIMULATED else [],
    output:
        **written("torque", "torque_inversion", "torque_control", "heat_balance"),
        **written("bearing_answers", "variance_shares"),
        made=step_listing("torque"),
    log:
        "<logs>/torque.log",
    priority: 1
    params:
        code=lambda wildcards: script_digest("torque.py", tables=rules.torque.output.keys()),
        config=settings_part(
            *("rigs", "oils", "bearings", "bearing", "gates", "plan", "seed", "torque_logs"),
            campaign=("oils", "torque", "twin"),
        ),
    script:
        "../scripts/torque.py"


rule bearing_maps:
    "Cage slip over speed and load, and the size effect."
    input:
        **finished("points", "surface_sizes", *FIT_TABLE_NAMES),
    output:
        **written("cage_slip", "size_effect"),
        made=step_listing("bearing-maps"),
    log:
        "<logs>/bearing-maps.log",
    # the longest chain of jobs begins here: started late, it alone would run at the end
    priority: 2
    params:
        code=lambda wildcards: script_digest(
            "bearing_maps.py", tables=rules.bearing_maps.output.keys()
        ),
        config=settings_part(
            *("rigs", "oils", "bearings", "bearing", "gates", "seed"),
            campaign=("torque",),
        ),
    script:
        "../scripts/bearing_maps.py"


rule bearing_temperatures:
    "Cage slip over speed and load at further oil temperatures, for the explorer of the report."
    input:
        **finished("points", "surface_sizes", *FIT_TABLE_NAMES),
    output:
        **written("cage_slip_by_temperature"),
        made=step_listing("bearing-temperatures"),
    log:
        "<logs>/bearing-temperatures.log",
    params:
        code=lambda wildcards: script_digest(
            "bearing_temperatures.py", tables=rules.bearing_temperatures.output.keys()
        ),
        config=settings_part(
            *("rigs", "oils", "bearings", "bearing", "gates", "seed"),
            campaign=("torque",),
        ),
    script:
        "../scripts/bearing_temperatures.py"


rule test_plan:
    "Rig conditions to test next: those that most reduce the uncertainty of torque or cage slip."
    input:
        **finished("curve_residuals", "points", "surface_sizes", *FIT_TABLE_NAMES),
    output:
        **written("test_plan"),
        made=step_listing("test-plan"),
    log:
        "<logs>/test-plan.log",
    localrule: True
    params:
        code=lambda wildcards: script_digest("test_plan.py", tables=rules.test_plan.output.keys()),
        config=settings_part(
            *("rigs", "oils", "bearings", "bearing", "film", "gates", "plan", "seed"),
            campaign=("torque",),
        ),
    script:
        "../scripts/test_plan.py"
