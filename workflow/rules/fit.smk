from oilfilm.traction import LAWS, PAPER_LAW

FITTED_LAW_NAMES = list(dict.fromkeys((*SETTINGS.compare.laws, SETTINGS.fit.law)))
# No fit depends on which law is configured. With a fixed one here, another choice reruns no fit.
SETTINGS_OF_ONE_FIT = SETTINGS.with_changes({"fit": {"law": PAPER_LAW.name}})
# Laws that are in one file are fitted by one job: a change of the file is a change of all.
LAW_NAMES_OF_FILE = {}
for law in FITTED_LAW_NAMES:
    LAW_NAMES_OF_FILE.setdefault(LAW_FILES[law].stem, []).append(law)


rule fit:
    "Constants of one file's laws for one oil, with standard errors, certificates, cross-validation."
    input:
        points="<parts>/collect/{oil}/points.parquet",
    output:
        **{table: f"<parts>/fit/{{oil}}/{{law_file}}/{table}.parquet" for table in FIT_TABLES},
        made=step_listing("fit-{oil}-{law_file}", oil=OILS, law_file=LAW_NAMES_OF_FILE),
    log:
        "<logs>/fit-{oil}/{law_file}.log",
    wildcard_constraints:
        law_file="|".join(LAW_NAMES_OF_FILE),
    # before rules that need no fit: these are done while the last fit runs
    priority: 1
    params:
        code=lambda wildcards: script_digest(
            "fit.py",
            LAW_FILES[LAW_NAMES_OF_FILE[wildcards.law_file][0]],
            tables=rules.fit.output.keys(),
        ),
        laws=lambda wildcards: LAW_NAMES_OF_FILE[wildcards.law_file],
        # laws of the conditions alone need nothing of the rig
        config=lambda wildcards: SETTINGS_OF_ONE_FIT.plain_part(
            *("fit", "seed"),
            *(
                ()
                if LAWS.keys() >= set(LAW_NAMES_OF_FILE[wildcards.law_file])
                else ("oils", "rigs")
            ),
        ),
    script:
        "../scripts/fit.py"


rule surface:
    "Surface of one oil's measured mu: how its runs differ, and the interval of the next run."
    input:
        **{
            table: expand(
                f"<parts>/fit/{{oil}}/{{law_file}}/{table}.parquet",
                law_file=LAW_NAMES_OF_FILE,
                allow_missing=True,
            )
            for table in FIT_TABLES
        },
        points="<parts>/collect/{oil}/points.parquet",
        runs="<parts>/collect/{oil}/runs.parquet",
    output:
        **{table: f"<parts>/surface/{{oil}}/{table}.parquet" for table in SURFACE_TABLES},
        made=step_listing("surface-{oil}", oil=OILS),
    log:
        "<logs>/surface-{oil}.log",
    priority: 1
    params:
        code=lambda wildcards: script_digest("surface.py", tables=rules.surface.output.keys()),
        config=settings_part("compare", "fit", "rigs", "same_condition", "surface"),
    script:
        "../scripts/surface.py"


rule fits:
    "The fits of all oils and laws, the configured law beside the others, misfit beside noise."
    input:
        **{
            table: expand(f"<parts>/surface/{{oil}}/{table}.parquet", oil=OILS)
            for table in SURFACE_TABLES
        },
        **{
            table: expand(
                f"<parts>/fit/{{oil}}/{{law_file}}/{table}.parquet",
                oil=OILS,
                law_file=LAW_NAMES_OF_FILE,
            )
            for table in FIT_TABLES
        },
        **finished("points", "runs"),
    output:
        **written(*FIT_TABLES, *SURFACE_TABLES, "law_verdicts", "lack_of_fit", "soundness"),
        made=step_listing("fits"),
    log:
        "<logs>/fits.log",
    localrule: True
    params:
        code=lambda wildcards: script_digest("fits.py", tables=rules.fits.output.keys()),
        config=settings_part(
            *("compare", "fit", "oils", "rigs", "same_condition", "same_set_point"),
            *("steadiness", "surface"),
            campaign=("matrix", "rigs"),
        ),
    script:
        "../scripts/fits.py"
