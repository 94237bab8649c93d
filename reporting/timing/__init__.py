"""Speed and memory compared with other implementations and with the targets."""
