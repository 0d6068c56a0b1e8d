"""Every hostile submission of attacks_test.py, which takes every twelfth, with both engines of the sandbox."""

import unittest

from tests.grading import attacks_test


class AllAttacks(attacks_test.Attacks):
    STEP = 1


@unittest.skipIf(attacks_test.NO_OWN_USER, attacks_test.NO_OWN_USER)
class WithOwnUser(AllAttacks):
    SANDBOX = "landlock"
