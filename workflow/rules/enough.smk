rule enough:
    "The last step: too few accepted runs end a run that is complete."
    input:
        **finished("runs", "quarantine", "torque_runs", "torque_quarantine"),
        # a person needs all of this to see why
        everything=[
            rules.report.output,
            rules.refused.output,
            *TABLE_FILES.values(),  # a table that somebody deletes is made again
            rules.report.input.samples,
            rules.figures.input,
            rules.exports.output,
        ],
    output:
        accepted_runs="<tables>/accepted_runs.txt",
        made=step_listing("enough"),
    log:
        "<logs>/enough.log",
    localrule: True
    params:
        code=script_digest("enough.py"),
        config=settings_part(campaign=("min_accepted_runs", "min_accepted_share", "torque")),
    script:
        "../scripts/enough.py"
