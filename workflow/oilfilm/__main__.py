"""`python -m oilfilm`: the command, where its script is not on PATH."""

import sys

from oilfilm.cli import main

sys.exit(main())
