"""The release of a report: the only text of the page that a release writes."""

from markupsafe import Markup

_FIELD = Markup('<dd id="release">{}</dd>')
UNRELEASED = _FIELD.format("not released")


def with_release(page: str, version: str) -> str:
    """A report with the version of its release.

    The field occurs once in a page: names and texts of a campaign are escaped there.

    Args:
        page: A report as a run makes it.
        version: Version of the release that will have the report.

    Raises:
        ValueError: The page has no field for the version.
    """
    before, field, after = page.partition(UNRELEASED)
    if not field:
        raise ValueError("the page has no field for the version of a release")
    return f"{before}{_FIELD.format(version)}{after}"
