# Every table but the samples, which are many files.
TABLE_FILES = [
    rules.collect.output.runs,
    rules.collect.output.points,
    rules.collect.output.quarantine,
    *rules.coverage.output,
    *rules.fits.output,
    *rules.comparisons.output,
    *EXTRAPOLATION,
    *rules.printed.output,
    *rules.signs.output,
    *rules.audit.output,
    *TORQUE,
]


rule metadata:
    "What the tables are, for other programs: a data package."
    input:
        tables=[
            *(
                in_report(path, caption=caption_file("tables", Path(path).stem), category="Tables")
                for path in TABLE_FILES
            ),
            expand(rules.ingest.output.samples, shard=SHARDS),
        ],
    output:
        package="<tables>/datapackage.json",
    log:
        "<logs>/metadata.log",
    params:
        code=code("metadata.py"),
        config=part("dataset", campaign=("description",)),
    script:
        "../scripts/metadata.py"


rule captions:
    "What figures and tables show, for Snakemake's own report (`snakemake --report`)."
    output:
        campaign="<results>/captions/campaign.rst",
        figures=expand("<results>/captions/figures/{figure}.rst", figure=CAMPAIGN.figures),
        tables=expand(
            "<results>/captions/tables/{table}.rst",
            table=[Path(path).stem for path in TABLE_FILES],
        ),
    log:
        "<logs>/captions.log",
    params:
        code=code("captions.py"),
        # tables that are not named after their model
        models={"torque_quarantine": "quarantine"},
        config=part(campaign=("description", "film_unjudged")),
    script:
        "../scripts/captions.py"
