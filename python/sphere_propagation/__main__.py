# SPDX-License-Identifier: GPL-3.0-only
"""python -m sphere_propagation"""

import sys

from _sphere_propagation_command import main

sys.exit(main())
