"""`python -m helmbench`: the command line."""

from helmbench.bench.cli import main

if __name__ == "__main__":
    main()
