"""A campaign made anew and held against its pin: `make nightly`, and what runs every night.

Three steps, of which one that fails ends the rest: the release is made, it is held against
data/reference/pins by the drift gate of config.yaml, and it is made a second time from the raw logs
and compared byte by byte. What was found goes to results/nightly/<campaign>.md, and where GitHub
runs it, to the summary of the job.
"""

import os
import subprocess
import sys
from pathlib import Path

LONGEST = 200  # lines of a step in the summary


def main(campaign: str) -> int:
    """Run the steps in the project's folder; 0 where all went well."""
    release = Path("results/releases", campaign, "latest")
    pin = Path("data/reference/pins", campaign)
    kept = Path("results/nightly")
    kept.mkdir(parents=True, exist_ok=True)
    page = kept / f"{campaign}.html"
    page.unlink(missing_ok=True)  # another night's
    python = [sys.executable, "-m"]
    steps = {
        "refit": [*python, "snakemake", "release", "--config", f"campaign={campaign}"],
        "drift gate": [
            *[*python, "oilfilm", "diff", str(pin), str(release)],
            *["--gate", "--html", str(page)],
        ],
        "verify": [*python, "oilfilm", "verify", str(release), "--rebuild"],
    }
    summary = [f"# Campaign {campaign}", "", *describe(release, page)]
    failed = ""
    for name, command in steps.items():
        if failed:
            summary += ["", f"## {name}: not run, because {failed} failed"]
            continue
        print(f"--- {name}: {' '.join(command[2:])}", flush=True)
        done = subprocess.run(  # noqa: S603 - fixed commands; the campaign is one argument
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
        )
        print(done.stdout, end="", flush=True)
        summary += ["", f"## {name}: {'failed' if done.returncode else 'passed'}", ""]
        if done.returncode or name != "refit":
            summary += block(done.stdout)
        if done.returncode:
            failed = name
    result = Path("results", campaign, "summary.txt")
    if failed != "refit" and result.is_file():
        summary += ["", "## What the campaign says", "", *block(result.read_text("utf-8"))]
    text = "\n".join(summary) + "\n"
    (kept / f"{campaign}.md").write_text(text, encoding="utf-8")
    if "GITHUB_STEP_SUMMARY" in os.environ:
        with Path(os.environ["GITHUB_STEP_SUMMARY"]).open("a", encoding="utf-8") as shown:
            shown.write(text)
    print(f"--- {campaign}: {f'{failed} FAILED' if failed else 'all well'}; see {kept}")
    return int(bool(failed))


def describe(release: Path, page: Path) -> list[str]:
    """Where the pictures are: a job's summary can show none that is not on a public address."""
    return [
        f"Figures are in the job's artifact: `{release}/figures`; `{page}` names and shows those "
        "that differ from the pin's release, of which a pin keeps the hashes alone."
    ]


def block(text: str) -> list[str]:
    """A step's last words as they are, fenced by more backquotes than are in them."""
    fence = "`" * 4
    lines = text.replace(fence, "'" * 4).strip().splitlines() or ["nothing to say"]
    cut = [f"... {len(lines) - LONGEST} lines before"] if len(lines) > LONGEST else []
    return [fence, *cut, *lines[-LONGEST:], fence]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
