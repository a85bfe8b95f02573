from oilfilm.base.figure_catalogue import figures_by_family

# What each figure needs is declared above its function. One job draws a family of figures, because
# imports take longer than drawing.
#
# Decides: which figures one job draws.
for family, figures_of_family in figures_by_family(CAMPAIGN.figures).items():

    rule:
        name:
            f"{family}_figures"
        input:
            **inputs_of_figures(figures_of_family),
        output:
            **files_of_figures(figures_of_family),
            made=step_listing(f"{family}-figures"),
        log:
            f"<logs>/{family}-figures.log",
        localrule: True
        params:
            code=script_digest(
                "figures.py", *(figure.source for figure in figures_of_family), tables=["drawn"]
            ),
            # of files beside the module, from which its schematics are drawn
            csv_digests=sorted(
                {
                    file_digest(csv)
                    for figure in figures_of_family
                    for csv in figure.source.parent.glob("*.csv")
                }
            ),
            config=settings_of_figures(figures_of_family),
        script:
            "../scripts/figures.py"


rule figures:
    "All figures that the campaign lists, as PNG and SVG, and exactly what each shows."
    input:
        expand("<figures>/{figure}.{kind}", figure=CAMPAIGN.figures, kind=("png", "svg", "parquet")),
