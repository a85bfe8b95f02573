"""Traction laws: each is one module; adding one touches its module and this list."""

from oilfilm.traction.deng2026 import Deng2026
from oilfilm.traction.law import Law

LAWS: dict[str, Law] = {law.name: law for law in (Deng2026(),)}
