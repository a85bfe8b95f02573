"""Fitted laws as the page's script computes them, written from the equations that Python evaluates.

Decides: how the explorer computes mu and its interval in the browser.
"""

from collections.abc import Iterable

from oilfilm.fits.interval import ABSOLUTE_ENDS, RELATIVE_ENDS
from oilfilm.traction.expression import Form, Language, in_steps
from oilfilm.traction.law import Law

_FUNCTIONS = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "asinh", "abs", "sign")
JAVASCRIPT = Language(
    {
        "**": Form("{} ** {}", 4, (5, 5)),
        **{function: Form(f"Math.{function}({{}})") for function in _FUNCTIONS},
    }
)


# mu and its interval at `at`, the conditions of the law and S, which is not negative, by the
# numbers of `explorer.law_of`. `band` is a `Band`, its reach by columns.
_TRACTION = """
function traction(fit, at) {
  const { law, reference, known, internal, band } = fit;
  const dot = (first, second) => first.reduce((total, value, i) => total + value * second[i], 0);
  const design = [1, ...reference.map((value, i) => (known[i] ? Math.log(at[i] / value) : 0))];
  const sizes = [];
  for (let start = 0; start < internal.length; start += design.length) {
    sizes.push(Math.exp(dot(design, internal.slice(start, start + design.length))));
  }
  const { mu, slopes } = LAWS[law](sizes, at.at(-1));
  const gradient = slopes.flatMap((slope) => design.map((value) => slope * value));
  const along = band ? band.reach.map((column) => dot(gradient, column)) : [];
  const bends = fit.two_levels.map(({ condition, low, high }) => {
    const axis = fit.conditions.indexOf(condition);
    const moved = at.with(axis, low * (high / low) ** ((at[axis] - low) / (high - low)));
    return traction({ ...fit, band: null, two_levels: [] }, moved).mu - mu;
  });
  const own = band ? Math.hypot(band.absolute, band.relative * mu, ...along) : NaN;
  const h = own + Math.hypot(...bends);
  const [lower, upper] = mu > 0 ? %s : %s;
  return { mu, lower, upper };
}
"""


def law_script(laws: Iterable[Law]) -> str:
    """JavaScript's `traction(fit, at)`: mu of a fitted law with its interval.

    `LAWS` in it: name -> function of the coefficients' sizes |X| and S that gives mu, and its
    derivatives by each ln|X|.
    """
    ends = tuple(
        f"[{', '.join(map(JAVASCRIPT.write, nodes))}]" for nodes in (RELATIVE_ENDS, ABSOLUTE_ENDS)
    )
    return f"const LAWS = {{\n{''.join(map(_law, laws))}}};\n{_TRACTION % ends}"


def _law(law: Law) -> str:
    steps, (mu, *slopes) = in_steps(law.graphs)
    lines = "".join(f"    const {name} = {JAVASCRIPT.write(node)};\n" for name, node in steps)
    written = ", ".join(map(JAVASCRIPT.write, slopes))
    return (
        f'  "{law.name}": ([{", ".join(law.local_constants)}], S) => {{\n'
        f"{lines}    return {{ mu: {JAVASCRIPT.write(mu)}, slopes: [{written}] }};\n  }},\n"
    )
