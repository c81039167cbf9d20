"""What bench/reliability.py tries: faults, kills, signals, streams, broken files, and what it holds against the contract."""
