"""Which release a report lies in: the one thing in the page that a release writes."""

from markupsafe import Markup

_MARK = Markup('<dd id="release">{}</dd>')
UNRELEASED = _MARK.format("not released")


def with_release(page: str, version: str) -> str:
    """A report that says which release it is of, wherever it is passed on to.

    Nothing else in the page can look like the mark: names and texts are escaped in it.

    Args:
        page: A report as a run makes it.
        version: Of the release that it goes into.

    Raises:
        ValueError: It is no such report.
    """
    before, mark, after = page.partition(UNRELEASED)
    if not mark:
        raise ValueError("the page has no field for the id of a release")
    return f"{before}{_MARK.format(version)}{after}"
