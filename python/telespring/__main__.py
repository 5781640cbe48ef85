"""`python -m telespring` is the command `telespring`."""

import sys

try:
    from telespring.cli import main

    main()
except KeyboardInterrupt:
    sys.exit(130)
