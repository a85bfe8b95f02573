rule enough:
    "The last step: too few accepted runs end a run that is complete, so that it counts as failed."
    input:
        **finished("runs", "quarantine", "torque_runs", "torque_quarantine"),
        # a person needs all of this to see why runs were refused
        everything=[
            rules.summary.output,
            rules.report.output,
            rules.certified.output,
            rules.coverage.output,
            rules.refused.output,
            *finished("claims").values(),
            rules.figures.input,
            rules.metadata.output,
            rules.metadata.input.tables,  # a table that somebody deletes is made again
            rules.metadata.input.samples,
            rules.captions.output,
            rules.exports.output,
        ],
    output:
        "<tables>/accepted_runs.txt",
    log:
        "<logs>/enough.log",
    localrule: True
    params:
        code=code("enough.py"),
        config=part(campaign=("min_accepted_runs", "min_accepted_share", "torque")),
    script:
        "../scripts/enough.py"
