# SPDX-License-Identifier: GPL-3.0-only
"""What this package raises on purpose; the messages are written for the user.

SpherePropagationError          catch this one to catch them all
  PluginError (ImportError)     PyMeshLab or the plugin is missing, or they do not fit together
  InputError (ValueError)       an argument that no filter needs to see: an array of the wrong
                                shape, a root that is not there
  FileError (OSError)           a file that cannot be read as a mesh or a map
  FilterError (RuntimeError)    a filter refused; the message is the filter's own

SpherePropagationWarning        a result that deserves a look
"""

from __future__ import annotations


class SpherePropagationError(Exception):
    """Base of all errors below."""


class SpherePropagationWarning(UserWarning):
    """A result that deserves a look."""


class PluginError(SpherePropagationError, ImportError):
    """PyMeshLab or the plugin is missing, or they do not fit together."""


class InputError(SpherePropagationError, ValueError):
    """An argument cannot be what is meant: an array of the wrong shape, a root that is missing."""


class FileError(SpherePropagationError, OSError):
    """A file cannot be read as a mesh or a map."""


class FilterError(SpherePropagationError, RuntimeError):
    """A filter refused its input or its parameters, in its own words; `filter` is its name in
    PyMeshLab."""

    def __init__(self, filter: str, message: str):
        super().__init__(message)
        self.filter = filter
