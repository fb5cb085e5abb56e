"""What goes wrong in Swept, as exceptions."""


class Error(Exception):
    """What Swept raises. `kind` says what a program has to decide by: "argument", "not_found", "malformed",
    "empty", "unsupported", "out_of_memory", "cancelled" or "device"; `file` and `field` say where, and may be empty."""

    def __init__(self, message, kind="argument", file="", field="", reason=""):
        super().__init__(message)
        self.kind, self.file, self.field, self.reason = kind, file, field, reason

    def __str__(self):
        return self.args[0] if self.args else ""


class ArgumentError(Error, ValueError):
    """Out of range, contradictory, or of the wrong shape."""


class NotFoundError(Error, LookupError):
    """A file, folder or frame of a sequence is not there, or may not be read."""


class MalformedError(Error, ValueError):
    """A file does not hold what its format says it should."""


class EmptyError(MalformedError):
    """A file says that it holds no points or splats, as one of a sequence may before the first of them is born."""


class OutOfMemoryError(Error, MemoryError):
    """More memory than the machine has, or than `max_bytes` allows."""


_CLASSES = {
    "argument": ArgumentError,
    "not_found": NotFoundError,
    "malformed": MalformedError,
    "empty": EmptyError,
    "out_of_memory": OutOfMemoryError,
}


def exception_of(kind, file, field, reason, message):
    return _CLASSES.get(kind, Error)(message, kind, file, field, reason)
