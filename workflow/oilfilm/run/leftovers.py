"""Files of earlier runs that the campaign no longer needs, such as those of a dropped law.

Decides: which files a run removes from the results of its campaign.
"""

from collections.abc import Collection, Iterable
from itertools import product
from pathlib import Path
from typing import Any

from oilfilm.base.digests import files_below
from oilfilm.base.home import project_path
from oilfilm.logs.raw_files import read_listings

# Folders in which only steps write. Elsewhere a file is of a step if a step has listed it.
_FOLDERS_OF_STEPS = ("logs/", "made/", "parts/", "tables/samples/", "twin/")


def paths_of_rules(rules: Iterable[Any], **values_of_wildcards: Collection[Any]) -> set[str]:
    """Files and folders that the rules of a campaign write, with the logs of their jobs.

    Args:
        rules: Snakemake's rules. Rules with other wildcards belong to another workflow.
        values_of_wildcards: Values of each wildcard.
    """
    paths: set[str] = set()
    for rule in rules:
        wildcard_names = sorted(rule.wildcard_names)
        if not set(wildcard_names) <= values_of_wildcards.keys():
            continue
        for values in product(*(values_of_wildcards[name] for name in wildcard_names)):
            wildcards_of_job = dict(zip(wildcard_names, values, strict=True))
            for pattern in (*rule.output, *rule.log):
                paths.add(str(pattern.apply_wildcards(wildcards_of_job)))
    return paths


def remove_leftovers(results: Path, needed_paths: set[str]) -> list[str]:
    """Remove files of steps that no rule writes any more; files of other origin stay.

    Args:
        results: Folder of the results of a campaign.
        needed_paths: Files and folders that its rules write.

    Returns:
        Names of the removed files below the folder.
    """
    if not results.is_dir():
        return []
    digest_by_path = read_listings(*results.glob("made/*.sha256"))
    removed_names = []
    for name in files_below(results):
        path = results / name
        is_of_step = name.startswith(_FOLDERS_OF_STEPS) or project_path(path) in digest_by_path
        is_needed = not needed_paths.isdisjoint(map(str, (path, *path.parents)))
        # no step makes a link to a folder
        if is_of_step and not is_needed and not path.is_dir():
            path.unlink()
            removed_names.append(name)
            _remove_empty(path.parent, results)
    return removed_names


def _remove_empty(folder: Path, results: Path) -> None:
    """Remove an empty folder, and the empty folders above it up to the results."""
    while folder != results and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent
