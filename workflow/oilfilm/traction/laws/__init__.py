"""All traction laws, one line per law. A new law is a file and a line here.

Tables and figures show the laws in this order.

Decides: which laws exist, and their order.
"""

# isort: off
from oilfilm.traction.laws.deng2026 import DENG2026 as DENG2026
from oilfilm.traction.laws.deng2026 import DENG_EXPONENTIAL as DENG_EXPONENTIAL
from oilfilm.traction.laws.wang_deng import WANG_DENG_LOAD as WANG_DENG_LOAD
from oilfilm.traction.laws.wang_deng import WANG_DENG_CRITICAL_LOAD as WANG_DENG_CRITICAL_LOAD
from oilfilm.traction.laws.wang_deng import WANG_DENG_GROUPS as WANG_DENG_GROUPS
from oilfilm.traction.laws.eyring import EYRING as EYRING
from oilfilm.traction.laws.circular import CIRCULAR as CIRCULAR
from oilfilm.traction.laws.rational import RATIONAL_VISCOSITY as RATIONAL_VISCOSITY
from oilfilm.traction.laws.carreau import CARREAU as CARREAU
from oilfilm.traction.laws.tanh import TANH as TANH
