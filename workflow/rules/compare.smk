# The comparison fits laws of its own: another `fit.law` must not repeat it.
COMPARED = SETTINGS.with_changes({"fit": {"law": PAPER_LAW.name}})
COMPARE_TABLES = (
    "comparison",
    "law_coefficients",
    "law_fit_quality",
    "law_refits",
    "law_points",
)


COMPARED_LAWS = COMPARED.compare.laws
LAWS_PER_JOB = SETTINGS.split.laws or len(COMPARED_LAWS)
LAWS_OF_PART = [
    COMPARED_LAWS[first : first + LAWS_PER_JOB]
    for first in range(0, len(COMPARED_LAWS), LAWS_PER_JOB)
]


rule compare:
    "Laws fitted to one oil, judged on what they fit and on what they have not seen."
    input:
        drawn=lambda wildcards: [
            path
            for law in LAWS_OF_PART[int(wildcards.part)]
            for path in parts_of_fit(
                "compare",
                wildcards.oil,
                law,
                COMPARED.compare.bootstrap,
                COMPARED.compare.left_out_groups,
            )
        ],
        points="<parts>/collect/{oil}/points.parquet",
    output:
        **{table: f"<parts>/compare/{{oil}}/{{part}}/{table}.parquet" for table in COMPARE_TABLES},
    log:
        "<logs>/compare-{oil}/{part}.log",
    params:
        code=lambda wildcards: code(
            "compare.py", *(LAW_FILES[law] for law in LAWS_OF_PART[int(wildcards.part)])
        ),
        laws=lambda wildcards: LAWS_OF_PART[int(wildcards.part)],
        config=COMPARED.part("compare", "fit", "oils", "rigs", "seed"),
    script:
        "../scripts/compare.py"


rule comparisons:
    "The comparisons of all oils, a table each."
    input:
        **{
            table: expand(
                f"<parts>/compare/{{oil}}/{{part}}/{table}.parquet",
                oil=OILS,
                part=range(len(LAWS_OF_PART)),
            )
            for table in COMPARE_TABLES
        },
    output:
        **finished(*COMPARE_TABLES),
    log:
        "<logs>/comparisons.log",
    localrule: True
    params:
        code=code("fits.py"),
        config=part(),
    script:
        "../scripts/fits.py"


rule law_verdicts:
    "The configured law beside the best of the compared ones, and its misfit beside the noise."
    input:
        **finished(
            "points",
            "runs",
            "coefficients",
            "fit_quality",
            "comparison",
            "law_points",
        ),
    output:
        **finished("law_verdicts", "lack_of_fit"),
    log:
        "<logs>/law-verdicts.log",
    localrule: True
    params:
        code=code("law_verdicts.py"),
        config=part("gates", "oils", "rigs", "same_set_point", campaign=("matrix", "rigs")),
    script:
        "../scripts/law_verdicts.py"
