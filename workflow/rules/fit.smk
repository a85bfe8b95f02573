from oilfilm.traction import LAWS

FITTED_LAWS = list(dict.fromkeys((*SETTINGS.compare.laws, SETTINGS.fit.law)))
# Which law is configured and which are compared changes no fit.
OF_ONE_FIT = SETTINGS.with_changes(
    {"fit": {"law": next(iter(LAWS))}, "compare": {"laws": list(LAW_FILES)}}
)


rule fit:
    "One law's constants for one oil, with their errors, the certificate and errors left out."
    input:
        points="<parts>/collect/{oil}/points.parquet",
    output:
        **{table: f"<parts>/fit/{{oil}}/{{law}}/{table}.parquet" for table in OF_FIT},
        made=made("fit-{oil}-{law}", oil=OILS, law=FITTED_LAWS),
    log:
        "<logs>/fit-{oil}/{law}.log",
    wildcard_constraints:
        law="|".join(LAW_FILES),
    # what needs no fit is done while the last one runs
    priority: 1
    params:
        code=lambda wildcards: code("fit.py", LAW_FILES[wildcards.law]),
        # a law of the conditions alone needs nothing of the rig
        config=lambda wildcards: OF_ONE_FIT.part(
            *("compare", "fit", "seed"), *(() if wildcards.law in LAWS else ("oils", "rigs"))
        ),
    script:
        "../scripts/fit.py"


rule fits:
    "The fits of all oils and laws, the configured law beside the others, misfit beside noise."
    input:
        **{
            table: expand(
                f"<parts>/fit/{{oil}}/{{law}}/{table}.parquet", oil=OILS, law=FITTED_LAWS
            )
            for table in OF_FIT
        },
        **finished("points", "runs"),
    output:
        **finished(*OF_FIT, "law_verdicts", "lack_of_fit", "soundness"),
        made=made("fits"),
    log:
        "<logs>/fits.log",
    localrule: True
    params:
        code=code("fits.py"),
        config=part("fit", "gates", "oils", "rigs", "same_set_point", campaign=("matrix", "rigs")),
    script:
        "../scripts/fits.py"
