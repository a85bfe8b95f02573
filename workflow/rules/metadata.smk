# Every table but the samples, which are many files.
TABLE_NAMES = (
    *("runs", "points", "quarantine", "coverage", "gate_counts"),
    *OF_FIT,
    *("law_verdicts", "lack_of_fit", "soundness"),
    *NOT_IN_EVERY_CAMPAIGN,
)
TABLE_FILES = {name: path for name, path in finished(*TABLE_NAMES).items() if path}


rule metadata:
    "What tables and figures are: a data package, and captions for `snakemake --report`."
    input:
        **finished("points"),
        tables=[
            in_report(path, caption=caption_file("tables", name), category="Tables")
            for name, path in TABLE_FILES.items()
        ],
        samples=expand(SAMPLES, shard=SHARDS),
    output:
        package="<tables>/datapackage.json",
        campaign="<results>/captions/campaign.rst",
        figures=expand("<results>/captions/figures/{figure}.rst", figure=CAMPAIGN.figures),
        captions=expand("<results>/captions/tables/{table}.rst", table=TABLE_FILES),
        made=made("metadata"),
    log:
        "<logs>/metadata.log",
    localrule: True
    params:
        code=code("metadata.py", *TABLE_WORDS),
        config=part("dataset", campaign=("description", "studies", *ORIGIN)),
    script:
        "../scripts/metadata.py"
