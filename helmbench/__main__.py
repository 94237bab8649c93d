"""`python -m helmbench`: the command line."""

import sys

try:
    from helmbench.cli import main
except ModuleNotFoundError as error:  # the code of a checkout, and a Python without what it needs
    from helmbench.models.extras import missing_here

    sys.stderr.write(f"helmbench: {missing_here(error)}\n")
    sys.exit(2)

if __name__ == "__main__":
    main()
