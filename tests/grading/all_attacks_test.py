"""Every hostile submission of attacks_test.py, which takes every twelfth."""

from tests.grading import attacks_test


class AllAttacks(attacks_test.Attacks):
    STEP = 1
