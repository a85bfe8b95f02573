# The page itself, beside the code that fills it.
PAGE = PACKAGE / "report/page"


rule report:
    "What a reader wants to know of the campaign, in one HTML file that needs no network."
    input:
        **finished(
            "runs points quarantine coverage gate_counts coefficients correlations",
            "fit_quality law_verdicts lack_of_fit refits curve_residuals claims torque_runs",
            "torque_quarantine torque torque_control torque_inversion slip_advice advice_band",
            "heat_balance",
        ),
        refused_pages=rules.refused.output.pages,
        png=expand("<figures>/{figure}.png", figure=CAMPAIGN.figures),
        svg=expand("<figures>/{figure}.svg", figure=CAMPAIGN.figures),
    output:
        page="<results>/report.html",
    log:
        "<logs>/report.log",
    localrule: True
    params:
        code=code("report.py", *LAW_FILES.values(), *TABLE_WORDS),
        # no digest of Python's modules covers these
        page=[file_digest(PAGE.with_suffix(end)) for end in (".html.jinja", ".css", ".js")],
        config=SETTINGS.plain(),
    script:
        "../scripts/report.py"
