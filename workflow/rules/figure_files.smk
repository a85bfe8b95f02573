# Decides: which files figures are made of, and what they are drawn from.


def files_of_figures(figures):
    """Files of figures, each as PNG and SVG, and the table `drawn` of exactly what it shows.

    Snakemake's report shows each PNG, under the figure's number in the publication of its study
    (`counterpart`), else under its title.
    """
    return {
        "png": [
            in_report(
                f"<figures>/{figure.name}.png",
                category=figure.category,
                labels={"figure": figure.counterpart or figure.title},
            )
            for figure in figures
        ],
        "svg": [f"<figures>/{figure.name}.svg" for figure in figures],
        "drawn": [f"<figures>/{figure.name}.parquet" for figure in figures],
    }


def inputs_of_figures(figures):
    """Finished tables and reference files that figures are drawn from."""
    references = sorted({name for figure in figures for name in figure.references})
    table_names = {name for figure in figures for name in figure.tables}
    if table_names & set(FIT_TABLES):
        table_names.add("fit_quality")  # it says which law is configured
    # a list of their own: the reference file of the claims has the name of their table
    return {**finished(*sorted(table_names)), "references": list(map(reference_file, references))}


def settings_of_figures(figures):
    """Settings that figures depend on; each says where its data are from."""
    keys = {key for figure in figures for key in figure.settings}
    campaign_keys = {key for key in keys if key.startswith("campaign.")}
    return settings_part(
        *(keys - campaign_keys),
        campaign=(*ORIGIN_KEYS, *(key.removeprefix("campaign.") for key in campaign_keys)),
    )
