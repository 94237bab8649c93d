"""The bench: suites, runner, scores, results store, leaderboard, report and the command line.

`suites` reads what is to be run (data files), `problems` makes records and truth of a row, `runner` enumerates (`plan`)
and executes (`run`), `pool` holds the workers, `scores` judges one estimate, `store` keeps every finished run,
`leaderboard` aggregates and `report` renders.  `reproduction` computes the papers' tables again.  `identify` serves a
user's own records; `cli` only parses and calls.
"""
