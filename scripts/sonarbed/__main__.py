"""`python -m sonarbed`."""

import sys

from sonarbed.cli import main

sys.exit(main())
