"""Files that earlier runs wrote and the campaign no longer asks for, as those of a dropped law.

Decides: which files a run removes from the results of its campaign.
"""

from collections.abc import Collection, Iterable
from itertools import product
from pathlib import Path
from typing import Any

from oilfilm.digests import files_below
from oilfilm.home import portable
from oilfilm.logs.raw_files import read_listings

# Folders in which steps alone write. Elsewhere a file is theirs if one of them has listed it.
_OF_STEPS = ("logs/", "made/", "parts/", "tables/samples/", "twin/")


def asked_for(rules: Iterable[Any], **wildcards: Collection[Any]) -> set[str]:
    """Files and folders that the rules of a campaign write, with the logs of their jobs.

    Args:
        rules: Snakemake's rules; those with other wildcards belong to another workflow.
        wildcards: Values of each wildcard.
    """
    asked: set[str] = set()
    for rule in rules:
        names = sorted(rule.wildcard_names)
        if not wildcards.keys() >= {*names}:
            continue
        for values in product(*(wildcards[name] for name in names)):
            of_job = dict(zip(names, values, strict=True))
            paths = (path.apply_wildcards(of_job) for path in (*rule.output, *rule.log))
            asked.update(map(str, paths))
    return asked


def remove_leftovers(results: Path, asked: set[str]) -> list[str]:
    """Remove what steps wrote and no rule writes any more; files of other origin stay.

    Args:
        results: Folder of the results of a campaign.
        asked: Files and folders that its rules write.

    Returns:
        Names of the removed files below the folder.
    """
    if not results.is_dir():
        return []
    written = read_listings(*results.glob("made/*.sha256"))
    removed = []
    for name in files_below(results):
        path = results / name
        of_steps = name.startswith(_OF_STEPS) or portable(path) in written
        needed = not asked.isdisjoint(map(str, (path, *path.parents)))
        if of_steps and not needed and not path.is_dir():  # a link to a folder is not of a step
            path.unlink()
            removed.append(name)
            _remove_empty(path.parent, results)
    return removed


def _remove_empty(folder: Path, results: Path) -> None:
    """Remove a folder without files, and those above it, below the results."""
    while folder != results and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent
