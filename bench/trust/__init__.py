"""Pieces of trust_study.py and pulls.py."""
