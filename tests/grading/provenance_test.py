"""What may stand in a graded file, decided on what the compilers have made of it; attacks_test.py runs the attacks."""

import unittest

from ch5_backend.course.homework.mended import blanks_of, mended
from ch5_backend.course.grading.provenance import closed_to, foreign_code, foreign_file, usual_code
from ch5_backend.course.homework.regions import FILES, fill, solution_text


class ForeignCode(unittest.TestCase):
    def test_intermediate_code(self):
        for line, word in (('module asm "ret"', "asm"), ('  call void asm sideeffect "nop", "~{memory}"()', "asm"),
                           ('  %1 = call i32 asm alignstack inteldialect "mov", "=r"()', "asm"),
                           ('@a = global i8 0, section ".text", align 1', "section"), ('@f = ifunc i32 (), ptr @g', "ifunc"),
                           ('@s = constant [9 x i8] c" asm \\22nop\\22 , section \\22x\\22"', ""),
                           ('  call void asm sideeffect "", "r,~{memory}"(double %0)', ""),
                           ('@llvm.used = appending global [1 x i8*] [i8* @a], section "llvm.metadata"', ""),
                           ('  call void asm sideeffect "#end of a kernel of Eigen", "~{flags}"()', ""),
                           ('  call void asm sideeffect "#\\0Aret", "~{flags}"()', "asm"),
                           ("define void @asm() {", "")):
            self.assertEqual(foreign_code(line + "\n", True), word, line)

    def test_preprocessed_text(self):
        for line, word in (('asm("nop; nop");', "asm"), ('__asm__ volatile ("nop" : : );', "__asm__"), ('__asm ("a" " b");', "__asm"),
                           ('int f() __asm__ ("" "f64");', ""), ('const char* s = "asm(\\"nop nop\\")";', ""),
                           ('auto s = R"q(asm("nop nop"))q";', ""), ("int n = 1'000; int asm_count = 0;", ""),
                           ('__attribute__((section (".text"))) int x;', "section"), ("section(3);", "")):
            self.assertEqual(foreign_code(line, False), word, line)
        self.assertEqual(foreign_code('__asm__ volatile ("bswap %0" : "=r" (x));', False,
                                      usual_code('__asm__  volatile ("bswap %0" : "=r" (x));')), "")

    def test_long_constants(self):
        for count, word in ((100, ""), (101, "constants")):
            own = [str(10**11 + k) for k in range(count)]
            for is_ir, form in ((True, "  store volatile i64 {}, i64* %2\n"), (False, "volatile auto a = {}ull;\n")):
                self.assertEqual(foreign_code("".join(map(form.format, own)), is_ir, frozenset(["99999999999"])), word)

    def test_files_that_were_read(self):
        rule = "made.ll: /submission/a.cc \\\n  /usr/include/c++/12/vector /course/x.h"
        self.assertEqual(foreign_file(rule, ("/course/",)), "")
        self.assertEqual(foreign_file(rule + " /etc/passwd", ("/course/",)), "/etc/passwd")
        self.assertEqual(foreign_file(rule + " /usr/include/../share/x", ("/course/",)), "/usr/include/../share/x")
        self.assertEqual(foreign_file(rule + " /of\\ a\\ class$$/b\\#.h", ("/course/", "/of a class$/")), "", "as make writes blanks")
        self.assertEqual(foreign_file(rule + " /of\\ a/b.h", ("/course/", "/of")), "")
        self.assertEqual(foreign_file(rule + " /no\\ such/b.h", ("/course/", "/of")), "/no such/b.h")


class ClosedTo(unittest.TestCase):
    """The solution's lines would stand at @."""

    def closed(self, text: str) -> bool:
        return closed_to(text.replace("@", ""), [text.index("@")])

    def test_no_line_around_reads_them(self):
        for text in ("f(@", "assert(\n@)", "/* @ */", 'R"(@)"', "#define S(x) #x\n@", "%:define S(x) #x\n@", "a\\\n@", "x[@]",
                     '#include "/submission/problem.cc"\n@', "#include __FILE__\n@", '#embed "a"\n@', "#if __LINE__ > 3\n@\n#endif",
                     '_Pragma("GCC poison Eigen") @', "// splice ??/\n@", '"open @', "{ } } @", "/* never closed\n@",
                     "// x\r#define S(x) #x\r@", "// x\r/* @ */"):
            self.assertFalse(self.closed(text), text)

    def test_what_people_write_is_closed(self):
        for text in ("#include <vector>  // for rows\nvoid f() {\n@\n}", '#include "ch5_backend/graph/loss.h"\nint x = 1\'000; {@',
                     "// don't\n/* it's ( */ char c = '('; @", 'auto s = "/* ( #define"; {@}'):
            self.assertTrue(self.closed(text), text)

    def test_each_solution_is(self):
        for file in FILES:
            text = fill(solution_text(file), lambda region: region.solution)
            starts = [0]
            for line in text.splitlines(keepends=True):
                starts.append(starts[-1] + len(line))
            spans = blanks_of(file, text)
            self.assertTrue(spans)
            self.assertTrue(closed_to(text, [starts[line] for span in spans.values() for line in span]), file)

    def test_lines_keep_their_numbers(self):
        text = fill(solution_text("problem.cc"), lambda region: "// one\n")
        lines = mended("problem.cc", text, ["1.2c"]).splitlines()
        at = next(k for k, line in enumerate(lines) if line.startswith("#line "))
        self.assertEqual(lines[at + 1], text.splitlines()[int(lines[at].split()[1]) - 1])
