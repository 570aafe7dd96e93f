"""`python -m rbs_core` is the same as `rbs`."""

import sys

from rbs_core.command import main

if __name__ == "__main__":
    sys.exit(main())
