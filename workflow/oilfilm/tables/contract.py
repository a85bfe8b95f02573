"""What the declaration of a table says of its values, as a digest.

Decides: which changes of a declaration make a table again.
"""

import json
from collections.abc import Iterable
from hashlib import sha256

from oilfilm.tables.campaign_tables import declaration_name
from oilfilm.tables.dictionary import TABLES


def contract_digest(output_names: Iterable[str]) -> str:
    """Digest of the columns of tables: names, types, units, bounds, and whether null is allowed.

    Meanings, notes and caveats count for nothing: they change no value.

    Args:
        output_names: Names of a rule's outputs. Those that are no tables count for nothing.
    """
    tables = [
        TABLES[declaration_name(name)] for name in output_names if declaration_name(name) in TABLES
    ]
    contract = [
        (
            table.name,
            column.name,
            column.dtype,
            column.unit,
            column.nullable,
            column.at_least,
            column.at_most,
            column.allowed,
        )
        for table in tables
        for column in table.columns
    ]
    return sha256(json.dumps(contract).encode()).hexdigest()[:16]
