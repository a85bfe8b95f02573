# No output: the name of a release depends on its content, and Snakemake deletes what it remakes.
rule release:
    "Everything the run has made, and what it was made from, in a folder that never changes."
    input:
        rules.all.input,
        rules.metadata.input.tables,
        rules.metadata.input.samples,
        simulated=["<raw>"] * SIMULATED + ["<torque_raw>"] * TORQUE_SIMULATED,
    log:
        "<logs>/release.log",
    localrule: True
    params:
        code=code("release.py"),
        tree=TREE,
        results=folder_of_results,
        releases=f"results/releases/{CAMPAIGN.name}",
        copies=str(COPIES),
        raw=raw_with_digests,
        config=SETTINGS.plain(),
    script:
        "../scripts/release.py"
