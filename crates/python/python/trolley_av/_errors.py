"""The exceptions of this package."""


class TrolleyError(Exception):
    """Something failed.

    Attributes:
        what: what is wrong, with its place.
        remedy: what to do about it, or None.
        exit_code: the exit code of the command line for failures of this kind.
    """

    def __init__(self, what, remedy=None, exit_code=70):
        super().__init__(what if remedy is None else f"{what}\n  remedy: {remedy}")
        self.what = what
        self.remedy = remedy
        self.exit_code = exit_code

    def __reduce__(self):
        return type(self), (self.what, self.remedy, self.exit_code)


class InputError(TrolleyError, ValueError):
    """An argument, a file or a setting is at fault; nothing was computed."""
