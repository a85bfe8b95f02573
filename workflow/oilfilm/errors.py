"""The one exception that stands for a user's mistake."""


class OilfilmError(Exception):
    """A mistake in data or configuration, told in a sentence that the user can act on.

    The message names the file, the row or key, what was found, what was expected and what to do.
    Scripts and the command line print it without a traceback.
    """
