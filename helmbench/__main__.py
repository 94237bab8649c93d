"""`python -m helmbench`: the command line."""

from helmbench.cli import main

if __name__ == "__main__":
    main()
