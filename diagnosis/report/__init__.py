"""The only maker of findings, lines of the bank and verdicts."""
