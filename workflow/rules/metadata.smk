# Every table but the samples, which are many files.
TABLE_NAMES = (
    *("runs", "points", "quarantine", "coverage", "gate_counts"),
    *FIT_TABLES,
    *("law_verdicts", "lack_of_fit"),
    *TORQUE_TABLES,
    *(*PAPER_TABLES, *ADVICE_TABLES, *EXTRAPOLATION_TABLES),
)
TABLE_FILES = [path for path in finished(*TABLE_NAMES).values() if path]


rule metadata:
    "What the tables are, for other programs: a data package."
    input:
        tables=[
            in_report(path, caption=caption_file("tables", Path(path).stem), category="Tables")
            for path in TABLE_FILES
        ],
        # written by the jobs of the shares, so that samples pass through no other process
        listings=expand("<parts>/ingest/{shard}/samples.json", shard=SHARDS),
        samples=expand(SAMPLES, shard=SHARDS),
    output:
        package="<tables>/datapackage.json",
    log:
        "<logs>/metadata.log",
    localrule: True
    params:
        code=code("metadata.py", *TABLE_WORDS),
        config=part("dataset", campaign=("description", "studies")),
    script:
        "../scripts/metadata.py"


rule captions:
    "What figures and tables show, for Snakemake's own report (`snakemake --report`)."
    input:
        **finished("points"),
    output:
        campaign="<results>/captions/campaign.rst",
        figures=expand("<results>/captions/figures/{figure}.rst", figure=CAMPAIGN.figures),
        tables=expand(
            "<results>/captions/tables/{table}.rst",
            table=[Path(path).stem for path in TABLE_FILES],
        ),
    log:
        "<logs>/captions.log",
    localrule: True
    params:
        code=code("captions.py", *TABLE_WORDS),
        config=part(campaign=("description", "studies", *ORIGIN)),
    script:
        "../scripts/captions.py"
