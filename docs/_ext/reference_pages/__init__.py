"""Files that are generated from the code: pages of the reference, JSON schemas for editors.

`make schemas` renews them; a test fails where one is out of date.
"""

from collections.abc import Callable
from functools import partial

from reference_pages import commands, configuration, decisions, gates, laws, schemas, tables, ways

GENERATED: dict[str, Callable[[], str]] = {
    "docs/explanation/decisions.md": decisions.page,
    "docs/explanation/ways.md": ways.page,
    "docs/reference/commands.md": commands.page,
    "docs/reference/configuration.md": configuration.index,
    **{
        f"docs/reference/configuration/{name}.md": partial(configuration.page, name)
        for name in configuration.PAGES
    },
    "docs/reference/gates.md": gates.page,
    "docs/reference/laws.md": laws.page,
    "docs/reference/tables.md": tables.page,
    **{
        f"workflow/schemas/{name}.schema.json": partial(schemas.of_file, name)
        for name in schemas.FILES
    },
    **{path: partial(schemas.of_study, path) for path in schemas.OF_STUDIES},
}
# The pages of studies are those of one study.
for study in configuration.OF_STUDIES:
    GENERATED["docs/study/settings.md"] = partial(configuration.page, study)
