"""The study of Deng et al. (2026): its claims, constants, rules, figures and tables.

- `deng2026_study.printed("4102")` is the traction law with the constants that the paper prints.
"""

import deng2026_study.tables  # noqa: F401 - makes its tables known
from deng2026_study.printed_law import printed

__all__ = ["printed"]
