"""The exception for a mistake of the user."""


class OilfilmError(Exception):
    """A mistake in data or configuration, as a sentence that the user can act on.

    The message names the file, the row or key, what was found, what was expected and what to do.
    Scripts and the command line print it without a traceback.
    """
