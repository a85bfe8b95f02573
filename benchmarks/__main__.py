"""The benchmarks and what each measures; `make bench NAME=...` runs one."""

import ast
import re
from pathlib import Path

FOLDER = Path(__file__).parent


def main() -> None:
    """Print the name of each benchmark, the first line of its docstring and how long it takes."""
    print("make bench NAME=...  with one of these names, and ARGS=... for what its file says:")
    for path in sorted(FOLDER.glob("[!_]*.py")):
        text = path.read_text(encoding="utf-8")
        if "if __name__ ==" in text:
            docstring = ast.get_docstring(ast.parse(text)) or ""
            title = docstring.partition("\n")[0].rstrip(".")
            duration = "".join(re.findall(r"(?m)^Takes (.+)\.$", docstring))
            print(f"  {path.stem:12s} {title} ({duration})")


if __name__ == "__main__":
    main()
