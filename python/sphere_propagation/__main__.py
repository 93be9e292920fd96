"""python -m sphere_propagation"""
import sys

from .command import main

sys.exit(main())
