"""The paper's claims, each a named check: holds, holds in part, fails, or cannot be checked."""
