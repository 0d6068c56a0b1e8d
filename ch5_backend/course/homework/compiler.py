"""What the compiler and the linker say of a student's file, in a student's words."""

import os
import re
from pathlib import Path

from ..base.cmake_build import HOMEWORK, ROOT
from ..base.language import sentence
from .regions import solution_text
from .diagnosis import SHOWN_LINES, Verdict

# The compiler's words on braces. A function that begins inside of another, or a file that ends inside of one:
OPEN_BRACE = r"qualified-id in declaration before|function-definition is not allowed here|function definition is not " \
             r"allowed here|expected ['‘]}['’] at end of input|expected '}'"
SPARE_BRACE = r"expected declaration before ['‘]}['’]|extraneous closing brace"
# Of the library of C++20 and later:
NEWER = "views|ranges|span|format|print|println|numbers|midpoint|lerp|ssize|erase_if|bit_cast|expected|remove_cvref_t"
# What the compiler says of a typical slip, in that line of the student's file.
SLIPS = [
    (r"unresolved overloaded function type|invalid use of (?:non-static )?member function|reference to non-static member function must be called", "compiler.call_without_brackets"),
    (r"discards qualifiers|no viable overloaded operator\[\] for type 'const", "compiler.const"),
    (r"\b(?:cout|cerr|endl)['’] (?:was not declared|is not a member|in namespace)|undeclared identifier '(?:cout|cerr|endl)", "compiler.printing"),
    (r"YOU_MIXED_MATRICES_OF_DIFFERENT_SIZES", "eigen.assignment_sizes"),
    (r"INVALID_MATRIX_PRODUCT|INVALID_VECTOR_VECTOR_PRODUCT", "eigen.product_sizes"),
    (r"operand type is .*DiagonalWrapper|argument type '.*DiagonalWrapper", "compiler.minus_diagonal"),
    (r"operator[+]['’] \(operand type is|argument type '.*\bMat.*to unary expression", "compiler.plus_equals"),
    (r"call to ['‘](?:std::)?(?:max|min|clamp)\b", "compiler.two_types"),
    (r"ScalarBinaryOpTraits|YOU_MIXED_DIFFERENT_NUMERIC_TYPES", "compiler.float"),
    (r"(?:operand types are|binary expression) .*ArrayWrapper", "compiler.array"),
    (r"conflict marker", "compiler.conflict_marker"),
    (r"stray ['‘]`['’] in program", "compiler.markdown"),
    (r"operands .*['‘]operator\^['’]", "compiler.power"),
    (r"MatrixSquareRoot|MatrixExponential|MatrixPower|MatrixLogarithm", "compiler.entry_by_entry"),
    (r"operator/['’] \(operand types are .* and ['‘][^'’]*(?:Eigen|Mat|Vec)", "compiler.division"),
    (r"operator=['’] \(operand types are .*Eigen.* and ['‘](?:int|double)['’]", "compiler.number_assigned"),
    (r"operator[-+]=?['’] \(operand types are .*Eigen.* and ['‘](?:int|double)['’]", "compiler.number_added"),
    (r"ONLY_FOR_VECTORS|VECTOR_METHOD_ON_A_MATRIX", "compiler.of_vectors"),
    (r"call to ['‘][^'’]*\b(?:block|segment|head|tail)(?:\(|['’])", "compiler.block"),
    (rf"['‘]std::(?:{NEWER})['’] has not been declared|['‘](?:{NEWER})['’] (?:is not a member of|in namespace) ['‘]std"
     r"|no member named ['‘](?:contains|starts_with|ends_with)['’]", "compiler.newer"),
]
FULL_WIDTH = {chr(code): chr(code - 0xFEE0) for code in range(0xFF01, 0xFF5F)} | {"。": ".", "“": '"', "”": '"', "‘": "'", "’": "'"}
OF_A_PAGE = {"−": "-", "–": "-", "—": "-", "×": "*", "·": "*", "⋅": "*"}  # as formulas have them
INVISIBLE = "\u00a0\u2002\u2003\u2009\u200b\u202f\u2060\u3000\ufeff"      # spaces, or nothing
UNDEFINED = r"undefined (?:reference to|symbol:) [`'‘]?(?:ch5::)?((?!vtable|typeinfo)[\w:]+)\("

TWICE = r"(?:multiple definition of [`'‘]|duplicate symbol: )(?:ch5::)?([\w:~]+)"


def shown(path: Path) -> str:
    """A path as a reader finds it: from the project's folder, else from the current folder, else whole."""
    for folder in (ROOT, Path.cwd()):
        if path.is_relative_to(folder):
            return str(path.relative_to(folder))
    return str(path)


def shorten(line: str) -> str:
    """Without the project's folder, in which everything lies."""
    line = line.replace(str(HOMEWORK) + os.sep, shown(HOMEWORK) + os.sep)
    return line.replace(str(ROOT) + os.sep, "").strip("\n")


def does_not_compile(file: str, output: str, content) -> Verdict:
    """The verdict on `file`, which holds these bytes (None: there is no such file), from all that the build has printed."""
    lines = [line for line in output.splitlines() if not line.startswith("ninja: build stopped")]
    patterns = [rf"{re.escape(file)}:\d+:(\d+:)? (fatal )?error: ", r":\d+: (fatal )?error: ", "multiple definition|undefined reference", "error: ",
                "FAILED|ninja: "]
    first = next((i for pattern in patterns for i, line in enumerate(lines) if re.search(pattern, line)), 0)
    cause = explain_file(file, content) or explain_linker(file, output, content)
    if not cause and lines:
        calling = where_called(file, lines, first) if not re.search(patterns[0], lines[first]) else ""
        words = f"{calling}: " + re.sub(r"^.*?error: ", "", lines[first]) if calling else lines[first]
        cause = explain_slip(calling or lines[first], lines[first], content) \
            or (not calling and (explain_header(lines[first]) or explain_braces(file, lines, content))) or {"quoted": shorten(words)}
    shown_lines = "\n".join(shorten(line) for line in lines[first:first + SHOWN_LINES])
    return Verdict("does-not-compile", {"cause": cause or sentence("compiler.silent")}, shown_lines)


def warnings(path: Path, output: str) -> list:
    """What the compiler warns of in this file, [41, "suggest parentheses …"], from all that the build has printed."""
    found = re.findall(rf"^{re.escape(str(path))}:(\d+):\d+: warning: (.*?)(?: \[-W[\w=+-]+\])?$", output, re.MULTILINE)
    return [[int(line), words] for line, words in dict.fromkeys(found)]


def explain_file(file: str, content):
    """What is wrong with the file as a whole, or None."""
    if content is None:
        return sentence("compiler.file_missing", file=file, command=f"./course reset {file}")
    if b"\0" in content[:200] or content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return sentence("compiler.utf16", file=file)
    return None if content.strip() else sentence("compiler.file_empty", file=file, command=f"./course reset {file}")


def explain_linker(file: str, output: str, content: bytes):
    """Which function is there twice, or not at all, or None."""
    if twice := re.search(TWICE, output):
        return sentence("compiler.own_main" if twice[1] == "main" else "compiler.defined_twice", file=file, name=twice[1])
    missing = re.search(UNDEFINED, output)
    if not missing or re.search(r":\d+: (fatal )?error: ", output):
        return None
    name = missing[1]
    if f"{name}(" not in solution_text(file):
        return sentence("compiler.no_body", name=name, file=file)
    if re.search(rf"\b{re.escape(name)}\(", content.decode("utf-8", "replace")):
        return sentence("compiler.function_changed", name=name, file=file)
    return sentence("compiler.function_missing", name=name, file=file, command=f"./course reset {file}")


def explain_slip(place: str, error: str, content: bytes):
    """A typical slip in the line of the student's file from which the error comes, or None."""
    found = re.search(r"(?<![^/:])([^/:]+:(\d{1,9})):\d+", place)  # a name from its beginning on, or a long one takes ages
    code = content.decode("utf-8", "replace").splitlines() if found else []
    line = code[int(found[2]) - 1].partition("//")[0] if found and 0 < int(found[2]) <= len(code) else ""
    line, cause = re.sub(r'"[^"]*"', '""', line), None
    if wide := next((letter for letter in line if letter in FULL_WIDTH), None):
        cause = sentence("compiler.full_width", wide=wide, narrow=FULL_WIDTH[wide])
    elif sign := next((letter for letter in line if letter in OF_A_PAGE), None):
        cause = sentence("compiler.of_a_page", sign=sign, meant=OF_A_PAGE[sign])
    elif hidden := next((letter for letter in line if letter in INVISIBLE), None):
        cause = sentence("compiler.invisible", code=f"U+{ord(hidden):04X}")
    elif "?" in line and ":" not in line.partition("?")[2]:
        cause = sentence("compiler.question_mark")
    else:
        cause = next((sentence(name) for words, name in SLIPS if re.search(words, error)), None)
    return cause and sentence("compiler.at", place=found[1], cause=cause)


def explain_header(error: str):
    """An error in a file of the project's that is not the student's, or None."""
    found = re.search(rf"{re.escape(str(ROOT))}/((?:ch5_backend|solutions)/[^:]+):\d+", error)
    return found and sentence("compiler.not_your_file", place=shorten(found[0]), command=f"git checkout {found[1]}")


def where_called(file: str, lines: list, error: int) -> str:
    """The line of the student's file from which a library's own code was asked for, when the error stands there: GCC tells
    it above the error, Clang below."""
    words = rf"({re.escape(file)}:\d+:\d+): (?: *required from here|note: in instantiation of .* requested here)"
    for line in (*reversed(lines[:error]), *lines[error:]):
        if found := re.search(words, line):
            return found[1]
    return ""


def explain_braces(file: str, lines: list, content):
    """A brace that is missing or too many, with the line where it shows first, or None."""
    errors = [found for line in lines if (found := re.search(rf"({re.escape(file)}:(\d+)):\d+: error: (.*)", line))]
    code = re.sub(r'"[^"\n]*"|//.*', "", (content or b"").decode("utf-8", "replace"))
    told = errors if code.count("{") != code.count("}") else errors[:1]
    for words, name in ((OPEN_BRACE, "compiler.brace_missing"), (SPARE_BRACE, "compiler.brace_too_many")):
        if any(re.search(words, error[3]) for error in told):
            return sentence(name, place=errors[0][1], n=errors[0][2])
    return None
