rule metadata:
    "What the tables are, for other programs: data package, linked data and vocabulary."
    input:
        tables=[
            rules.collect.output.runs,
            expand(rules.ingest.output.samples, shard=SHARDS),
            rules.collect.output.points,
            rules.collect.output.quarantine,
            rules.coverage.output,
            rules.fits.output,
            rules.comparisons.output,
            EXTRAPOLATION,
            rules.printed.output,
            rules.signs.output,
            rules.audit.output,
            TORQUE,
        ],
        vocabulary="data/reference/vocabulary.ttl",
    output:
        package="<tables>/datapackage.json",
        description="<tables>/dataset.jsonld",
        vocabulary="<tables>/vocabulary.ttl",
    log:
        "<logs>/metadata.log",
    params:
        code=code("metadata.py"),
        config=part("dataset", campaign=("description",)),
    script:
        "../scripts/metadata.py"
