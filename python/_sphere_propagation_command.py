# SPDX-License-Identifier: GPL-3.0-only
"""Starts `sphere-propagation`.

It lies outside the package because importing that loads PyMeshLab: what can go wrong there is to be
said without a traceback, too.
"""

import os
import sys


def main() -> int:
    try:
        try:
            from sphere_propagation.command import main as run

            return run()
        finally:
            # here, and not when Python ends, it is to show that nobody reads any more
            sys.stdout.flush()
    except ImportError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # whoever reads has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141


if __name__ == "__main__":
    sys.exit(main())
