# SPDX-License-Identifier: GPL-3.0-only
"""python -m sphere_propagation"""

import sys

from .command import main

sys.exit(main())
