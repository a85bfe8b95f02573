"""Equations as text: parsed once, then differentiated, compiled for NumPy or exported.

The text is arithmetic in the syntax of Python and SymPy: "A*tanh(B*S/A)". A parsed equation is a
graph of `Node`. Equal parts of the graph are one object, so that a repeated part is computed once.
No package for algebra is needed at run time, and no generated code is stored. docs/how-to/extend.md
explains why SymPy is not used.
"""

import ast
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count
from typing import Any

import numpy as np

_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}


@dataclass(frozen=True, eq=False)
class Node:
    """An operation on other nodes, or a leaf.

    Attributes:
        operation: "+", "-", "*", "/", "**", "negative", the name of a function, "name" or "number".
        operands: Operands of the operation; empty for a leaf.
        leaf: Name or number of a leaf.
    """

    operation: str
    operands: tuple["Node", ...] = ()
    leaf: str | float = ""


@cache
def _node(operation: str, *operands: Node) -> Node:
    """The one node of an operation on these operands, without simplification."""
    return Node(operation, operands)


@cache
def name_node(name: str) -> Node:
    """The leaf of a name: of a coefficient, the slip, or the result of a step."""
    return Node("name", leaf=name)


@cache
def number_node(value: float) -> Node:
    """The leaf of a number."""
    return Node("number", leaf=value)


_ZERO = number_node(0.0)
_ONE = number_node(1.0)
_TWO = number_node(2.0)


def _negative(node: Node) -> Node:
    """-x, where -(-x) is x."""
    if node is _ZERO:
        return node
    if node.operation == "negative":
        return node.operands[0]
    return _node("negative", node)


def _add(x: Node, y: Node) -> Node:
    """x + y, with a negative term written as a difference."""
    if x is _ZERO:
        return y
    if y is _ZERO:
        return x
    if "negative" in (x.operation, y.operation):
        if x.operation != "negative":
            return _node("-", x, y.operands[0])
        minus_x = x.operands[0]
        if y.operation != "negative":
            return _node("-", y, minus_x)
        return _negative(_add(minus_x, y.operands[0]))
    return _node("+", x, y)


def _subtract(x: Node, y: Node) -> Node:
    """x - y."""
    return _add(x, _negative(y))


def _multiply(x: Node, y: Node) -> Node:
    """x y, where 0 y is 0 and 1 y is y."""
    if _ZERO in (x, y):
        return _ZERO
    if x is _ONE:
        return y
    if y is _ONE:
        return x
    if y.operation == "*":
        # x (y (z/x)), which occurs in derivatives of x f(z/x), is y z
        quotient = y.operands[1]
        if quotient.operation == "/" and quotient.operands[1] is x:
            return _multiply(y.operands[0], quotient.operands[0])
    return _with_sign("*", x, y)


def _divide(x: Node, y: Node) -> Node:
    """x/y, where 0/y is 0 and x/1 is x."""
    if x is _ZERO or y is _ONE:
        return x
    return _with_sign("/", x, y)


def _with_sign(operation: str, x: Node, y: Node) -> Node:
    """A product or quotient with its sign in front."""
    if x.operation == "negative":
        return _negative(_BUILDER_BY_OPERATION[operation](x.operands[0], y))
    if y.operation == "negative":
        return _negative(_BUILDER_BY_OPERATION[operation](x, y.operands[0]))
    return _node(operation, x, y)


def _power(x: Node, y: Node) -> Node:
    """x**y, where x**1 is x."""
    return x if y is _ONE else _node("**", x, y)


_BUILDER_BY_OPERATION: dict[str, Callable[..., Node]] = {
    "+": _add,
    "-": _subtract,
    "*": _multiply,
    "/": _divide,
    "**": _power,
    "negative": _negative,
}

# For each function: the function of NumPy, and the derivative of f = function(u) by the chain rule,
# from u, f and du.
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


def parse(
    text: str, node_by_name: Mapping[str, Node], named_parts: Sequence[tuple[str, str]] = ()
) -> Node:
    """The graph of an equation.

    Args:
        text: Arithmetic: + - * / **, numbers, the names of `node_by_name` and the functions exp,
            expm1, log, log1p, sqrt, tanh, asinh, abs and sign.
        node_by_name: Node of each name.
        named_parts: Name and text of parts of the equation. A text may use the names of
            `node_by_name` and of earlier parts.

    Raises:
        ValueError: The text has anything else.
        SyntaxError: The text is no expression.
    """
    all_nodes_by_name = dict(node_by_name)
    for part_name, part_text in named_parts:
        all_nodes_by_name[part_name] = parse(part_text, all_nodes_by_name)

    def build(tree: ast.expr) -> Node:
        """The graph of a part of the text, from Python's syntax tree of it."""
        match tree:
            case ast.Constant(value=int() | float() as value):
                return number_node(float(value))
            case ast.Name(id=variable) if variable in all_nodes_by_name:
                return all_nodes_by_name[variable]
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return _negative(build(operand))
            case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
                return _BUILDER_BY_OPERATION[_OPERATORS[type(operator)]](build(left), build(right))
            case ast.Call(func=ast.Name(id=function), args=[argument]) if function in _FUNCTIONS:
                return _node(function, build(argument))
        raise ValueError(
            f"{text!r}: found {ast.unparse(tree)!r}; expected numbers, "
            f"{', '.join(all_nodes_by_name)}, + - * / **, and the functions {', '.join(_FUNCTIONS)}"
        )

    return build(ast.parse(text, mode="eval").body)


def parse_steps(
    steps: Iterable[tuple[str, str]], variable_names: Iterable[str]
) -> list[tuple[str, Node]]:
    """The graphs of named equations.

    Args:
        steps: Name and text of each equation. A text may use `variable_names` and earlier steps.
        variable_names: Names of coefficients and slip.
    """
    node_by_name = {variable_name: name_node(variable_name) for variable_name in variable_names}
    parsed = []
    for step_name, text in steps:
        parsed.append((step_name, parse(text, node_by_name)))
        node_by_name[step_name] = name_node(step_name)
    return parsed


def _all_nodes(roots: Iterable[Node]) -> Iterator[Node]:
    """Nodes with all their operands, each node before its operands."""
    for node in roots:
        yield node
        yield from _all_nodes(node.operands)


def function_names(nodes: Iterable[Node]) -> set[str]:
    """Names of the functions that occur in any of the nodes."""
    operations = {node.operation for node in _all_nodes(nodes)}
    return _FUNCTIONS.keys() & operations


def derivative_by_ln(node: Node, variable_name: str) -> Node:
    """x df/dx of a node f, with the variable x: the change of f per relative change of x."""
    derivatives: dict[Node, Node] = {}

    def derive(f: Node) -> Node:
        """x df/dx of a part of the graph, computed once."""
        if f not in derivatives:
            changes = [derive(operand) for operand in f.operands]
            derivatives[f] = _derivative(f, changes, variable_name)
        return derivatives[f]

    return derive(node)


def _derivative(f: Node, operand_derivatives: Sequence[Node], variable_name: str) -> Node:
    """x df/dx of one operation f, from those of its operands."""
    if not f.operands:
        return f if f.leaf == variable_name else _ZERO
    if f.operation in ("+", "-", "negative"):
        return _BUILDER_BY_OPERATION[f.operation](*operand_derivatives)
    if f.operation in _FUNCTIONS:
        _, derivative = _FUNCTIONS[f.operation]
        return derivative(f.operands[0], f, operand_derivatives[0])
    u, v = f.operands
    du, dv = operand_derivatives
    if f.operation == "*":
        by_first = _proportional_change(f, u, du) or _multiply(du, v)
        by_second = _proportional_change(f, v, dv) or _multiply(u, dv)
        return _add(by_first, by_second)
    if f.operation == "/":
        by_dividend = _proportional_change(f, u, du) or _divide(du, v)
        by_divisor = _proportional_change(f, v, dv) or _multiply(f, _divide(dv, v))
        return _subtract(by_dividend, by_divisor)
    return _derivative_of_power(f, u, v, du, dv)


def _derivative_of_power(f: Node, u: Node, v: Node, du: Node, dv: Node) -> Node:
    """x df/dx of f = u**v."""
    by_base = _proportional_change(f, u, du)
    if by_base is None and isinstance(v.leaf, float):
        by_base = _multiply(_power(u, number_node(v.leaf - 1)), du)
    elif by_base is None:
        by_base = _multiply(f, _divide(du, u))
    by_exponent = _ZERO if dv is _ZERO else _multiply(f, _multiply(dv, _node("log", u)))
    return _add(_multiply(v, by_base), by_exponent)


def _proportional_change(f: Node, operand: Node, operand_derivative: Node) -> Node | None:
    """Change of f by an operand that is constant, or proportional to x or 1/x; else None.

    The change of f is then 0, f or -f, for an f that is proportional to the operand.
    """
    if operand_derivative is operand:
        return f
    if operand_derivative is _ZERO:
        return _ZERO
    if operand_derivative is _negative(operand):
        return _negative(f)
    return None


def straight_line_form(results: Sequence[Node]) -> tuple[list[tuple[str, Node]], list[Node]]:
    """Straight-line form, in which every repeated node is a named step.

    Returns:
        Steps in their order, each a name and a node that may use earlier names; and the results
        that use these names.
    """
    use_counts = Counter(results)
    unvisited = list(use_counts)
    # a name of a step is none of these; the graph has each node once
    taken_names = {node.leaf for node in unvisited if node.operation == "name"}
    while unvisited:
        operands = unvisited.pop().operands
        new_nodes = [operand for operand in set(operands) if operand not in use_counts]
        taken_names |= {node.leaf for node in new_nodes if node.operation == "name"}
        unvisited += new_nodes
        use_counts.update(operands)
    free_names = (name for name in map("x{}".format, count()) if name not in taken_names)

    steps: list[tuple[str, Node]] = []
    written_nodes: dict[Node, Node] = {}

    def write_out(node: Node) -> Node:
        """The node with names of steps for its repeated parts; itself a name if it is repeated."""
        if not node.operands:
            return node
        if node not in written_nodes:
            operands = [write_out(operand) for operand in node.operands]
            # made without `_BUILDER_BY_OPERATION`, so that the order of operations does not change
            written_node = _node(node.operation, *operands)
            if use_counts[node] > 1:
                step_name = next(free_names)
                steps.append((step_name, written_node))
                written_node = name_node(step_name)
            written_nodes[node] = written_node
        return written_nodes[node]

    return steps, [write_out(result) for result in results]


# ------------------------------------------------------------------------------- languages


@dataclass(frozen=True)
class Form:
    """Text of an operation in a language.

    Attributes:
        template: Text with a gap for each operand.
        precedence: 1 sum, 2 product, 3 typeset fraction, 4 power, 5 never needs brackets.
        operand_precedences: Smallest precedence of each operand that needs no brackets.
    """

    template: str
    precedence: int = 5
    operand_precedences: tuple[int, ...] = (0, 0)


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
    """Equations in one language. Operations without a form are written as in Python.

    Attributes:
        forms: Form of each operation or function.
        write_number: Function that writes a number.
        write_name: Function that writes a name.
        brackets: Template of brackets.
    """

    forms: Mapping[str, Form]
    write_number: Callable[[Any], str] = repr
    write_name: Callable[[Any], str] = str
    brackets: str = "({})"

    def write(self, node: Node) -> str:
        """The node as text."""
        return self._text_and_precedence(node)[0]

    def _text_and_precedence(self, node: Node) -> tuple[str, int]:
        """The node as text, and its precedence."""
        if not node.operands:
            write_leaf = self.write_number if isinstance(node.leaf, float) else self.write_name
            return write_leaf(node.leaf), 5
        python_form = _ARITHMETIC.get(node.operation, Form(f"{node.operation}({{}})"))
        form = self.forms.get(node.operation, python_form)
        operands = []
        for operand, needed_precedence in zip(
            node.operands, form.operand_precedences, strict=False
        ):
            text, precedence = self._text_and_precedence(operand)
            if precedence < needed_precedence:
                text = self.brackets.format(text)
            operands.append(text)
        return form.template.format(*operands), form.precedence


NUMPY = Language({})


def compile_function(argument_names: Sequence[str], results: Sequence[Node]) -> Callable[..., Any]:
    """A function of arrays that returns the tuple of results.

    Args:
        argument_names: Names of the arguments.
        results: The results, with the arguments as names.
    """
    steps, step_results = straight_line_form(results)
    lines = [f"{step_name} = {NUMPY.write(node)}" for step_name, node in steps]
    result_texts = ", ".join(NUMPY.write(result) for result in step_results)
    lines.append(f"return ({result_texts},)")
    body = "\n    ".join(lines)
    source = f"def function({', '.join(argument_names)}):\n    {body}\n"
    namespace: dict[str, Any] = {name: function for name, (function, _) in _FUNCTIONS.items()}
    # the source is made from a parsed equation, which has arithmetic only
    exec(compile(source, "<equation>", "exec"), namespace)  # noqa: S102
    return namespace["function"]
