"""`python -m tautflex`: the command line without its script."""

from tautflex.cli import main

raise SystemExit(main())
