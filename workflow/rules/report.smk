from oilfilm.base.figure_catalogue import figures

# Sentences, the page and its style: no digest of Python's modules covers these.
PAGE_FILES = sorted(
    path
    for folder in (PACKAGE / "report", *map(studies.folder, CAMPAIGN.studies))
    for end in ("jinja", "css", "js")
    for path in folder.rglob(f"*.{end}")
)


# File of every table but the samples, which are many files. A table that this campaign lacks has an
# empty list.
TABLE_FILES = {
    name: in_report(path, category="Tables") if path else []
    for name, path in finished(*WRITTEN_TABLE_NAMES, *OPTIONAL_TABLES).items()
}


rule report:
    "What a reader wants to know of the campaign, as a page and as text; a data package of its tables."
    input:
        **TABLE_FILES,
        samples=expand(SAMPLE_FILES, share=SHARES),
        refused_pages=rules.refused.output.refused_pages,
        references=references_of_studies("reported"),
        png=expand("<figures>/{figure}.png", figure=CAMPAIGN.figures),
    output:
        page="<results>/report.html",
        summary="<results>/summary.txt",
        package="<tables>/datapackage.json",
        made=step_listing("report"),
    log:
        "<logs>/report.log",
    localrule: True
    params:
        tables=[name for name, path in TABLE_FILES.items() if path],
        code=script_digest(
            "report.py",
            *LAW_FILES.values(),
            *TABLE_DECLARATIONS,
            *STUDY_MODULES,
            *studies.shown_table_files(CAMPAIGN.studies),
        ),
        page=[file_digest(path) for path in PAGE_FILES],
        captions=[[figures()[name].title, figures()[name].caption] for name in CAMPAIGN.figures],
        config=SETTINGS.plain_values(),
    script:
        "../scripts/report.py"
