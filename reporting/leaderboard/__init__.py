"""The leaderboard of a suite of identification runs."""
