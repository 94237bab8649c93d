"""Paper 003: extended state observer, then robust weighted LS-SVR, on a cargo and a patrol vessel."""
