"""Equations as text: parsed once, then differentiated, compiled for NumPy and written elsewhere.

The text is arithmetic as Python and SymPy read it: "A*tanh(B*S/A)". A parsed equation is a graph
of `Node` in which equal parts are one object, so that a part that occurs twice is computed once.
No package for algebra is needed at run time, and nothing generated is stored (why not SymPy:
docs/how-to/extend.md).
"""

import ast
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}


@dataclass(frozen=True, eq=False)
class Node:
    """An operation on other nodes, or a leaf.

    Attributes:
        operation: "+", "-", "*", "/", "**", "negative", the name of a function, "name" or "number".
        operands: Nodes that it takes; empty for a leaf.
        leaf: Name or number of a leaf.
    """

    operation: str
    operands: tuple["Node", ...] = ()
    leaf: str | float = ""


@cache
def _node(operation: str, *operands: Node) -> Node:
    return Node(operation, operands)


@cache
def name(text: str) -> Node:
    """A coefficient, the slip, or the result of a step."""
    return Node("name", leaf=text)


@cache
def number(value: float) -> Node:
    """A number of the equation."""
    return Node("number", leaf=value)


_ZERO, _ONE, _TWO = number(0.0), number(1.0), number(2.0)


def _negative(node: Node) -> Node:
    if node is _ZERO:
        return node
    return node.operands[0] if node.operation == "negative" else _node("negative", node)


def _add(first: Node, second: Node) -> Node:
    if first is _ZERO:
        return second
    if second is _ZERO:
        return first
    if "negative" in (first.operation, second.operation):
        if first.operation != "negative":
            return _node("-", first, second.operands[0])
        positive = first.operands[0]
        if second.operation != "negative":
            return _node("-", second, positive)
        return _negative(_add(positive, second.operands[0]))
    return _node("+", first, second)


def _subtract(first: Node, second: Node) -> Node:
    return _add(first, _negative(second))


def _multiply(first: Node, second: Node) -> Node:
    if _ZERO in (first, second):
        return _ZERO
    if first is _ONE:
        return second
    if second is _ONE:
        return first
    if second.operation == "*":
        # x (y (z/x)), as derivatives of x f(z/x) have it
        rest = second.operands[1]
        if rest.operation == "/" and rest.operands[1] is first:
            return _multiply(second.operands[0], rest.operands[0])
    return _with_sign("*", first, second)


def _divide(first: Node, second: Node) -> Node:
    return first if first is _ZERO or second is _ONE else _with_sign("/", first, second)


def _with_sign(operation: str, first: Node, second: Node) -> Node:
    """A product or quotient whose sign stands before it."""
    if first.operation == "negative":
        return _negative(_BUILD[operation](first.operands[0], second))
    if second.operation == "negative":
        return _negative(_BUILD[operation](first, second.operands[0]))
    return _node(operation, first, second)


def _power(base: Node, exponent: Node) -> Node:
    return base if exponent is _ONE else _node("**", base, exponent)


_BUILD: dict[str, Callable[..., Node]] = {
    "+": _add,
    "-": _subtract,
    "*": _multiply,
    "/": _divide,
    "**": _power,
    "negative": _negative,
}

# Function -> NumPy's, and the derivative of f = function(u) by the chain rule, from u, f and du.
_FUNCTIONS: dict[str, tuple[Any, Callable[[Node, Node, Node], Node]]] = {
    "exp": (np.exp, lambda u, f, du: _multiply(f, du)),
    "expm1": (np.expm1, lambda u, f, du: _multiply(_node("exp", u), du)),
    "log": (np.log, lambda u, f, du: _divide(du, u)),
    "log1p": (np.log1p, lambda u, f, du: _divide(du, _add(_ONE, u))),
    "sqrt": (np.sqrt, lambda u, f, du: _divide(du, _multiply(_TWO, f))),
    "tanh": (np.tanh, lambda u, f, du: _multiply(_subtract(_ONE, _power(f, _TWO)), du)),
    "asinh": (np.arcsinh, lambda u, f, du: _divide(du, _node("sqrt", _add(_ONE, _power(u, _TWO))))),
    "abs": (np.abs, lambda u, f, du: _multiply(_node("sign", u), du)),
    "sign": (np.sign, lambda u, f, du: _ZERO),
}


def parse(text: str, values: Mapping[str, Node], parts: Sequence[tuple[str, str]] = ()) -> Node:
    """The graph of an equation.

    Args:
        text: Arithmetic: + - * / **, numbers, the names of `values` and the functions exp, expm1,
            log, log1p, sqrt, tanh, asinh, abs and sign.
        values: What each name is.
        parts: Names for parts of the equation and their text, each by `values` and earlier parts.

    Raises:
        ValueError: The text has anything else in it.
    """
    for part, definition in parts:
        values = {**values, part: parse(definition, values)}

    def build(tree: ast.expr) -> Node:
        match tree:
            case ast.Constant(value=int() | float() as value):
                return number(float(value))
            case ast.Name(id=known) if known in values:
                return values[known]
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return _negative(build(operand))
            case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
                return _BUILD[_OPERATORS[type(operator)]](build(left), build(right))
            case ast.Call(func=ast.Name(id=function), args=[argument]) if function in _FUNCTIONS:
                return _node(function, build(argument))
        raise ValueError(
            f"{text!r}: found {ast.unparse(tree)!r}; expected numbers, {', '.join(values)}, "
            f"+ - * / **, and the functions {', '.join(_FUNCTIONS)}"
        )

    return build(ast.parse(text, mode="eval").body)


def parse_steps(steps: Iterable[tuple[str, str]], names: Iterable[str]) -> list[tuple[str, Node]]:
    """The graphs of named equations, each by the given names and by those of earlier steps."""
    known = {text: name(text) for text in names}
    parsed = []
    for step, text in steps:
        parsed.append((step, parse(text, known)))
        known[step] = name(step)
    return parsed


def _below(nodes: Iterable[Node]) -> Iterator[Node]:
    """Nodes and all their operands, those of one node after it."""
    for node in nodes:
        yield node
        yield from _below(node.operands)


def functions_of(nodes: Iterable[Node]) -> set[str]:
    """Names of the functions that occur in any of the nodes."""
    return _FUNCTIONS.keys() & {node.operation for node in _below(nodes)}


def logarithmic_derivative(node: Node, variable: str) -> Node:
    """x df/dx of a node f, x the variable: the change of f per relative change of x."""
    known: dict[Node, Node] = {}

    def derive(f: Node) -> Node:
        if f not in known:
            known[f] = _derivative(f, [derive(operand) for operand in f.operands], variable)
        return known[f]

    return derive(node)


def _derivative(f: Node, changes: Sequence[Node], variable: str) -> Node:
    """Derivative of one operation from those of its operands."""
    if not f.operands:
        return f if f.leaf == variable else _ZERO
    if f.operation in ("+", "-", "negative"):
        return _BUILD[f.operation](*changes)
    if f.operation in _FUNCTIONS:
        return _FUNCTIONS[f.operation][1](f.operands[0], f, changes[0])
    (u, v), (du, dv) = f.operands, changes
    if f.operation == "*":
        return _add(_carried(f, u, du) or _multiply(du, v), _carried(f, v, dv) or _multiply(u, dv))
    if f.operation == "/":
        by_divisor = _carried(f, v, dv) or _multiply(f, _divide(dv, v))
        return _subtract(_carried(f, u, du) or _divide(du, v), by_divisor)
    relative = _carried(f, u, du) or (
        _multiply(_power(u, number(v.leaf - 1)), du)
        if isinstance(v.leaf, float)
        else _multiply(f, _divide(du, u))
    )
    by_exponent = _ZERO if dv is _ZERO else _multiply(f, _multiply(dv, _node("log", u)))
    return _add(_multiply(v, relative), by_exponent)


def _carried(f: Node, part: Node, change: Node) -> Node | None:
    """The change of a product f with one part: f itself where that is proportional to x."""
    if change is part:
        return f
    if change is _ZERO:
        return _ZERO
    return _negative(f) if change is _negative(part) else None


def in_steps(results: Sequence[Node]) -> tuple[list[tuple[str, Node]], list[Node]]:
    """Straight-line form: what occurs more than once is computed first, and named.

    Returns:
        Steps in their order, each a name and a node of earlier names; and the results by them.
    """
    uses = Counter(results)
    waiting = list(uses)
    while waiting:
        operands = waiting.pop().operands
        waiting += [operand for operand in {*operands} if operand not in uses]
        uses.update(operands)

    steps: list[tuple[str, Node]] = []
    written: dict[Node, Node] = {}

    def write_out(node: Node) -> Node:
        if not node.operands:
            return node
        if node not in written:
            # not built again by `_BUILD`: the order of operations stays
            plain = _node(node.operation, *map(write_out, node.operands))
            if uses[node] > 1:
                steps.append((f"x{len(steps)}", plain))
                plain = name(steps[-1][0])
            written[node] = plain
        return written[node]

    return steps, [write_out(result) for result in results]


# ------------------------------------------------------------------------------- languages


@dataclass(frozen=True)
class Form:
    """How a language writes an operation.

    Attributes:
        template: Text with a gap for each operand.
        strength: How strongly it binds: 1 sum, 2 product, 4 power, 5 nothing can come between.
        needs: Least strength of each operand that can do without brackets.
    """

    template: str
    strength: int = 5
    needs: tuple[int, ...] = (0, 0)


_ARITHMETIC = {
    "+": Form("{} + {}", 1, (1, 2)),
    "-": Form("{} - {}", 1, (1, 2)),
    "negative": Form("-{}", 1, (2,)),
    "*": Form("{} * {}", 2, (2, 3)),
    "/": Form("{} / {}", 2, (2, 3)),
    "**": Form("{}**{}", 4, (5, 5)),
}


@dataclass(frozen=True)
class Language:
    """How one language writes equations; forms that it does not name are those of Python.

    Attributes:
        forms: Operation or function -> its form.
        numeral: A number, as text.
        identifier: A name, as text.
        brackets: What keeps a part together.
    """

    forms: Mapping[str, Form]
    numeral: Callable[[Any], str] = repr
    identifier: Callable[[Any], str] = str
    brackets: str = "({})"

    def write(self, node: Node) -> str:
        """The node as text."""
        return self._written(node)[0]

    def _written(self, node: Node) -> tuple[str, int]:
        """The node as text, and how strongly it binds."""
        if not node.operands:
            of_leaf = self.numeral if isinstance(node.leaf, float) else self.identifier
            return of_leaf(node.leaf), 5
        default = _ARITHMETIC.get(node.operation, Form(f"{node.operation}({{}})"))
        form = self.forms.get(node.operation, default)
        operands = [
            text if strength >= least else self.brackets.format(text)
            for (text, strength), least in zip(
                map(self._written, node.operands), form.needs, strict=False
            )
        ]
        return form.template.format(*operands), form.strength


NUMPY = Language({})


def compiled(parameters: Sequence[str], results: Sequence[Node]) -> Callable[..., Any]:
    """A function of arrays that gives the tuple of results."""
    steps, ends = in_steps(results)
    lines = [f"{step} = {NUMPY.write(node)}" for step, node in steps]
    values = ", ".join(NUMPY.write(end) for end in ends)
    body = "\n    ".join([*lines, f"return ({values},)"])
    source = f"def function({', '.join(parameters)}):\n    {body}\n"
    namespace: dict[str, Any] = {function: made for function, (made, _) in _FUNCTIONS.items()}
    # the text was made here, from a parsed equation that holds arithmetic only
    exec(compile(source, "<equation>", "exec"), namespace)  # noqa: S102
    return namespace["function"]
