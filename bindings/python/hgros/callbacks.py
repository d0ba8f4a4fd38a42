"""What a function must be to be called with what comes."""

from __future__ import annotations

import inspect
from typing import Any


def check_callback(callback: Any, arguments: int, owner: str) -> None:
    """Raises TypeError if it cannot be called with so many arguments, or if it is a coroutine function."""
    if not callable(callback):
        raise TypeError(f"The callback of {owner} cannot be called: {callback!r}.")
    if inspect.iscoroutinefunction(callback) or inspect.iscoroutinefunction(getattr(callback, "__call__", None)):
        raise TypeError(f"The callback of {owner} is an `async def`, which nothing awaits. Give a `def` that starts it, "
                        "for example with asyncio.ensure_future(...), or use `async for` over robot.messages(...).")
    try:
        signature = inspect.signature(callback)
    except (TypeError, ValueError):
        return  # Some functions of C do not tell it.
    try:
        signature.bind(*[None] * arguments)
    except TypeError as fault:
        raise TypeError(f"The callback of {owner} is called with {arguments} argument{'s' * (arguments > 1)}, and takes "
                        f"{signature}: {fault}.") from None
