"""OpenCascade writes to standard output from C++; here it is kept from doing so."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from OCP.Message import Message, Message_Gravity


@contextmanager
def quiet() -> Iterator[None]:
    """Keep everything but failures off standard output: banners, statistics, warnings."""
    printers = list(Message.DefaultMessenger_s().Printers())
    levels = [printer.GetTraceLevel() for printer in printers]
    try:
        for printer in printers:
            printer.SetTraceLevel(Message_Gravity.Message_Fail)
        yield
    finally:
        for printer, level in zip(printers, levels, strict=True):
            printer.SetTraceLevel(level)


@contextmanager
def silent() -> Iterator[None]:
    """Keep failures off it as well, where they are told in other words."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    try:
        for printer in printers:
            messenger.RemovePrinter(printer)
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)
