"""Every Python that starts with this folder on its path notes what it has used, when it ends.

The largest memory is `VmHWM`: `ru_maxrss` of a job begins with that of the process that started it.
"""

import atexit
import json
import os
import resource
import sys
from pathlib import Path


def note() -> None:
    """Append the script, its CPU seconds and its largest memory in MiB to the file of notes."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    memory = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    used = resource.getrusage(resource.RUSAGE_SELF)
    # those of Snakemake are tmp<letters>.<name of the script>
    script = Path(sys.argv[0]).name
    script = script.partition(".")[2] if script.startswith("tmp") else script
    cpu_s = used.ru_utime + used.ru_stime
    with Path(os.environ["OILFILM_USAGE"]).open("a", encoding="utf-8") as file:
        file.write(json.dumps({"step": script, "cpu_s": cpu_s, "mib": memory / 1024}) + "\n")


if "OILFILM_USAGE" in os.environ:
    atexit.register(note)
