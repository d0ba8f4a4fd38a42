"""Says what is missing where this Python cannot use the package. Any version of Python 3 reads this file."""

import glob
import importlib
import importlib.machinery
import os
import re
import sys


def _check_version() -> None:
    module = os.path.join(os.path.dirname(os.path.abspath(__file__)), "_hgros")
    if any(os.path.exists(module + suffix) for suffix in importlib.machinery.EXTENSION_SUFFIXES):
        return
    built = [re.sub(r".*\.cpython-(\d)(\d+)-.*", r"\1.\2", one) for one in glob.glob(module + ".cpython-*.so")]
    if built:
        raise ImportError("The package hgros in {} was built for Python {}, and this is Python {}.{} ({}). Use "
                          "/usr/bin/python3, or a virtual environment that it has made.".format(
                              os.path.dirname(module), built[0], *sys.version_info[:2], sys.executable))


def _check_protobuf() -> None:
    try:
        import google.protobuf  # noqa: F401
    except ModuleNotFoundError as fault:
        raise ModuleNotFoundError("The package hgros needs google.protobuf, which {} does not find. Install Debian's "
                                  "python3-protobuf and use /usr/bin/python3, or a virtual environment that was made by "
                                  "/usr/bin/python3 -m venv --system-site-packages.".format(
                                      sys.executable), name=fault.name) from None


def _check_interpreter() -> None:
    try:
        interpreters = importlib.import_module("_xxsubinterpreters")
    except ImportError:
        return
    if interpreters.get_current() != interpreters.get_main():
        raise ImportError("The package hgros works only in the main interpreter of a process. Start another process.")


_check_version()
_check_interpreter()
_check_protobuf()
