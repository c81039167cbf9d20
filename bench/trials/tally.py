"""Counts of trials by section, verb and fault, and what was against the contract."""

import collections
import threading


class Tally:
    def __init__(self):
        self.rows = collections.defaultdict(collections.Counter)  # (section, fault, verb): outcomes
        self.offences = []  # (section, fault, command, what)
        self.measured = {}  # figures for the page
        self.lock = threading.Lock()
        self.trials = 0

    def add(self, section, fault, verb, outcome, command="", offence=""):
        with self.lock:
            self.rows[section, fault, verb][outcome] += 1
            self.trials += 1
            if self.trials % 500 == 0:
                print(f"{self.trials} trials", flush=True)
            if offence:
                self.offences.append((section, fault, command, offence))
                print(f"AGAINST THE CONTRACT: {section}, {fault}: {command}: {offence}", flush=True)

    def most(self, name, value):
        with self.lock:
            self.measured[name] = max(value, self.measured.get(name, value))

    def count(self, section, outcome=None):
        """Trials of a section; of one outcome if it is given."""
        return sum(sum(row.values()) if outcome is None else row[outcome]
                   for (of, _, _), row in self.rows.items() if of == section)
