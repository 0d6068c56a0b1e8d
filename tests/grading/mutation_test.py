"""The checks kill every mutant of the solutions that is wrong; kill.py judges all of them, this test a sample."""

import re
import unittest
from concurrent.futures import ThreadPoolExecutor

from tests.grading.kill import KILLED, PAGE, judge, read_equivalents
from tests.grading.mutants import NAMES, all_mutants
from tests.grading.one_stage import READY, Grader
from ch5_backend.course.homework.regions import regions, solution_text
from ch5_backend.course.base.cmake_build import CORES


class Mutation(unittest.TestCase):
    def setUp(self):
        self.mutants = {mutant.id: mutant for mutant in all_mutants()}

    def test_there_are_mutants_of_every_blank(self):
        self.assertGreaterEqual(len(self.mutants), 300)
        blanks = {region.todo for name in NAMES for region in regions(solution_text(name))}
        self.assertEqual({mutant.todo for mutant in self.mutants.values()}, blanks)

    def test_each_differs_from_the_solution_in_its_line_alone(self):
        for mutant in self.mutants.values():
            whole, own = solution_text(mutant.file).splitlines(), mutant.source().decode().splitlines()
            differing = [number for number, pair in enumerate(zip(whole, own), 1) if pair[0] != pair[1]]
            self.assertEqual((differing, len(own)), ([mutant.line], len(whole)), mutant.id)

    def test_the_equivalent_ones_exist_and_have_a_reason(self):
        for name, row in read_equivalents().items():
            self.assertIn(name, self.mutants, f"{PAGE.name}: there is no such mutant")
            self.assertEqual(row["line"], self.mutants[name].text.strip(), name)
            self.assertGreater(len(row["reason"]), 20, name)

    def test_the_page_is_of_these_mutants(self):
        words = PAGE.read_text(encoding="utf-8")
        found = re.search(r"(\d+) mutants: .* (\d+) equivalent, .* (\d+) survive, (\d+) not judged", words)
        self.assertEqual([int(number) for number in found.groups()],
                         [len(self.mutants), len(read_equivalents()), 0, 0], "mend with what kill.py says")

    @unittest.skipUnless(READY, "no Clang: without ./course grade")
    def test_a_sample_is_killed(self):
        count = 100
        grader, wrong = Grader(), [one for name, one in self.mutants.items() if name not in read_equivalents()]
        sample = wrong[len(wrong) // count // 2::len(wrong) // count]
        with ThreadPoolExecutor(CORES) as pool:
            found = list(pool.map(lambda mutant: judge(grader, mutant, seeds=(7,)), sample))
        for mutant, verdict in zip(sample, found):
            self.assertIn(verdict["state"], (*KILLED, "does-not-compile"), mutant.id)
