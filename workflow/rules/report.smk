from oilfilm.figure_catalogue import figures

# Sentences, the page and its style: no digest of Python's modules covers these.
PAGE_FILES = sorted(
    path
    for room in ("report", *CAMPAIGN.studies)
    for end in ("jinja", "css", "js")
    for path in (PACKAGE / room).rglob(f"*.{end}")
)


rule report:
    "What a reader wants to know of the campaign: an HTML file that needs no network, and text."
    input:
        **finished(
            "runs points quarantine coverage gate_counts coefficients",
            "fit_quality law_verdicts lack_of_fit soundness refits curve_residuals extrapolation",
            "printed_judged signs sign_verdicts claims claim_numbers torque_runs torque_quarantine",
            "torque torque_control torque_inversion cage_slip slip_advice advice_band heat_balance",
        ),
        refused_pages=rules.refused.output.pages,
        claim_words=reference_file("claims") if "paper" in CAMPAIGN.studies else [],
        png=expand("<figures>/{figure}.png", figure=CAMPAIGN.figures),
    output:
        page="<results>/report.html",
        summary="<results>/summary.txt",
        made=made("report"),
    log:
        "<logs>/report.log",
    localrule: True
    params:
        code=code("report.py", *LAW_FILES.values(), *TABLE_WORDS, *STUDIES),
        page=[file_digest(path) for path in PAGE_FILES],
        captions=[[figures()[name].title, figures()[name].caption] for name in CAMPAIGN.figures],
        config=SETTINGS.plain(),
    script:
        "../scripts/report.py"
