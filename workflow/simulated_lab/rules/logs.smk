# Logs that are SIMULATED: of the traction rig and of the torque rig, each with the truth behind it.

SIMULATOR_SCRIPTS = studies.folder("simulated_lab") / "scripts"
studies.declare_tables(["simulated_lab"])

if SIMULATED:

    rule twin:
        "SIMULATED logs of the whole campaign, and the truth behind them."
        input:
            printed=reference_file("printed_coefficients"),
        output:
            logs=raw_logs(RAW_FOLDER, LOG_NAMES),
            truth="<results>/twin/truth.parquet",
            listing="<results>/twin/logs.sha256",
        log:
            "<logs>/twin.log",
        localrule: True
        params:
            code=lambda wildcards: script_digest(
                SIMULATOR_SCRIPTS / "twin.py", tables=rules.twin.output.keys()
            ),
            config=settings_part(
                *("seed", "rigs"),
                # what the truth is computed from, beside the campaign file
                *["oils"] * bool(SIMULATED and CAMPAIGN.twin.thermal_ehl),
                campaign=("oils", "matrix", "twin"),
            ),
        script:
            "../scripts/twin.py"


if TORQUE_SIMULATED:

    rule torque_twin:
        "SIMULATED logs of the torque rig, and the truth behind them."
        input:
            printed=reference_file("printed_coefficients"),
        output:
            logs=raw_logs(TORQUE_RAW_FOLDER, TORQUE_LOG_NAMES),
            torque_truth="<results>/twin/torque_truth.parquet",
            listing="<results>/twin/torque_logs.sha256",
        log:
            "<logs>/torque-twin.log",
        localrule: True
        params:
            code=lambda wildcards: script_digest(
                SIMULATOR_SCRIPTS / "torque_twin.py", tables=rules.torque_twin.output.keys()
            ),
            config=settings_part(
                "rigs",
                "oils",
                "bearings",
                "bearing",
                "seed",
                campaign=("oils", "matrix", "torque", "twin"),
            ),
        script:
            "../scripts/torque_twin.py"
