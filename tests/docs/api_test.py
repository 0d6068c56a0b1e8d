"""The pages of the API: made without a warning, led to by the index of formulas, read without a network."""

import os
import re
import sys
import unittest
from pathlib import Path

from tests.docs.engineers_test import rows
from tests.docs.markdown import ROOT, read
from tests.project import run

from ch5_backend.course.documents import api, doxygen_filter, formulas
from slides import browser

PAGES = Path(os.environ.get("CH5_API", ROOT / "out/api")).resolve()


def undocumented():
    """What engineers call and nothing describes, a text each: classes, enumerations and functions outside of kernels.

    Declarations without an empty line between them share the words above the first.
    """
    said = api.doxygen(GENERATE_HTML="NO", EXTRACT_ALL="NO", WARN_IF_UNDOCUMENTED="YES", WARN_AS_ERROR="NO").stderr
    what = r"Compound .*|Member .*\(enumeration\) of .*|Member .*\(function\) of namespace ch5"
    found = []
    for path, line, name in re.findall(rf"^(\S+\.h):(\d+): warning: ({what}) is not documented", said, re.M):
        above = Path(path).read_text(encoding="utf-8").splitlines()[int(line) - 2::-1]
        together = above[:above.index("")] if "" in above else above
        if "::kernels::" not in name and not any(one.lstrip().startswith("///") for one in together):
            found.append(f"{Path(path).relative_to(ROOT)}:{line}: {name}")
    return found


class Api(unittest.TestCase):
    def setUp(self):
        if not PAGES.exists():
            self.skipTest(f"{PAGES} is not there: ./course docs makes it, and says what it lacks")
        self.front = read(PAGES / "index.html")

    def test_index_of_formulas_leads_to_the_functions(self):
        table = self.front.partition("Index of formulas")[2]
        links = set(re.findall(r'<a class="el" href="([^"#]+)', table))
        self.assertGreater(len(links), 40)
        for link in links:
            self.assertTrue((PAGES / link).is_file(), link)
        self.assertEqual(table.count("<tr"), len(rows()) + 1)
        self.assertRegex(table, r'href="classch5_1_1Problem\.html#\w+"[^>]*>Problem::MakeHessian<')

    def test_formulas_are_set_offline(self):
        self.assertNotRegex(self.front, r'(src|href)="(https?:)?//(?!www\.doxygen\.org)')
        for page, least in (("index", 40), ("so3_8h", 2), ("classch5_1_1EdgeImu", 9), ("structch5_1_1Step", 1), ("loss_8h", 1)):
            wanted = len(re.findall(r"\\\(.+?\\\)|\\\[.+?\\\]", read(PAGES / f"{page}.html")))
            self.assertGreater(wanted, least, page)
            try:
                dom = browser.headless("--virtual-time-budget=20000", "--dump-dom", (PAGES / f"{page}.html").as_uri())
            except browser.BuildError as missing:
                self.skipTest(str(missing))
            self.assertEqual(dom.count("<mjx-container"), wanted, page)
            self.assertNotIn("data-mjx-error", dom, page)

    def test_unicode_becomes_tex(self):
        for line, wanted in (
                ("S and b_p − Σ_l H_pl H_ll⁻¹ b_a,j of it", r"S and \f$b_{p}\f$ − \f$\sum _{l}\f$ \f$H_{pl}\f$ \f$H_{ll}^{-1}\f$ \f$b_{a,j}\f$ of it"),
                ("T_A_B maps (see `H_pp_`, δx_k) JᵀW_ρJ", r"\f$T_{AB}\f$ maps (see `H_pp_`, \f$\delta x_{k}\f$) Jᵀ\f$W_{ρ}\f$J"),
                ("@param q_z, p_z  the measured T_z", r"@param q_z, p_z  the measured \f$T_{z}\f$"),
                ("Σ_lm, the sum Σ_l of \"w_x\"", r"\f$\Sigma _{lm}\f$, the sum \f$\sum _{l}\f$ of " '"w_x"'),
                ("fills a 3×3 matrix A in place, dim_m last", "fills a 3×3 matrix A in place, dim_m last")):
            self.assertEqual(formulas.set_line(line), wanted)
        self.assertEqual(formulas.set_block("///   S = H_pp,  where it is\n"), "/// \\f[S = H_{pp},\\quad \\text{where }\\text{it }\\text{is}\\f]\n")
        self.assertIn(r"///< \f$H_{rr}\f$ − \f$H_{rm}\f$ \f$H_{mm}^{-1}\f$ \f$H_{mr}\f$", doxygen_filter.header("MatXX H;  ///< H_rr − H_rm H_mm⁻¹ H_mr", doxygen_filter.BACKEND / "a.h"))
        drawing = "///   │ H_pp │\n"
        self.assertEqual(formulas.set_block(drawing), drawing.replace("/  ", "/      "))

    def test_a_class_has_the_words_at_the_head_of_its_header(self):
        page = read(PAGES / "classch5_1_1SymmetricBlockMatrix.html")
        self.assertIn("symmetric matrix of small blocks", page)
        self.assertRegex(page, r'<pre class="fragment"[^>]*>\s+┌────┐', "drawings stay as they are")

    def test_nothing_that_engineers_call_is_without_words(self):
        self.assertEqual(undocumented(), [])

    def test_a_folder_of_other_things_is_not_replaced(self):
        done = run(sys.executable, "-m", "ch5_backend.course", "docs", "--out", ROOT / "tests")
        self.assertEqual(done.returncode, 2)
        self.assertIn("holds something else", done.stderr)
