def logs_of_jobs(wildcards):
    """Logs of all jobs behind the release, whether they ran this time or before."""
    jobs = [job for job in workflow.dag.jobs if job.rule.name != "release"]
    return sorted(str(log) for job in jobs for log in job.log)


# No output: the name of a release depends on its content, and Snakemake deletes what it remakes.
rule release:
    "Everything the run has made, and what it was made from, in a folder that never changes."
    input:
        made=[*rules.all.input, *rules.metadata.input.tables],
        raw=[RAW.as_posix()] if SIMULATED else [(RAW / file).as_posix() for file in FILES],
    log:
        "<logs>/release.log",
    params:
        code=code("release.py"),
        tree=lambda wildcards: code_tree_digest(Path(workflow.basedir)),
        resolved=CONFIG,
        results=f"results/{CAMPAIGN['name']}",
        releases=f"results/releases/{CAMPAIGN['name']}",
        raw=[(RAW / file).as_posix() for file in FILES]
        + [(TORQUE_RAW / file).as_posix() for file in TORQUE_FILES],
        logs=logs_of_jobs,
        config=part(),
    script:
        "../scripts/release.py"
