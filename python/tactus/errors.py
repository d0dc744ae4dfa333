"""Errors of the engine."""

import re


class Error(Exception):
    """Something is wrong with a file, an argument, or what was asked for.

    str(error) is one line for each error, "file:line:column: what is wrong; remedy", as the program prints them.

    code     what kind of error, such as "UnknownName", "UnitMismatch", "OutOfRange", "Syntax", "Cycle", "BadFile"
    file     the file, or "<text>" for a graph that was given as text; None if it is about an argument
    line     from 1, or None
    column   from 1, or None
    what     what is wrong
    remedy   what to do, or ""
    where    file, line and column, or the argument, as text
    errors   all errors that were found, each an Error; the attributes above are those of the first
    """

    def __init__(self, code, where, what, remedy="", errors=None):
        self.code, self.where, self.what, self.remedy = code, where, what, remedy
        place = re.fullmatch(r"(.*?)(?::(\d+):(\d+))?", where, re.S)
        of_file = where and not where.startswith(("argument ", "--"))
        self.file = place[1] if of_file else None
        self.line, self.column = (int(number) if number else None for number in place.group(2, 3))
        self.errors = errors or [self]
        super().__init__("\n".join(error._text() for error in self.errors))

    def _text(self):
        return (f"{self.where}: " if self.where else "") + self.what + (f"; {self.remedy}" if self.remedy else "")

    @classmethod
    def of(cls, found):
        """One exception for all of [(code, where, what, remedy), …]."""
        errors = [cls(*one) for one in found]
        if len(errors) == 1:
            return errors[0]
        first = errors[0]
        return cls(first.code, first.where, first.what, first.remedy, errors)

    def __reduce__(self):
        return _again, ([(one.code, one.where, one.what, one.remedy) for one in self.errors],)


def _again(found):
    return Error.of(found)


class RunWarning(RuntimeWarning):
    """A run had something to report: the drive guard acted, a node produced non-finite values, or inputs were non-finite."""


class FileWarning(UserWarning):
    """Something in a file is allowed and probably not meant."""
