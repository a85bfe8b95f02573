# Every table but the samples, which are many files.
TABLE_NAMES = (
    *("runs", "points", "quarantine", "coverage", "gate_counts"),
    *OF_FIT,
    *("law_verdicts", "lack_of_fit", "soundness"),
    *NOT_IN_EVERY_CAMPAIGN,
)
TABLE_FILES = {name: path for name, path in finished(*TABLE_NAMES).items() if path}


rule metadata:
    "What tables are: a data package."
    input:
        tables=[in_report(path, category="Tables") for path in TABLE_FILES.values()],
        samples=expand(SAMPLES, shard=SHARDS),
    output:
        package="<tables>/datapackage.json",
        made=made("metadata"),
    log:
        "<logs>/metadata.log",
    # no other rule needs it: it runs beside the report
    priority: -1
    localrule: True
    params:
        code=code("metadata.py", *TABLE_WORDS),
        config=part("dataset", campaign=("description", "studies", *ORIGIN)),
    script:
        "../scripts/metadata.py"
