"""Short functions and plain forms, as CONTRIBUTING.md asks. Ruff checks the complexity (C901)."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "workflow").rglob("*.py"))
LONGEST_FUNCTION = 60  # lines, docstring not counted
LONGEST_LAMBDA_LIST = 60


def lines_of(function: ast.FunctionDef) -> int:
    """Lines of a function without its docstring."""
    length = (function.end_lineno or 0) - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function) is not None:
        length -= (first.end_lineno or 0) - first.lineno + 1
    return length


def complaints_of(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef() if lines_of(node) > LONGEST_FUNCTION:
                yield f"{node.lineno}: {node.name} has {lines_of(node)} lines"
            case ast.BinOp(op=ast.Mult()) if any(map(is_text, (node.left, node.right))):
                yield f"{node.lineno}: text times a number; write `text if condition else ''`"
            case ast.BinOp(ast.List() | ast.Tuple(), ast.Mult(), ast.Compare() | ast.BoolOp()):
                yield f"{node.lineno}: list times a condition; write `[...] if ... else []`"
            case ast.While() if any(
                isinstance(part, ast.NamedExpr) for part in ast.walk(node.test)
            ):
                yield f"{node.lineno}: assignment in the condition of a while loop"
            case ast.Tuple() | ast.List() if has_long_lambdas(node):
                yield f"{node.lineno}: {len(node.elts)} entries with lambdas; write functions"


def is_text(node: ast.expr) -> bool:
    """Whether an operand is literal text with letters (`"-" * width` draws a line)."""
    if isinstance(node, ast.JoinedStr):
        return True
    text = node.value if isinstance(node, ast.Constant) else None
    return isinstance(text, str) and any(map(str.isalpha, text))


def has_long_lambdas(node: ast.Tuple | ast.List) -> bool:
    length = (node.end_lineno or 0) - node.lineno + 1
    return length > LONGEST_LAMBDA_LIST and any(
        isinstance(part, ast.Lambda) for part in ast.walk(node)
    )


@pytest.mark.parametrize(
    ("code", "complaint"),
    [
        ("text = 'none' * (count == 0)", "text times"),
        ("text = f'{count} runs' * flag", "text times"),
        ("rows = [header] * (count > 0)", "list times"),
        ("while line := file.readline(): pass", "while"),
        ("def long():\n" + "    x = 1\n" * 60, "long has 61 lines"),
        ("checks = (\n" + "    lambda: 1,\n" * 60 + ")", "60 entries"),
        ("line = '-' * 80\nzeros = [0] * count", None),
    ],
)
def test_forms_are_recognised(code: str, complaint: str | None):
    complaints = "".join(complaints_of(ast.parse(code)))
    assert complaint in complaints if complaint else not complaints


def test_functions_are_short_and_forms_plain():
    complaints = [
        f"{file.relative_to(ROOT)}:{complaint}"
        for file in FILES
        for complaint in complaints_of(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert not complaints
