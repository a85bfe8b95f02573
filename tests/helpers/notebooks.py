"""Run the notebooks of docs/notebooks, cell by cell, as Jupyter does; renew what they store.

`make notebooks` stores text and pictures anew. The tests compare the text.
"""

import ast
import base64
import contextlib
import io
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parents[2] / "docs/notebooks"


def run_cell(source: str, namespace: dict[str, Any]) -> list[dict[str, Any]]:
    """Outputs of one cell: what it printed, the value of its last line, its pictures."""
    # imported where needed: it takes a third of a second
    from matplotlib import pyplot  # noqa: PLC0415

    pyplot.switch_backend("agg")
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, outputs = io.StringIO(), []
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "<cell>", "exec"), namespace)
        value = last and eval(compile(ast.Expression(last.value), "<cell>", "eval"), namespace)
    if printed.getvalue():
        text = printed.getvalue().splitlines(keepends=True)
        outputs.append({"output_type": "stream", "name": "stdout", "text": text})
    # a semicolon at the end hides the value
    if value is not None and not source.rstrip().endswith(";"):
        data = {"text/plain": repr(value).splitlines(keepends=True)}
        if hasattr(value, "_repr_html_"):
            data["text/html"] = value._repr_html_().splitlines(keepends=True)
        outputs.append(_shown(data) | {"output_type": "execute_result", "execution_count": None})
    for number in pyplot.get_fignums():
        picture = io.BytesIO()
        pyplot.figure(number).savefig(picture, format="png", dpi=80, metadata={"Software": None})
        outputs.append(
            _shown({"image/png": base64.b64encode(picture.getvalue()).decode()})
            | {"output_type": "display_data"}
        )
    pyplot.close("all")
    return outputs


def _shown(data: dict[str, Any]) -> dict[str, Any]:
    return {"data": data, "metadata": {}}


def execute(path: Path) -> dict[str, Any]:
    """A notebook with the outputs of a run in an empty folder: it brings its data itself."""
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    namespace: dict[str, Any] = {"__name__": "__main__"}
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for cell in notebook["cells"]:
                if cell["cell_type"] == "code":
                    cell["outputs"] = run_cell("".join(cell["source"]), namespace)
        finally:
            os.chdir(before)
    return notebook


def texts(notebook: dict[str, Any]) -> list[str]:
    """What the cells printed or gave back, in order."""
    return [
        "".join(output["text"] if "text" in output else output["data"]["text/plain"])
        for cell in notebook["cells"]
        for output in cell.get("outputs", [])
        if "text" in output or "text/plain" in output["data"]
    ]


if __name__ == "__main__":
    for notebook_path in sorted(FOLDER.glob("*.ipynb")):
        made = execute(notebook_path)
        content = json.dumps(made, indent=1, ensure_ascii=False) + "\n"
        notebook_path.write_text(content, encoding="utf-8")
        print(notebook_path, file=sys.stderr)
