"""The paper Deng et al. (2026): its claims, constants, rules, figures and tables."""

import oilfilm.paper.tables  # noqa: F401 - makes its tables known
